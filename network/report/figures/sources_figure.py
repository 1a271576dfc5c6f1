"""Where the movement of the tool centre point comes from: the shares of parts or heat sources, stacked, and the sum."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.superposition.superposition import By, Superposition
from network.engine.trajectory import Trajectory, axis_unit
from network.report.figures.canvas import write_title
from network.report.figures.run_figure import title, without_panels
from network.report.figures.stack import Stack, draw_stacks
from network.report.words.source_words import SAID

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOTHING = "this machine file moves no tool centre point"


def contributions_figure(run: Trajectory) -> Figure:
    """What moves the tool centre point: for every axis its contributions, stacked by sign, and their sum."""
    if not run.tcp:
        return without_panels(run, NOTHING)
    stacks = {axis: Stack(run.t, run.of_axis(axis), values, axis_unit(axis)) for axis, values in run.tcp.items()}
    figure = draw_stacks(run.t, [(f"TCP {axis}", 2.3, stack) for axis, stack in stacks.items()])
    write_title(figure, title(run), "what moves the tool centre point: contributions and their sum, with final values")
    return figure


def sources_figure(shares: Superposition) -> Figure:
    """For every axis what each heat source moved it since the start; the kinds of movement below, where several."""
    run = shares.run
    if not run.tcp:
        return without_panels(run, NOTHING)
    figure = draw_stacks(run.t, list(_stacks(shares)))
    write_title(figure, title(run), f"which heat moved the tool centre point, with final values ({SAID[shares.how]})")
    return figure


def _stacks(shares: Superposition) -> Iterator[tuple[str, float, Stack]]:
    for axis, values in shares.run.tcp.items():
        by: By
        for by in ("cause", "kind"):
            rows = {name: _since_start(row) for (name,), row in shares.sum_by(axis, by).items()}
            rows = {name: row for name, row in rows.items() if row.any()} or rows
            if by == "cause" or len(rows) > 1:
                stack = Stack(shares.run.t, rows, _since_start(values), axis_unit(axis))
                yield (f"TCP {axis} since start", 2.3, stack) if by == "cause" else (f"{axis}, by kind", 1.6, stack)


def _since_start(values: Array) -> Array:
    return np.asarray(values - values[0])
