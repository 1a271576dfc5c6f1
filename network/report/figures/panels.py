"""Panels of curves on one time axis, every curve named at its end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import number
from network.report.figures.canvas import GREY, SMALL, Dashes, label_y, look, name_text, stack_panels, text_size
from network.report.figures.labels import LINE, ROOM, EndLabel, label_ends
from network.report.figures.lines import clock, set_clock, thin

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_NAMED = 14
"""Curves with a name in one panel; what moves less stays grey."""


@dataclass(frozen=True)
class Curve:
    """A line in the unit of its panel; t [s]."""

    t: Array
    values: Array
    colour: str
    dashes: Dashes = "solid"
    width: float = 1.3

    @property
    def end(self) -> float:
        finite = self.values[np.isfinite(self.values)]
        return float(finite[-1]) if len(finite) else float("nan")

    def label(self, name: str, unit_text: str) -> EndLabel:
        text = f"{name_text(name, 24)}  {number(self.end, unit_text)}"
        return EndLabel(self.end, text, self.colour, self.dashes, self.width)


@dataclass(frozen=True)
class Shade:
    """An area between two courses, in the unit of its panel; t [s]."""

    t: Array
    low: Array
    high: Array
    colour: str


@dataclass(frozen=True)
class Panel:
    """height: in inches, more where the labels need it; from_zero: whether zero is always in sight."""

    quantity: str
    unit: str
    height: float
    curves: Sequence[Curve]
    labels: Sequence[EndLabel]
    from_zero: bool = False
    shades: Sequence[Shade] = ()


def panel_of(quantity: str, unit_text: str, height: float, rows: Mapping[str, Array], t: Array) -> Panel:
    """Rows over t in the panel's unit: those that move most by name, the others grey."""
    moved = {name: _extent(values) for name, values in rows.items()}
    named = set(sorted(moved, key=lambda name: -moved[name])[:MOST_NAMED])
    quiet = [Curve(*thin(t, v, 1000), GREY, "solid", 0.4) for name, v in rows.items() if name not in named]
    curves = {name: Curve(*thin(t, rows[name]), *look(i)) for i, name in enumerate(n for n in rows if n in named)}
    labels = [curve.label(name, unit_text) for name, curve in curves.items()]
    if quiet:
        labels.append(EndLabel(float("nan"), f"{len(quiet)} more that move less", GREY, "solid", 0.4))
    return Panel(quantity, unit_text, height, [*quiet, *curves.values()], labels)


def _extent(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if len(finite) else -1.0


def draw_curves(axes: Axes, curves: Iterable[Curve], length: float = 1.0, marker: str = "") -> None:
    """Lines in the unit of the axes; `length`: of the unit of the axis across."""
    for curve in curves:
        style: dict[str, Any] = {"color": curve.colour, "linestyle": curve.dashes, "linewidth": curve.width}
        axes.plot(curve.t / length, curve.values, marker=marker, markersize=3, **style)
    axes.margins(y=0.08)


def lay_panels(panels: Sequence[Panel]) -> tuple[Figure, list[Axes]]:
    """Empty axes for all, with room for their labels."""
    heights = [max(panel.height, room_for(len(panel.labels))) for panel in panels]
    return stack_panels(heights, right=beside([label for panel in panels for label in panel.labels]))


def draw_panels(panels: Sequence[Panel], t: Array) -> tuple[Figure, list[Axes]]:
    """The figure with all panels, their labels and the time axis."""
    figure, drawn = lay_panels(panels)
    for panel, axes in zip(panels, drawn, strict=True):
        for shade in panel.shades:
            axes.fill_between(shade.t / clock(t)[1], shade.low, shade.high, color=shade.colour, alpha=0.22, linewidth=0)
        draw_curves(axes, panel.curves, clock(t)[1])
        if panel.from_zero:
            axes.update_datalim([(panel.curves[0].t[0] / clock(t)[1], 0.0)])
            axes.autoscale_view()
        label_ends(axes, panel.labels)
        label_y(axes, panel.quantity, panel.unit)
    set_clock(drawn, t)
    return figure, drawn


def room_for(labels: int) -> float:
    """Height of that many labels [in]."""
    return (labels + 0.5) * LINE / 72


def beside(labels: Sequence[EndLabel]) -> float:
    """Room that the labels need on the right [in]."""
    return (ROOM + max((text_size(label.text, SMALL)[0] for label in labels), default=0.0) + 8) / 72
