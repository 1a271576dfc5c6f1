"""What a calibration did to the parameters, and how sure it leaves the tool centre point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.calibration.uncertainty import LEVEL
from network.catalogue.declaration.declare import Array, Indices
from network.platform.quantities.number_format import number
from network.platform.quantities.text_table import format_shift
from network.platform.quantities.unit_values import in_own_unit
from network.report.figures.canvas import (
    FONT,
    GREY,
    INK,
    PALETTE,
    SMALL,
    WIDTH,
    add_axes,
    gap_unit,
    label_y,
    name_text,
    new_figure,
    stack_panels,
    text_size,
    write_title,
)
from network.report.figures.comparison_figure import draw_measured
from network.report.figures.lines import clock, decimate_together, set_clock

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOVED, FAR = PALETTE[0], PALETTE[1]
LINE = 0.2
"""Height of one parameter [in]."""
LIMIT = 2.0
"""A shift of more prior σ than this is marked: a number bent by physics that is missing."""
LONGEST, NAMED = 44, 3
"""Letters of a name; names in the line below the title."""
POINTS = 2000


# -- shifts ---------------------------------------------------------------------------------------------------------
def shift_figure(names: Sequence[str], shift: Array, std: Array) -> Figure:
    """Posterior less prior of every parameter in prior σ, the largest above, with bars of one posterior σ.

    shift, std: in prior σ; a std of NaN is a parameter without any (at its bound), drawn hollow.
    """
    order = np.argsort(-np.abs(shift), kind="stable")
    texts = [name_text(names[k], LONGEST) for k in order]
    left = 0.3 + max((text_size(text, SMALL)[0] for text in texts), default=0.0) / 72
    height = max(len(names), 1) * LINE
    figure = new_figure(0.75 + height + 0.55)
    axes = add_axes(figure, left, 0.55, WIDTH - left - 1.5, height)
    for row, k in enumerate(order):
        _draw_shift(axes, row, float(shift[k]), float(std[k]))
    _finish_shifts(axes, texts, shift, std)
    write_title(figure, "Shift of the parameters by calibration", _far(names, shift, order))
    return figure


def _draw_shift(axes: Axes, row: int, shift: float, std: float) -> None:
    far, known = abs(shift) > LIMIT, bool(np.isfinite(std))
    colour = FAR if far else MOVED
    if known:
        axes.plot([shift - std, shift + std], [row, row], color=colour, linewidth=1.4)
    face = colour if known else "white"
    marker = "D" if far else "o"
    axes.plot([shift], [row], marker, color=colour, markerfacecolor=face, markersize=4.5, markeredgewidth=1.0)
    told = f"{format_shift(shift, 2)} ± {std:.2f}" if known else f"{format_shift(shift, 2)}, at its bound"
    place = axes.get_yaxis_transform()
    axes.text(1.015, row, told, transform=place, fontsize=SMALL, color=INK, va="center_baseline")


def _finish_shifts(axes: Axes, texts: Sequence[str], shift: Array, std: Array) -> None:
    reach = float(np.max(np.abs(shift) + np.nan_to_num(std), initial=LIMIT)) * 1.06 + 0.2
    axes.set_xlim(-reach, reach)
    axes.set_ylim(max(len(texts), 1) - 0.4, -0.6)
    axes.set_yticks(np.arange(len(texts)), texts)
    axes.tick_params(axis="y", labelsize=SMALL, length=0)
    axes.axvspan(-1, 1, color=GREY, alpha=0.12, linewidth=0)
    axes.axvline(0, color=GREY, linewidth=0.6)
    for limit in (-LIMIT, LIMIT):
        axes.axvline(limit, color=FAR, linewidth=0.9, linestyle=(0, (5.0, 2.0)))
    axes.set_xlabel("moved by calibration [in the ± of the file]; shaded ±1, dashed ±2", fontsize=FONT, labelpad=2)


def _far(names: Sequence[str], shift: Array, order: Indices) -> str:
    far = [names[int(k)] for k in order if abs(shift[int(k)]) > LIMIT]
    if not far:
        return "none moved by more than twice its ±"
    told = ", ".join(far[:NAMED]) + (" …" if len(far) > NAMED else "")
    return f"{len(far)} of {len(names)} moved by more than twice their ±: {told}"


# -- a posterior band -----------------------------------------------------------------------------------------------
def band_figure(
    t: Array, centre: Array, std: Array, measured: Array | None, unit: str, name: str, inside: float | None = None,
    noise: float = 0.0, on: str = "",
) -> Figure:  # fmt: skip
    """A channel with its band of 95 % (±1.96 std), and below it measured less centre.

    t: [s]; centre, std, measured: in SI (°C), NaN in gaps; unit: what they are shown in, um for the tool centre point;
    inside: share of the readings within the band and their own noise; noise: 1σ of a reading, SI; on: which run.
    """
    figure, (values, apart) = stack_panels((2.6, 1.5), right=0.3)
    scale = gap_unit(unit).scale
    middle, width = in_own_unit(centre, unit), LEVEL * std / scale
    if measured is not None:
        draw_measured(values, t, in_own_unit(measured, unit), GREY, 0.9, clock(t)[1])
        draw_measured(apart, t, (measured - centre) / scale, GREY, 0.7, clock(t)[1])
        _draw_reading_band(apart, t, LEVEL * np.hypot(std, noise) / scale)
    _draw_band(values, t, middle, width)
    _draw_band(apart, t, np.zeros(len(t)), width)
    values.margins(y=0.08)
    label_y(values, name_text(name, 16), unit)
    label_y(apart, "measured − mean", gap_unit(unit).text)
    set_clock([values, apart], t)
    told = _band_told(std, measured is not None, unit, inside)
    write_title(figure, f"{name}: band of 95 %{f' on {on}' if on else ''}", told)
    return figure


def _draw_reading_band(axes: Axes, t: Array, width: Array) -> None:
    """What single readings lie in, their noise counted."""
    index = decimate_together(t, [width], POINTS)
    for side in (-1, 1):
        axes.plot(t[index] / clock(t)[1], side * width[index], color=MOVED, linewidth=0.9, linestyle=(0, (1.0, 1.5)))


def _draw_band(axes: Axes, t: Array, middle: Array, width: Array) -> None:
    index = decimate_together(t, [middle - width, middle + width], POINTS)
    times = t[index] / clock(t)[1]
    low, high = (middle - width)[index], (middle + width)[index]
    axes.fill_between(times, low, high, color=MOVED, alpha=0.25, linewidth=0, zorder=1.5)
    axes.plot(times, middle[index], color=MOVED, linewidth=1.2)


def _band_told(std: Array, is_measured: bool, unit_text: str, inside: float | None) -> str:
    given = gap_unit(unit_text)
    text = f"mean blue, band of 95 % shaded: ±{number(LEVEL * float(std.max()) / given.scale, given.text, 3)} at most"
    if not is_measured:
        return text
    share = "" if inside is None else f", {100 * inside:.3g} % of it within the band and its own noise"
    return f"{text}; dotted: with the noise of a reading; measured grey{share}"
