"""Residuals: what was measured less what was simulated, per channel, in units of the declared noise."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from network.analysis.comparison.channel_residual import ChannelResidual, pool_residuals
from network.analysis.comparison.common_start import share_start_rule
from network.catalogue.declaration.entry_path import displacement
from network.engine.simulation import schedule_for, simulate
from network.engine.solvers.carry_out import Progress
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.printing import Brief, Tabled
from network.platform.quantities.units import unit
from network.platform.refusal import Complaints, Spot, list_first, refuse
from network.recordings.call_arguments import as_several, expect, expect_start
from network.recordings.counted_readings import drop_uncounted
from network.recordings.hygiene.set_aside import summarise_excluded
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.recording_checks import check_readings
from network.recordings.runs import runs_of, tell_excluded
from network.recordings.scenario import Scenario
from network.recordings.twins import check_once

if TYPE_CHECKING:
    from network.analysis.comparison.examine import ChannelTests
    from network.analysis.comparison.run_constants import RunConstants


@dataclass(frozen=True, eq=False, repr=False)
class RecordingResidual(Brief):
    """All channels of one recording, with the run they were compared to; constants: where these were estimated."""

    recording: Recording
    trajectory: Trajectory
    channels: Mapping[str, ChannelResidual]
    unused: tuple[str, ...]
    constants: RunConstants | None = None

    @property
    def rmse_in_noise(self) -> float:
        return pool_residuals(self.channels.values())

    @cached_property
    def tests(self) -> Mapping[str, ChannelTests]:
        """Whiteness, periods, drivers and regimes of every channel that has readings."""
        from network.analysis.comparison.examine import examine

        return examine(self.channels, self.trajectory, self.recording.columns, self.unused)

    def summary(self) -> dict[str, Any]:
        tests = {name: found.summary() for name, found in self.tests.items()}
        channels = {name: channel.summary() | {"tests": tests.get(name)} for name, channel in self.channels.items()}
        excluded = summarise_excluded(self.recording.excluded or ())
        rmse = {"rmse_in_noise": self.rmse_in_noise}
        return {"file": self.recording.file, "channels": channels, **rmse, "excluded": excluded}


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Tabled):
    """Residuals of a machine on its recordings."""

    machine: Machine
    recordings: tuple[RecordingResidual, ...]

    @property
    def rmse_in_noise(self) -> float:
        """√mean((residual/noise)²) over all finite samples, channels and recordings."""
        return pool_residuals(channel for r in self.recordings for channel in r.channels.values())

    @property
    def warnings(self) -> list[str]:
        """What was set aside, a sentence each."""
        return tell_excluded(r.recording for r in self.recordings)

    def summary(self) -> dict[str, Any]:
        """What `compare --json` prints."""
        return {"recordings": [r.summary() for r in self.recordings], "rmse_in_noise": self.rmse_in_noise}

    def __repr__(self) -> str:
        return f"<comparison of {self.machine.name} on {len(self.recordings)}: rmse {self.rmse_in_noise:.3g} σ>"


def compare(
    machine: Machine, recordings: Recording | Iterable[Recording], *, start: Start | None = None, method: str = "auto",
    progress: Progress | None = None, rtol: float | None = None,
) -> Comparison:  # fmt: skip
    """Simulates the machine along a recording, or each of several, and lays the measured channels beside it; rtol: of
    what is solved step by step.

    Raises Refused where a recording lacks an input, shares no channel with the machine, has a channel in a unit that
    does not fit, or is given twice.
    """
    expect("machine", machine, Machine)
    expect_start(start)
    given, complaints = as_several(recordings), Complaints()
    check_once(given, complaints)
    complaints.raise_if_any()
    runs = share_start_rule(machine, runs_of(machine, given), start)
    return Comparison(machine, tuple(_compare_one(machine, r, start, method, progress, rtol) for r in runs))


def check_fit(machine: Machine, source: Scenario | Recording) -> None:
    """Whether a scenario or recording has what the machine needs. Raises Refused with all that is missing."""
    schedule_for(machine, source)
    if isinstance(source, Recording):
        _check_units(machine, source, _channels(machine, source))


def _channels(machine: Machine, recording: Recording) -> list[str]:
    names = [name for name in machine.sensors if name in recording.columns]
    if not machine.sensors:
        right = "add what is measured, like `sensors: {T_housing: {measures: housing, noise: 0.05 K}}`"
        raise refuse(Spot(machine.file), "the machine has no sensors, so no recording can be laid beside it", right)
    if not names:
        right = "name its columns like the sensors: " + ", ".join(machine.sensors)
        there = f" (there are: {list_first([*recording.columns])})" if recording.columns else ""
        raise refuse(Spot(recording.file), f"no column is a sensor of this machine{there}", right)
    return names


def _compare_one(
    machine: Machine, recording: Recording, start: Start | None, method: str, progress: Progress | None,
    rtol: float | None,
) -> RecordingResidual:  # fmt: skip
    names = _channels(machine, recording)
    _check_units(machine, recording, names)
    recording = drop_uncounted(machine, recording)
    run = simulate(machine, recording, start=start, method=method, parts=False, progress=progress, rtol=rtol)
    channels = {
        name: ChannelResidual(
            name, machine.sensors[name].unit, run.t, recording.columns[name].values,
            run.sensors[name], machine.sensors[name].sigma, recording.columns[name].spread,
        )
        for name in names
    }  # fmt: skip
    if not any(channel.n for channel in channels.values()):
        wrong = "no value that can be true" if recording.excluded else "no value at all"
        raise refuse(Spot(recording.file), f"the measured channels hold {wrong}", "give at least one reading")
    known = {*machine.sensors, *machine.inputs, *map(displacement, machine.tcp)}
    unused = tuple(name for name in recording.columns if name not in known)
    return RecordingResidual(recording, run, channels, unused)


def _check_units(machine: Machine, recording: Recording, names: Iterable[str]) -> None:
    complaints = Complaints()
    for name in names:
        column, sensor = recording.columns[name], machine.sensors[name]
        if unit(column.unit).dimension != unit(sensor.unit).dimension:
            wrong = f"the column '{name}' is in {column.unit}, and the sensor {name} measures a {sensor.quantity}"
            complaints.refuse(Spot(recording.file, 1), wrong, f"give it in a unit like {sensor.unit}")
    check_readings(machine, recording, complaints)
    complaints.raise_if_any()
