"""Where the movement of the tool centre point comes from: the share of every heat source, stacked, and the sum."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.superposition.superposition import By, Superposition
from network.engine.trajectory import axis_unit
from network.report.figures.canvas import label_y, stack_panels, write_title
from network.report.figures.lines import set_clock
from network.report.figures.panels import beside, room_for
from network.report.figures.run_figure import title, without_panels
from network.report.figures.stack import Stack
from network.report.words.source_words import SAID

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def sources_figure(shares: Superposition) -> Figure:
    """For every axis what each heat source moved it since the start; the kinds of movement below, where several."""
    run = shares.run
    if not run.tcp:
        return without_panels(run, "this machine file moves no tool centre point")
    stacks = list(_stacks(shares))
    heights = [max(1.6 if by == "kind" else 2.3, room_for(len(stack.rows) + 1)) for _, by, stack in stacks]
    labels = [label for *_, stack in stacks for label in stack.labels()]
    figure, panels = stack_panels(heights, right=beside(labels))
    for (axis, _, stack), axes in zip(stacks, panels, strict=True):
        stack.draw(axes)
        label_y(axes, f"TCP {axis} since start", axis_unit(axis))
    set_clock(panels, run.t)
    write_title(figure, title(run), f"which heat moved the tool centre point, with final values ({SAID[shares.how]})")
    return figure


def _stacks(shares: Superposition) -> Iterator[tuple[str, By, Stack]]:
    for axis, values in shares.run.tcp.items():
        by: By
        for by in ("cause", "kind"):
            rows = {name: _since_start(row) for (name,), row in shares.sum_by(axis, by).items()}
            rows = {name: row for name, row in rows.items() if row.any()} or rows
            if by == "cause" or len(rows) > 1:
                yield axis, by, Stack(shares.run.t, rows, _since_start(values), axis_unit(axis))


def _since_start(values: Array) -> Array:
    return np.asarray(values - values[0])
