"""Shares stacked over time: positive ones upwards from zero, negative ones downwards, and their sum as a line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.trajectory import drop_rounding
from network.platform.quantities.number_format import number
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import unit
from network.report.figures.canvas import GREY, PALETTE, label_y, name_text, stack_panels
from network.report.figures.labels import EndLabel, label_ends
from network.report.figures.lines import clock, decimate_together, set_clock
from network.report.figures.panels import beside, room_for

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HATCHED = (0, (0.5, 0.25))
MOST_BANDS = 10
"""Beyond, the smallest shares are added up."""


def draw_stacks(t: Array, stacks: Sequence[tuple[str, float, Stack]]) -> Figure:
    """Stacks on one time axis t [s], each with its quantity and a height [in], more where its labels need it."""
    heights = [max(height, room_for(len(stack.rows) + 1)) for _, height, stack in stacks]
    labels = [label for *_, stack in stacks for label in stack.labels()]
    figure, panels = stack_panels(heights, right=beside(labels))
    for (quantity, _, stack), axes in zip(stacks, panels, strict=True):
        stack.draw(axes)
        label_y(axes, quantity, stack.unit)
    set_clock(panels, t)
    return figure


class Stack:
    """Shares of a whole (SI) in a unit, over t [s]; beyond a few the smallest are added up."""

    def __init__(self, t: Array, shares: Mapping[str, Array], total: Array, unit_text: str) -> None:
        self.t, self.unit, shown = t, unit_text, unit(unit_text)
        self.total = in_own_unit(drop_rounding(total), shown)
        rows = {name: in_own_unit(drop_rounding(values), shown) for name, values in shares.items()}
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
        unit_text, looks = self.unit, dict(zip(self.rows, self.looks(), strict=True))
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
