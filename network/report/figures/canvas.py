"""What all figures are drawn on: colours and line styles, panels on one time axis, names as text, saving.

matplotlib is imported when the first figure is made, and used without pyplot: no state stays behind.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from network.platform.files import replace_file
from network.platform.quantities.number_format import pretty
from network.platform.quantities.units import Unit, difference, unit
from network.platform.refusal import Spot, refuse

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Dashes: TypeAlias = "str | tuple[int, tuple[float, ...]]"

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Okabe and Ito's colours that all readers tell apart, without the yellow that white paper swallows."""
DASHES: tuple[Dashes, ...] = ("solid", (0, (6.0, 2.0)), (0, (4.0, 1.5, 1.0, 1.5)), (0, (1.5, 1.2)))
INK, GREY, FAINT = "#1a1a1a", "#6f6f6f", "#d9d9d9"
DPI = 120
WIDTH = 10.0
"""Inches: 1200 pixels."""
EDGE, BETWEEN = 0.15, 0.16
"""Left of the title; between panels [in]."""
FONT, SMALL, TITLE = 8.5, 7.5, 11.5
FORMATS = (".png", ".svg", ".pdf")


def look(i: int) -> tuple[str, Dashes]:
    """Colour and line style of the i-th line: the first 24 all differ, and neighbours differ in both."""
    return PALETTE[i % len(PALETTE)], DASHES[(i + i // 12) % len(DASHES)]


def shorten(name: str, most: int = 28) -> str:
    """A name on one line, its middle left out where it is long: both ends tell names apart."""
    line = " ".join(name.split())
    if len(line) <= most:
        return line
    head = most * 2 // 3
    return f"{line[:head].rstrip()}…{line[head + 1 - most :].lstrip()}"


def literal(text: str) -> str:
    """Text that matplotlib draws as it stands: a $ is no formula."""
    return text.replace("$", r"\$")


def name_text(name: str, most: int = 28) -> str:
    return literal(shorten(name, most))


def gap_unit(unit_text: str) -> Unit:
    """The unit of a difference, called K for °C."""
    return difference(unit("K" if unit_text == "degC" else unit_text))


@lru_cache(maxsize=4096)
def text_size(text: str, size: float, bold: bool = False) -> tuple[float, float]:
    """Width and height of one line of text [pt]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(size=size, weight="bold" if bold else "normal")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        width, _, _ = text_to_path.get_text_width_height_descent(text.replace(r"\$", "$"), font, ismath=False)
    return float(width), size * 1.25


def new_figure(height: float) -> Figure:
    """An empty figure 10 in wide."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def add_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place in inches, with a thin grid and no frame on the right and above."""
    from matplotlib.ticker import MaxNLocator

    full_width, full_height = figure.get_size_inches()
    place = (left / full_width, bottom / full_height, width / full_width, height / full_height)
    axes = figure.add_axes(place)
    axes.grid(True, axis="y", linewidth=0.4, color=FAINT)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=max(3, int(height * 4)), steps=[1, 2, 2.5, 5, 10], min_n_ticks=2))
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=SMALL, length=2.5, width=0.6, color=GREY, labelcolor=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set(linewidth=0.6, color=GREY)
    return axes


def write_title(figure: Figure, title: str, below: str = "") -> None:
    """Title and the line below it, cut to the width of the figure."""
    width, height = figure.get_size_inches()
    lines = ((title, TITLE, "bold", INK, 0.3), (below, FONT, "normal", GREY, 0.52))
    for text, size, weight, colour, down in lines:
        if text:
            cut = _cut_to(text, size, weight == "bold", (width - 2 * EDGE) * 72)
            figure.text(EDGE / width, 1 - down / height, literal(cut), fontsize=size, fontweight=weight, color=colour)


def _cut_to(text: str, size: float, bold: bool, points: float) -> str:
    length = len(text)
    while text_size(shorten(text, length), size, bold)[0] > points and length > 20:
        length -= 4
    return shorten(text, length)


def size_of(axes: Axes) -> tuple[float, float]:
    """Width and height of the axes [in]."""
    figure, place = cast("Figure", axes.get_figure()), axes.get_position()
    width, height = figure.get_size_inches()
    return float(place.width * width), float(place.height * height)


def label_y(axes: Axes, quantity: str, unit_text: str) -> None:
    """Names the axis, with its unit, in a line with the panels above and below."""
    axes.set_ylabel(f"{literal(quantity)} [{pretty(unit_text)}]".strip(), fontsize=FONT, color=INK)
    axes.yaxis.set_label_coords(-0.52 / size_of(axes)[0], 0.5)


def headline(axes: Axes, text: str, colour: str = INK) -> None:
    """A line above the axes. (A title of matplotlib would be moved about at the cost of a second drawing.)"""
    above = 1 + 0.05 / size_of(axes)[1]
    axes.text(0, above, text, transform=axes.transAxes, fontsize=FONT, color=colour, va="bottom")


def save(figure: Figure, path: str | Path) -> Path:
    """Writes the figure as .png, .svg or .pdf; the file is replaced as a whole, or left as it was. Raises Refused."""
    path = Path(path)
    suffix = path.suffix.lower() or ".png"
    if suffix not in FORMATS:
        raise refuse(Spot(str(path)), "is no picture that can be drawn", f"end it in {', '.join(FORMATS)}")
    undated = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    quick: dict[str, Any] = {"pil_kwargs": {"compress_level": 3}} if suffix == ".png" else {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a letter that the font lacks is drawn as a box
        form: dict[str, Any] = {"format": suffix[1:], "dpi": DPI, "metadata": undated[suffix], **quick}
        replace_file(path, lambda beside: figure.savefig(beside, **form))
    return path


def stack_panels(heights: Sequence[float], right: float = 1.7) -> tuple[Figure, list[Axes]]:
    """Panels of these heights [in] under one another, with room for a title above and labels on the right [in]."""
    left, top, bottom = 0.8, 0.75, 0.5
    figure = new_figure(top + sum(heights) + BETWEEN * (len(heights) - 1) + bottom)
    high = figure.get_size_inches()[1] - top
    panels = []
    for height in heights:
        panels.append(add_axes(figure, left, high - height, WIDTH - left - right, height))
        high -= height + BETWEEN
    return figure, panels
