"""A thermal test as ISO 230-3 shows it: drift of every axis, temperatures and what moves, over one time axis."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.acceptance.drift_measures import HOUR
from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.trajectory import axis_unit
from network.platform.quantities.unit_values import in_own_unit
from network.recordings.recording import Recording
from network.report.figures.canvas import DASHES, GREY, SMALL, look, write_title
from network.report.figures.labels import EndLabel
from network.report.figures.lines import clock, thin
from network.report.figures.panels import Curve, Panel, draw_panels, panel_of
from network.report.figures.run_figure import input_panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from network.analysis.acceptance.axis_drift import AxisDrift
    from network.analysis.acceptance.thermal_test import ThermalTest
    from network.catalogue.declaration.declare import Array


def thermal_test_figure(test: ThermalTest) -> Figure:
    """Drift since the start on top (measured with dots, simulated as lines), then angles, temperatures, motion."""
    t = list_times(test)
    figure, axes = draw_panels(list(_panels(test, t)), t)
    _mark_hours(axes, test, t)
    write_title(figure, test.machine.name, f"ISO 230-3 {test.motion.title}")
    return figure


def list_times(test: ThermalTest) -> Array:
    """The clock of the picture [s]."""
    t = test.source.t if isinstance(test.source, Recording) else test.source.schedule.t
    return np.asarray(t, np.float64)


def _panels(test: ThermalTest, t: Array) -> Iterator[Panel]:
    for quantity, is_angle, height in (("drift", False, 2.6), ("rotation", True, 1.8)):
        chosen = {axis: d for axis, d in test.axes.items() if (axis in ANGULAR_AXES) == is_angle}
        if chosen:
            yield _drift_panel(test, quantity, "urad" if is_angle else "um", height, chosen)
    rows = list_temperatures(test)
    if rows:
        yield panel_of("temperature", "degC", 2.6, rows, t)
    yield from _motion_panels(test, t)


def _drift_panel(test: ThermalTest, quantity: str, shown: str, height: float, chosen: Mapping[str, AxisDrift]) -> Panel:
    """Measured curves; beside them, dashed, what is simulated."""
    curves, labels = list[Curve](), list[EndLabel]()
    for i, axis in enumerate(chosen):
        for k, (name, course) in enumerate(list_courses(test, axis).items()):
            values = in_own_unit(course.values, axis_unit(axis))
            curves.append(Curve(*thin(course.t, values, 1000), look(i)[0], DASHES[min(k, 1)], 1.6))
            labels.append(curves[-1].label(name, shown))
    return Panel(quantity, shown, height, curves, labels, from_zero=True)


def list_courses(test: ThermalTest, axis: str) -> dict[str, AxisDrift]:
    """What is drawn of an axis, by name: solid, then dashed."""
    drift = test.axes[axis]
    if drift.targets:
        return {f"{axis} at {1e3 * at:.4g} mm": there for at, there in drift.targets.items()}
    if test.simulated is not None and axis in test.simulated:
        return {f"{axis} measured": drift, f"{axis} simulated": test.simulated[axis]}
    return {axis: drift}


def list_temperatures(test: ThermalTest) -> dict[str, Array]:
    """The temperature channels: recorded where there is a recording, else simulated."""
    sensors = {n: s for n, s in test.machine.sensors.items() if s.quantity == "temperature"}
    if isinstance(test.source, Recording):
        return {n: test.source.columns[n].values for n in sensors if n in test.source.columns}
    assert test.run is not None
    rows = {name: test.run.sensors[name] for name in sensors}
    held = {n: v for n, v in test.run.inputs.items() if n in test.machine.nodes and test.machine.nodes[n].is_held}
    return rows | held


def _motion_panels(test: ThermalTest, t: Array) -> Iterator[Panel]:
    schedule = test.run.schedule if test.run is not None else None
    by_unit: dict[str, list[str]] = {}
    for name in test.motion.moving if schedule is not None else ():
        by_unit.setdefault(schedule.signals[name].unit if schedule else "", []).append(name)
    for shown, names in by_unit.items():
        if schedule is not None:
            yield input_panel([schedule.signals[name] for name in names], shown, t)


def _mark_hours(panels: list[Axes], test: ThermalTest, t: Array) -> None:
    """Upright lines: the first and the last 60 min of motion."""
    begin, end, length = test.motion.begin, test.motion.end, clock(t)[1]
    for axes in panels:
        for at in (begin + HOUR, end - HOUR, end):
            if begin < at <= end:
                axes.axvline(at / length, color=GREY, linewidth=0.7, linestyle=(0, (4, 3)))
    if end - begin > 2 * HOUR:
        for at, words in ((begin + HOUR / 2, "first 60 min"), (end - HOUR / 2, "last 60 min")):
            panels[0].text(at / length, 1.0, words, transform=panels[0].get_xaxis_transform(), fontsize=SMALL,
                           color=GREY, ha="center", va="bottom")  # fmt: skip
