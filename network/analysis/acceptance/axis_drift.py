"""What one axis drifted in a thermal test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from network.analysis.acceptance.drift_measures import HOUR, find_range, find_stability
from network.analysis.acceptance.motion import Motion
from network.catalogue.declaration.declare import Array
from network.engine.trajectory import axis_unit
from network.platform.printing import Brief
from network.platform.quantities.units import unit

TILTS = {"x": ("b", -1.0), "y": ("a", 1.0)}
"""The rotation that carries the end of a tool along an axis, and which way: with a tool to −z, x = −b L and y = a L."""


@dataclass(frozen=True)
class Asked:
    """What a user may ask of the figures, as evaluate_thermal_test says."""

    tool_length: float | None
    stable_share: float


@dataclass(frozen=True, eq=False, repr=False)
class AxisDrift(Brief):
    """What one axis drifted since the start, over t [s] [m, rad]; all figures are ranges (largest less smallest).

    drift: over the whole test; first, last: in the first and the last 60 min of motion; stable_after: [s] of motion,
    None where it is never stable; after_stop: once all rests, NaN without such a time; tilt: of the rotation that
    belongs to it [rad], None without; offset: at the end of a longer tool [m], None where not asked for; targets: what
    it drifted where a linear axis stood at either end of its travel [m]; the figures are those of the worse of them.
    """

    axis: str
    t: Array
    values: Array
    drift: float
    first: float
    last: float
    stable_after: float | None
    after_stop: float
    tilt: float | None = None
    offset: float | None = None
    targets: Mapping[float, AxisDrift] = field(default_factory=dict)

    def summary(self, tool_length: float | None) -> dict[str, Any]:
        """Of the JSON."""
        shown = axis_unit(self.axis)

        def amount(value: float | None, text: str = shown) -> dict[str, Any] | None:
            return None if value is None or value != value else {"value": unit(text).from_si(value), "unit": text}

        told: dict[str, Any] = {
            "drift": amount(self.drift), "first_60_min": amount(self.first), "last_60_min": amount(self.last),
            "stable_after_min": None if self.stable_after is None else self.stable_after / 60,
            "after_stop": amount(self.after_stop), "tilt": amount(self.tilt, "urad"),
        }  # fmt: skip
        if self.offset is not None and tool_length is not None:
            told["offset"] = {**(amount(self.offset) or {}), "tool_length": {"value": 1e3 * tool_length, "unit": "mm"}}
        if self.targets:
            told["targets"] = [{"at": {"value": 1e3 * at, "unit": "mm"}, **drift.summary(tool_length)}
                               for at, drift in self.targets.items()]  # fmt: skip
        return told


def evaluate_axes(
    courses: Mapping[str, tuple[Array, Array]], motion: Motion, asked: Asked, position: Array | None
) -> dict[str, AxisDrift]:
    """The figures of every axis; where a linear axis moves, at both ends of its travel."""
    if position is None:
        return {axis: _drift(axis, courses, motion, asked) for axis in courses}
    ends = {}
    for end in sorted({float(position.min()), float(position.max())}):
        stands = np.isclose(position, end, rtol=0, atol=1e-9)
        there = {axis: (t[stands], values[stands]) for axis, (t, values) in courses.items()}
        ends[end] = {axis: _drift(axis, there, motion, asked) for axis in there}
    worst = {axis: max((at[axis] for at in ends.values()), key=lambda d: d.drift) for axis in courses}
    return {axis: replace(d, targets={end: at[axis] for end, at in ends.items()}) for axis, d in worst.items()}


def _drift(axis: str, courses: Mapping[str, tuple[Array, Array]], motion: Motion, asked: Asked) -> AxisDrift:
    t, values = courses[axis]
    begin, end, whole = motion.begin, motion.end, float(t[-1])
    rotation, way = TILTS.get(axis, ("", 0.0))
    turned = courses.get(rotation)
    tilt = find_range(*turned, float(t[0]), whole) if turned is not None else None
    offset = None
    if turned is not None and asked.tool_length is not None:
        offset = find_range(t, values + way * asked.tool_length * np.interp(t, *turned), float(t[0]), whole)
    return AxisDrift(
        axis, t, values - values[0], find_range(t, values, float(t[0]), whole),
        find_range(t, values, begin, min(begin + HOUR, end)), find_range(t, values, max(end - HOUR, begin), end),
        None if motion.test == "etve" else find_stability(t, values, begin, end, asked.stable_share),
        find_range(t, values, end, whole) if end < whole else float("nan"), tilt, offset,
    )  # fmt: skip
