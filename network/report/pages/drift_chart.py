"""The chart of a thermal test: drift, temperatures and motion."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from typing import TYPE_CHECKING

from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.trajectory import axis_unit
from network.platform.quantities.unit_values import in_own_unit
from network.report.figures.thermal_test_figure import list_courses, list_temperatures, list_times
from network.report.pages.chart import Chart, Line, Plot
from network.report.pages.run_charts import draw_rows, look, plot_inputs

if TYPE_CHECKING:
    from network.analysis.acceptance.thermal_test import ThermalTest


def chart_test(test: ThermalTest) -> Chart:
    """Measured beside simulated where there is both."""
    return Chart(test.source.name, [*_plot(test)])


def _plot(test: ThermalTest) -> Iterator[Plot]:
    number, t = count(), list_times(test)
    for title, is_angle in (("drift", False), ("rotation", True)):
        axes = [axis for axis in test.axes if (axis in ANGULAR_AXES) == is_angle]
        lines = [line for axis in axes for line in _lines(test, axis, number)]
        if lines:
            yield Plot(title, "urad" if is_angle else "um", lines, 220)
    rows = list_temperatures(test)
    if rows:
        yield Plot("temperature", "degC", [*draw_rows(t, rows, "degC", number)], 200)
    if test.run is not None:
        signals = test.run.schedule.signals
        yield from plot_inputs([signals[name] for name in test.motion.moving], t, number)


def _lines(test: ThermalTest, axis: str, number: Iterator[int]) -> Iterator[Line]:
    for name, course in list_courses(test, axis).items():
        yield Line(name, name, course.t, in_own_unit(course.values, axis_unit(axis)), *look(next(number)))
