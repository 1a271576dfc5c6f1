"""What moves the tool centre point: the share of every part, stacked, and the sum."""

from __future__ import annotations

from typing import TYPE_CHECKING

from network.engine.trajectory import Trajectory, axis_unit
from network.report.figures.canvas import label_y, stack_panels, write_title
from network.report.figures.lines import set_clock
from network.report.figures.panels import beside, room_for
from network.report.figures.run_figure import title, without_panels
from network.report.figures.stack import Stack

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def contributions_figure(run: Trajectory) -> Figure:
    """What moves the tool centre point: for every axis its contributions, stacked by sign, and their sum."""
    if not run.tcp:
        return without_panels(run, "this machine file moves no tool centre point")
    stacks = {axis: Stack(run.t, run.of_axis(axis), values, axis_unit(axis)) for axis, values in run.tcp.items()}
    heights = [max(2.3, room_for(len(stack.rows) + 1)) for stack in stacks.values()]
    labels = [label for stack in stacks.values() for label in stack.labels()]
    figure, panels = stack_panels(heights, right=beside(labels))
    for (axis, stack), axes in zip(stacks.items(), panels, strict=True):
        stack.draw(axes)
        label_y(axes, f"TCP {axis}", axis_unit(axis))
    set_clock(panels, run.t)
    write_title(figure, title(run), "what moves the tool centre point: contributions and their sum, with final values")
    return figure
