"""A thermal test of ISO 230-3: what every axis drifts, simulated or measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from network.analysis.acceptance.axis_drift import Asked, AxisDrift, evaluate_axes
from network.analysis.acceptance.drift_measures import HOUR, ORIGIN, SETTLED, combine, smooth_readings
from network.analysis.acceptance.motion import Motion, find_motion, rest
from network.analysis.sweep.lumping_error import LumpingError, estimate_lumping
from network.catalogue.declaration.declare import Array
from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.simulation import check_known, schedule_for, simulate
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.printing import Result
from network.platform.refusal import Failed, Refused, Spot, refuse
from network.recordings.call_arguments import expect_run
from network.recordings.counted_readings import drop_uncounted
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

Begins = Literal["in equilibrium", "at the reference", "as stated", "as read"]


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
    stable_share: float
    notes: tuple[str, ...]
    begins: Begins
    lumping: LumpingError | None = None

    @property
    def combined(self) -> float | None:
        """√(X² + Y² + Z²) of the drifts along linear axes [m]; None with fewer than two of them."""
        return combine([drift.drift for axis, drift in self.axes.items() if axis not in ANGULAR_AXES])

    @property
    def stable_origin(self) -> str:
        """Where the share comes from below which an hour counts as stable."""
        return ORIGIN if self.stable_share == SETTLED else "as asked for"

    def summary(self) -> dict[str, Any]:
        """What `--json` prints."""
        told: dict[str, Any] = {
            "test": self.motion.test, "title": f"ISO 230-3 {self.motion.title}", "machine": self.machine.name,
            "source": self.source.name, "from": "recording" if self.is_measured else "simulation",
            "motion_min": {"begin": self.motion.begin / 60, "end": self.motion.end / 60},
            "stable": {"share": self.stable_share, "origin": self.stable_origin},
            "axes": {axis: drift.summary(self.tool_length) for axis, drift in self.axes.items()},
            "combined": None if self.combined is None else {"value": 1e6 * self.combined, "unit": "um"},
            "begins": self.begins, "notes": list(self.notes),
            "lumping": None if self.lumping is None else self.lumping.summary(),
        }  # fmt: skip
        if self.simulated is not None:
            told["simulated"] = {axis: drift.summary(self.tool_length) for axis, drift in self.simulated.items()}
        return told


def evaluate_thermal_test(
    machine: Machine, source: Scenario | Recording, *, tool_length: float | None = None, start: Start | None = None,
    stable_share: float = SETTLED,
) -> ThermalTest:  # fmt: skip
    """An ISO 230-3 test of a machine: a program is simulated; of a recording the measured axes are told, and beside
    them what the machine file says. tool_length: beyond the tool centre point [m], along −z. stable_share: of the
    largest distortion of the first 60 min, below which the range of the last 60 min counts as stable.

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
    asked = Asked(tool_length, stable_share)
    axes, beside = evaluate_axes(told, motion, asked, position), None
    if isinstance(source, Recording):
        simulated, axes = axes, evaluate_axes(dict(_measured(machine, source)), motion, asked, None)
        beside = {axis: drift for axis, drift in simulated.items() if axis in axes} or None
    return ThermalTest(
        machine, source, motion, axes, isinstance(source, Recording), beside, run, tool_length, stable_share,
        tuple(_notes(motion, run)), begins, lumping,
    )  # fmt: skip


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
