"""What moves the tool centre point: the share of every part, stacked, and the sum."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.trajectory import Trajectory, axis_unit
from network.platform.quantities.number_format import number
from network.platform.quantities.units import unit
from network.report.figures.canvas import GREY, PALETTE, in_unit, label_y, name_text, stack_panels, write_title
from network.report.figures.labels import EndLabel, label_ends
from network.report.figures.lines import clock, decimate_together, set_clock
from network.report.figures.panels import beside, room_for
from network.report.figures.run_figure import title, without_panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HATCHED = (0, (0.5, 0.25))
MOST_BANDS = 10
"""Beyond, the smallest contributions are added up."""


def contributions_figure(run: Trajectory) -> Figure:
    """What moves the tool centre point: for every axis its contributions, stacked by sign, and their sum."""
    if not run.tcp:
        return without_panels(run, "this machine file moves no tool centre point")
    stacks = {axis: _Stack(run, axis) for axis in run.tcp}
    heights = [max(2.3, room_for(len(stack.rows) + 1)) for stack in stacks.values()]
    labels = [label for stack in stacks.values() for label in stack.labels()]
    figure, panels = stack_panels(heights, right=beside(labels))
    for (axis, stack), axes in zip(stacks.items(), panels, strict=True):
        stack.draw(axes)
        label_y(axes, f"TCP {axis}", axis_unit(axis))
    set_clock(panels, run.t)
    write_title(figure, title(run), "what moves the tool centre point: contributions and their sum, with final values")
    return figure


class _Stack:
    """The contributions to one axis in its unit; beyond a few the smallest are added up."""

    def __init__(self, run: Trajectory, axis: str) -> None:
        self.t, self.axis, shown = run.t, axis, unit(axis_unit(axis))
        self.total = in_unit(run.tcp[axis], shown)
        rows = {name: in_unit(values, shown) for (a, name), values in run.contributions.items() if a == axis}
        by_size = sorted(rows, key=lambda name: -float(np.abs(rows[name]).max()))
        small = by_size[MOST_BANDS - 1 :] if len(rows) > MOST_BANDS else []
        self.rows = {name: values for name, values in rows.items() if name not in small}
        if small:
            self.rows[f"{len(small)} smaller ones"] = np.sum([rows[name] for name in small], axis=0)

    def bands(self) -> Iterator[tuple[str, Array, Array]]:
        """(name, one edge, other edge): positive ones upwards from zero, negative ones downwards."""
        above, below = np.zeros_like(self.total), np.zeros_like(self.total)
        for name, values in self.rows.items():
            top, foot = above + np.maximum(values, 0), below + np.minimum(values, 0)
            yield name, above, top
            yield name, below, foot
            above, below = top, foot

    def labels(self) -> list[EndLabel]:
        unit_text, looks = axis_unit(self.axis), dict(zip(self.rows, self.looks(), strict=True))
        middles = {n: float(edge[-1] + other[-1]) / 2 for n, edge, other in self.bands() if edge[-1] != other[-1]}
        ends = {name: float(values[-1]) for name, values in (self.rows | {"": self.total}).items()}
        finals = {name: number(end, unit_text, 3, sign=True) for name, end in ends.items()}
        told = {name: f"{finals[name]}  {name_text(name)}" for name in self.rows}
        named = [
            EndLabel(middles.get(name, 0.0), told[name], colour, HATCHED if hatched else "solid", 5.0)
            for name, (colour, hatched) in looks.items()
        ]
        return [*named, EndLabel(ends[""], f"{finals['']}  sum", "black", width=1.6)]

    def looks(self) -> list[tuple[str, bool]]:
        """Colour of every band, and whether it is hatched: those that come second to a colour."""
        return [(PALETTE[i % len(PALETTE)], i >= len(PALETTE)) for i in range(len(self.rows))]

    def draw(self, axes: Axes) -> None:
        at = decimate_together(self.t, [*self.rows.values(), self.total])
        t, looks = self.t[at] / clock(self.t)[1], dict(zip(self.rows, self.looks(), strict=True))
        for name, edge, other in self.bands():
            colour, hatched = looks[name]
            style: dict[str, Any] = {"facecolor": colour, "hatch": "////" if hatched else "", "edgecolor": "white"}
            axes.fill_between(t, edge[at], other[at], alpha=0.75, linewidth=0.4, **style)
        axes.plot(t, self.total[at], color="black", linewidth=1.6)
        axes.axhline(0, color=GREY, linewidth=0.6)
        axes.margins(y=0.08)
        label_ends(axes, self.labels())
