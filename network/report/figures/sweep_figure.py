"""A sweep over levels as a picture: the tool centre point over time at every level, and how the levels converge."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from network.engine.trajectory import axis_unit
from network.platform.quantities.unit_values import in_own_unit
from network.report.figures.canvas import INK, WIDTH, add_axes, label_y, look, new_figure, write_title
from network.report.figures.convergence import draw_gaps, draw_times
from network.report.figures.labels import label_ends
from network.report.figures.lines import clock, set_clock, thin
from network.report.figures.panels import Curve, beside, draw_curves, room_for
from network.report.words.sweep_words import lumps_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from network.analysis.sweep.sweep import Sweep

LEFT, TOP, GAP, BELOW, FOOT = 0.8, 0.75, 0.16, 0.9, 0.5
HIGH, LOW = 2.1, 2.3
"""Inches: panels over time, and those below."""
BOLD = 2.6


def levels_figure(sweep: Sweep) -> Figure:
    """The tool centre point over time at every level, the finest bold; below, the largest difference to the finest and
    the time to solve over the number of lumps."""
    curves = {axis: dict(_curves(sweep, axis)) for axis in sweep.finest.tcp}
    labels = {a: [curve.label(lumps_of(n), axis_unit(a)) for n, curve in rows.items()] for a, rows in curves.items()}
    height = max(HIGH, room_for(len(sweep.levels)))
    total = TOP + len(curves) * (height + GAP) - GAP + BELOW + LOW + FOOT
    figure, right = new_figure(total), beside([label for some in labels.values() for label in some])
    drawn = []
    for i, axis in enumerate(curves):
        foot = total - TOP - (i + 1) * height - i * GAP
        drawn.append(add_axes(figure, LEFT, foot, WIDTH - LEFT - right, height))
        draw_curves(drawn[-1], curves[axis].values(), clock(sweep.finest.t)[1])
        label_ends(drawn[-1], labels[axis])
        label_y(drawn[-1], f"TCP {axis}", axis_unit(axis))
    set_clock(drawn, sweep.finest.t)
    wide = (WIDTH - 2 * LEFT - 0.3) / 2
    draw_gaps(add_axes(figure, LEFT, FOOT, wide, LOW), sweep)
    draw_times(add_axes(figure, LEFT + wide + LEFT, FOOT, wide, LOW), sweep)
    told = f"the finest level ({lumps_of(sweep.finest.level)}) bold; below, what the levels miss and what they cost"
    write_title(figure, f"{sweep.machine.name}: {sweep.source}", told)
    return figure


def _curves(sweep: Sweep, axis: str) -> Iterator[tuple[str, Curve]]:
    """Levels and their curves in the unit of the axis; the finest below the others, so that none is hidden."""
    others = [run for run in sweep.levels if run is not sweep.finest and axis in run.tcp]
    for i, run in enumerate([sweep.finest, *others]):
        t, values = thin(run.t, in_own_unit(run.tcp[axis], axis_unit(axis)))
        yield run.level, Curve(t, values, *(look(i - 1) if i else (INK, "solid")), 1.2 if i else BOLD)
