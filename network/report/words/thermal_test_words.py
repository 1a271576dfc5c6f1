"""A thermal test of ISO 230-3 in words: one table, and what is to be said beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.trajectory import axis_unit
from network.platform.quantities.number_format import format_amount, pretty
from network.platform.quantities.text_table import digits, table
from network.platform.quantities.units import unit
from network.report.words.lump_words import tell_cut

if TYPE_CHECKING:
    from network.analysis.acceptance.axis_drift import AxisDrift
    from network.analysis.acceptance.thermal_test import ThermalTest

ROUNDING = 1e-6
"""µm, µrad: less is nothing but rounding."""


def tell_thermal_test(test: ThermalTest) -> str:
    """The test, where its figures come from, and what every axis drifted."""
    blocks = [[name_test(test), basis_of(test), *start_of_test(test)]]
    header, rows = drift_rows(test)
    blocks.append(table(header, rows, header[1:]))
    blocks.append([*tell_combined(test), *tell_targets(test), *test.notes, *tell_cut(test.lumping)])
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


def start_of_test(test: ThermalTest) -> Iterator[str]:
    """Where a simulation begins: how, and how warm its parts are then."""
    if test.run is None or test.is_measured:
        return
    parts = {n: T[0] for n, T in test.run.parts.items() if test.machine.nodes[n].is_part}
    low, high = min(parts, key=parts.__getitem__), max(parts, key=parts.__getitem__)
    told = [format_amount(parts[name], "degC") for name in (low, high)]
    warm = f"all parts at {told[0]}" if told[0] == told[1] else f"parts from {told[0]} ({low}) to {told[1]} ({high})"
    how = {
        "in equilibrium": "in equilibrium with the room at rest, what is always on having run for long",
        "at the reference": "at its reference, for it has no equilibrium with its room",
    }.get(test.begins, test.begins)
    cold = "; `--start '20 degC'` begins cold" if test.begins == "in equilibrium" and told[0] != told[1] else ""
    yield f"It begins {how}: {warm}{cold}."


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
