"""A thermal test of ISO 230-3 in words: one table, and what is to be said beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.trajectory import axis_unit
from network.platform.quantities.number_format import pretty
from network.platform.quantities.text_table import digits, table
from network.platform.quantities.units import unit

if TYPE_CHECKING:
    from network.analysis.acceptance.axis_drift import AxisDrift
    from network.analysis.acceptance.thermal_test import ThermalTest

ROUNDING = 1e-6
"""µm, µrad: less is nothing but rounding."""


def tell_thermal_test(test: ThermalTest) -> str:
    """The test, where its figures come from, and what every axis drifted."""
    blocks = [[name_test(test), basis_of(test)]]
    header, rows = drift_rows(test)
    blocks.append(table(header, rows, header[1:]))
    blocks.append([*tell_combined(test), *tell_targets(test), *test.notes])
    return "\n\n".join("\n".join(block) for block in blocks if block)


def name_test(test: ThermalTest) -> str:
    return f"{test.machine.name}: ISO 230-3 {test.motion.title}"


def basis_of(test: ThermalTest) -> str:
    """Measured or simulated, on what, and when something moved."""
    how = "measured in" if test.is_measured else "simulated along"
    told = f"{how[0].upper()}{how[1:]} {test.source.name!r}"
    if not test.motion.moving:
        return f"{told}; nothing moves."
    begin, end = (f"{t / 60:.4g}" for t in (test.motion.begin, test.motion.end))
    return f"{told}; {' and '.join(test.motion.moving)} from {begin} to {end} min."


def drift_rows(test: ThermalTest) -> tuple[list[str], list[list[str]]]:
    """Header and rows of the table; below a measured axis what was simulated."""
    header = ["axis", "drift", "first 60 min", "last 60 min", "after stop", "stable after", "tilt"]
    if test.tool_length is not None:
        header.append(f"at tool + {1e3 * test.tool_length:.4g} mm")
    rows = []
    for axis, drift in test.axes.items():
        rows.append(_row(f"{axis} [{pretty(axis_unit(axis))}]", drift, test.tool_length is not None))
        if test.simulated is not None and axis in test.simulated:
            rows.append(_row("  simulated", test.simulated[axis], test.tool_length is not None))
    return header, rows


def _row(name: str, drift: AxisDrift, with_offset: bool) -> list[str]:
    shown = axis_unit(drift.axis)
    figures = [_told(value, shown) for value in (drift.drift, drift.first, drift.last, drift.after_stop)]
    stable = "–" if drift.stable_after is None else f"{drift.stable_after / 60:.0f} min"
    tilt = "–" if drift.tilt is None else f"{_told(drift.tilt, 'urad')} {pretty('urad')}"
    return [name, *figures, stable, tilt, *([_told(drift.offset, shown)] if with_offset else [])]


def _told(value: float | None, unit_text: str) -> str:
    if value is None or math.isnan(value):
        return "–"
    shown = unit(unit_text).from_si(value)
    return digits(shown if abs(shown) > ROUNDING else 0.0, 3)


def tell_combined(test: ThermalTest) -> Iterator[str]:
    """The drifts of the linear axes in one figure."""
    if test.combined is not None:
        axes = " + ".join(f"{axis}²" for axis in test.axes if axis not in ANGULAR_AXES)
        yield f"Combined drift √({axes}): {_told(test.combined, 'um')} {pretty('um')}."


def tell_targets(test: ThermalTest) -> Iterator[str]:
    """What an axis drifted where it stood at the ends of its travel."""
    for axis, drift in test.axes.items():
        shown = axis_unit(axis)
        told = [f"{_told(d.drift, shown)} {pretty(shown)} at {1e3 * at:.4g} mm" for at, d in drift.targets.items()]
        if told:
            yield f"{axis} drifts at the ends of the travel by {' and by '.join(told)}; the table tells the worse one."
