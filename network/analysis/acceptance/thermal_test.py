"""A thermal test of ISO 230-3: what every axis drifts, simulated or measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from network.analysis.acceptance.drift_measures import HOUR, find_range, find_stability, smooth_readings
from network.analysis.acceptance.motion import Motion, find_motion, rest
from network.analysis.sweep.lumping_error import LumpingError, estimate_lumping
from network.catalogue.declaration.declare import Array
from network.engine.simulation import check_known, schedule_for, simulate
from network.engine.trajectory import Trajectory, axis_unit
from network.machine.machine import Machine
from network.platform.printing import Brief, Result
from network.platform.quantities.units import unit
from network.platform.refusal import Failed, Refused, Spot, refuse
from network.recordings.call_arguments import expect_run
from network.recordings.counted_readings import drop_uncounted
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

Begins = Literal["in equilibrium", "at the reference", "as stated", "as read"]
TILTS = {"x": ("b", -1.0), "y": ("a", 1.0)}
"""The rotation that carries the end of a tool along an axis, and which way: with a tool to −z, x = −b L and y = a L."""


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


@dataclass(frozen=True, eq=False, repr=False)
class ThermalTest(Result):
    """A test, evaluated. axes: measured, or simulated where `is_measured` is False; simulated: beside what was
    measured, None without; run: the simulation, None for a recording of a machine that still has unknown numbers;
    begins: where it does; lumping: what finer lumps would change in it."""

    machine: Machine
    source: Scenario | Recording
    motion: Motion
    axes: Mapping[str, AxisDrift]
    is_measured: bool
    simulated: Mapping[str, AxisDrift] | None
    run: Trajectory | None
    tool_length: float | None
    notes: tuple[str, ...]
    begins: Begins
    lumping: LumpingError | None = None

    def summary(self) -> dict[str, Any]:
        """What `--json` prints."""
        told: dict[str, Any] = {
            "test": self.motion.test, "title": f"ISO 230-3 {self.motion.title}", "machine": self.machine.name,
            "source": self.source.name, "from": "recording" if self.is_measured else "simulation",
            "motion_min": {"begin": self.motion.begin / 60, "end": self.motion.end / 60},
            "axes": {axis: drift.summary(self.tool_length) for axis, drift in self.axes.items()},
            "begins": self.begins, "notes": list(self.notes),
            "lumping": None if self.lumping is None else self.lumping.summary(),
        }  # fmt: skip
        if self.simulated is not None:
            told["simulated"] = {axis: drift.summary(self.tool_length) for axis, drift in self.simulated.items()}
        return told


def evaluate_thermal_test(
    machine: Machine, source: Scenario | Recording, *, tool_length: float | None = None, start: Start | None = None
) -> ThermalTest:
    """An ISO 230-3 test of a machine: a program is simulated; of a recording the measured axes are told, and beside
    them what the machine file says. tool_length: beyond the tool centre point [m], along −z.

    Of a recording that is parted the longest piece counts. Raises Refused for a machine that moves no tool centre
    point, a program that moves nothing of it, a recording without a measured axis, a tool length without a or b.
    """
    expect_run(machine, source, start)
    _check(machine, source, tool_length)
    if isinstance(source, Recording) and source.cuts:
        source = max(source.pieces, key=lambda piece: float(np.ptp(piece.t)))
    if isinstance(source, Scenario):
        source = replace(source, schedule=rest(machine, source.schedule))
    motion = find_motion(machine, schedule_for(machine, source, start))
    run, begins, lumping = _simulate(machine, source, start)
    told = {axis: (run.t, values) for axis, values in run.tcp.items()} if run is not None else {}
    position = run.inputs.get(motion.position) if run is not None else None
    evaluated = _evaluate(told, motion, tool_length, position)
    if isinstance(source, Scenario):
        notes = tuple(_notes(motion, run))
        return ThermalTest(machine, source, motion, evaluated, False, None, run, tool_length, notes, begins, lumping)
    measured = dict(_measured(machine, source))
    axes = _evaluate(measured, motion, tool_length, None)
    beside = {axis: drift for axis, drift in evaluated.items() if axis in axes} or None
    notes = tuple(_notes(motion, run))
    return ThermalTest(machine, source, motion, axes, True, beside, run, tool_length, notes, begins, lumping)


def _check(machine: Machine, source: Scenario | Recording, tool_length: float | None) -> None:
    if not machine.tcp:
        raise refuse(Spot(machine.file), "moves no tool centre point, so nothing drifts", "add entries under `tcp`")
    if tool_length is not None and not {"a", "b"} & set(machine.tcp):
        right = "add rotations under `tcp` (a about x, b about y), as in `b: {headstock tilts: {kind: tilt, …}}`"
        raise refuse(Spot(machine.file), "has no rotation a or b, which a tool length would turn into movement", right)
    if isinstance(source, Recording) and not any(s.axis for n, s in machine.sensors.items() if n in source.columns):
        channels = ", ".join(name for name, sensor in machine.sensors.items() if sensor.axis) or "none"
        right = f"record one of the displacement channels of this machine: {channels}"
        raise refuse(Spot(source.file), "has no measured displacement", right)


def _simulate(
    machine: Machine, source: Scenario | Recording, start: Start | None
) -> tuple[Trajectory | None, Begins, LumpingError | None]:
    """The run, where it begins, and what finer lumps would change in it. A program begins in equilibrium with its
    inputs, all that is always on having run, unless it or the user says otherwise: what moves then moves by what the
    test does. A machine that has none begins at its reference."""
    begins: Begins = "as stated"
    if isinstance(source, Recording):
        begins = "as read" if start is None else begins
        try:
            check_known(machine)
        except Refused:
            return None, begins, None
    elif start is None and source.schedule.start is None:
        begins, start = "in equilibrium", Start(steady=True)
    try:
        run = simulate(machine, source, start=start)
    except Failed:
        if begins != "in equilibrium":
            raise
        begins, start = "at the reference", None
        run = simulate(machine, source)
    return run, begins, estimate_lumping(machine, source, run, start=start, asks=False)


def _measured(machine: Machine, recording: Recording) -> Iterator[tuple[str, tuple[Array, Array]]]:
    """Every axis that a channel measures, smoothed over some minutes: (t, values)."""
    counted = drop_uncounted(machine, recording)
    for name, sensor in machine.sensors.items():
        if sensor.axis is not None and name in counted.columns:
            t, values = smooth_readings(counted.t, counted.columns[name].values)
            if len(t):
                yield sensor.axis, (t, values)


def _evaluate(
    courses: Mapping[str, tuple[Array, Array]], motion: Motion, tool_length: float | None, position: Array | None
) -> dict[str, AxisDrift]:
    """The figures of every axis; where a linear axis moves, at both ends of its travel."""
    if position is None:
        return {axis: _drift(axis, courses, motion, tool_length) for axis in courses}
    ends = {}
    for end in sorted({float(position.min()), float(position.max())}):
        stands = np.isclose(position, end, rtol=0, atol=1e-9)
        there = {axis: (t[stands], values[stands]) for axis, (t, values) in courses.items()}
        ends[end] = {axis: _drift(axis, there, motion, tool_length) for axis in there}
    worst = {axis: max((at[axis] for at in ends.values()), key=lambda d: d.drift) for axis in courses}
    return {axis: replace(d, targets={end: at[axis] for end, at in ends.items()}) for axis, d in worst.items()}


def _drift(
    axis: str, courses: Mapping[str, tuple[Array, Array]], motion: Motion, tool_length: float | None
) -> AxisDrift:
    t, values = courses[axis]
    begin, end, whole = motion.begin, motion.end, float(t[-1])
    rotation, way = TILTS.get(axis, ("", 0.0))
    turned = courses.get(rotation)
    tilt = find_range(*turned, float(t[0]), whole) if turned is not None else None
    offset = None
    if turned is not None and tool_length is not None:
        offset = find_range(t, values + way * tool_length * np.interp(t, *turned), float(t[0]), whole)
    return AxisDrift(
        axis, t, values - values[0], find_range(t, values, float(t[0]), whole),
        find_range(t, values, begin, min(begin + HOUR, end)), find_range(t, values, max(end - HOUR, begin), end),
        None if motion.test == "etve" else find_stability(t, values, begin, end),
        find_range(t, values, end, whole) if end < whole else float("nan"), tilt, offset,
    )  # fmt: skip


def _notes(motion: Motion, run: Trajectory | None) -> Iterator[str]:
    length = motion.end - motion.begin
    if length < HOUR:
        yield f"The motion lasts {length / 60:.3g} min: what stands for 60 min is all of it."
    elif length < 2 * HOUR and motion.test != "etve":
        yield f"The motion lasts {length / 60:.3g} min: too short to tell when it is stable."
    if motion.test.startswith("spindle") and len(motion.moving) > 1:
        yield f"More than the spindle moves ({', '.join(motion.moving)}): ISO 230-3 tests each of them alone."
    if run is not None:
        yield from run.warnings
