"""What a correction loses: the full model and the one of the control over time, and their difference."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from network.engine.trajectory import axis_unit
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import unit
from network.report.figures.canvas import GREY, look, write_title
from network.report.figures.lines import thin
from network.report.figures.panels import Curve, Panel, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from network.analysis.correction.correction import Correction


def correction_figure(correction: Correction) -> Figure:
    """Of the run that loses most: every axis of both models (full grey and broad), and below what is lost."""
    loss = max(correction.losses, key=lambda each: max(each.by_axis.values()))
    panels, t = list[Panel](), loss.t
    for i, axis in enumerate(loss.by_axis):
        shown = unit(axis_unit(axis))
        full, told = (in_own_unit(np.asarray(values[axis]), shown) for values in (loss.full, loss.told))
        curves = [Curve(*thin(t, full, 1000), GREY, "solid", 3.5), Curve(*thin(t, told, 1000), look(i)[0])]
        names = ("full model", "in the control")
        labels = [curve.label(name, axis_unit(axis)) for curve, name in zip(curves, names, strict=True)]
        panels.append(Panel(f"TCP {axis}", axis_unit(axis), 1.8, curves, labels))
        lost = Curve(*thin(t, told - full, 1000), look(i)[0])
        panels.append(Panel("lost", axis_unit(axis), 0.9, [lost], [lost.label(axis, axis_unit(axis))], from_zero=True))
    figure, _ = draw_panels(panels, t)
    below = f"{correction.filter.own} of {correction.full} states along {loss.run}"
    write_title(figure, f"{correction.machine.name}: what the control's model loses", below)
    return figure
