"""What was told beside a running machine: movement of the axes with its band, and when something was warned of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.correction.filter_model import FilterModel
from network.analysis.correction.follower import Told
from network.report.figures.canvas import PALETTE, look, write_title
from network.report.figures.lines import clock, decimate
from network.report.figures.panels import Curve, Panel, Shade, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS = 1500


def follow_figure(f: FilterModel, told: Sequence[Told]) -> Figure:
    """A panel for every axis; red below it, the times with a warning."""
    t = np.array([row.t for row in told])
    moved, band = (np.array([getattr(row, name) for row in told]) for name in ("moved", "band"))
    warned = np.array([bool(row.warnings) for row in told])
    panels = []
    for i, (axis, unit_text) in enumerate(zip(f.axes, f.axis_units, strict=True)):
        at, colour = decimate(t, moved[:, i], POINTS), look(i)[0]
        curve = Curve(t[at], moved[at, i], colour)
        shade = Shade(t[at], (moved - band)[at, i], (moved + band)[at, i], colour)
        panels.append(Panel(f"TCP {axis}", unit_text, 2.0, [curve], [curve.label(axis, unit_text)], True, [shade]))
    figure, axes = draw_panels(panels, t)
    for each in axes:
        across = each.get_xaxis_transform()
        each.fill_between(t / clock(t)[1], 0, 0.03, where=warned, transform=across, color=PALETTE[1], linewidth=0)
    first = {_subject(sentence): sentence for row in reversed(told) for sentence in row.warnings}
    below = f"warned of (marked), at first: {'; '.join(first.values())}" if first else "nothing was warned of"
    write_title(figure, f"{f.machine}: movement told beside it, with its band of 95 %", below)
    return figure


def _subject(sentence: str) -> str:
    """What it is about: a sensor, or the heat of a source."""
    return sentence.partition(" reads ")[0] if " reads " in sentence else sentence.rpartition(",")[0]
