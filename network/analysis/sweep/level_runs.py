"""Simplification levels of a machine, each run: the paper's closed form, N lumps in every bar, or a named level."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from statistics import median

import numpy as np

from network.analysis.comparison.channel_residual import ChannelResidual, pool_residuals
from network.analysis.comparison.compare import check_fit
from network.analysis.sweep.lump_choice import choose_lumps
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.sections import section
from network.engine.observe import channel
from network.engine.paper.closed_form import ClosedForm, closed_form
from network.engine.paper.spindle_unit import SpindleUnit
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.machine.lumps import level_patch
from network.machine.machine import Machine
from network.machine.overrides import AUTO, set_lumps
from network.platform.printing import Brief
from network.platform.refusal import Complaints, Refused, Spot, likely, refuse, short
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

PAPER = "paper"
WRITTEN = "as written"
REPEATS = 3
LONG = 1.0
"""s: a solution that takes longer is timed once."""
USUAL = ("1", "2", "4", "8", "16")


@dataclass(frozen=True, eq=False, repr=False)
class Job(Brief):
    """What all runs of a sweep have in common."""

    machine: Machine
    source: Scenario | Recording
    start: Start | None = None
    method: str = "auto"


@dataclass(frozen=True, eq=False, repr=False)
class LevelRun(Brief):
    """One level along a schedule. lumps: of all parts; t [s]; tcp: axis → displacement [m] or angle [rad];
    temperatures: of the temperature sensors, or of the parts where there are none [°C]; in_noise, tcp_in_noise: rms
    to the recording over all channels, and over those of displacement, NaN without; closed_form: of the paper's."""

    level: str
    lumps: int
    t: Array
    tcp: Mapping[str, Array]
    temperatures: Mapping[str, Array]
    in_noise: float
    tcp_in_noise: float
    solve_seconds: float
    method: str
    closed_form: ClosedForm | None = None


def usual_levels(machine: Machine) -> tuple[str, ...]:
    """The levels of a sweep that names none."""
    named = section(machine.tree, "levels").items
    return (*([PAPER] if "spindle" in machine.closed_form else []), *USUAL, *named)


def with_written(machine: Machine, levels: tuple[str, ...]) -> tuple[str, ...]:
    """The levels with the machine as its file has it among them, unless a number of lumps says the same."""
    counts = {str(node.lumps) for node in machine.nodes.values() if node.is_bar}
    if WRITTEN in levels or (len(counts) == 1 and counts & set(levels)):
        return levels
    first = 1 if levels[:1] == (PAPER,) else 0
    return (*levels[:first], WRITTEN, *levels[first:])


def check_levels(job: Job, levels: tuple[str, ...]) -> None:
    """Raises Refused with every level that this machine cannot have, or for a recording that does not fit."""
    complaints = Complaints()
    for level in (level for level in levels if level != AUTO):
        try:
            at_level(job.machine, level)
        except Refused as refused:
            complaints.absorb(refused)
    complaints.raise_if_any()
    if isinstance(job.source, Recording) and any(name in job.source.columns for name in job.machine.sensors):
        check_fit(job.machine, job.source)


def at_level(machine: Machine, level: str) -> Machine:
    """The machine at a level; `paper` leaves it as it is. Raises Refused."""
    spot, named = Spot("--levels"), section(machine.tree, "levels").items
    if level == PAPER:
        SpindleUnit.of(machine)
        return machine
    if level == WRITTEN and level not in named:
        return machine
    if level in named:
        return Machine.read(level_patch(machine, level), machine.file)
    if not re.fullmatch("[1-9][0-9]{0,8}", level):
        near = likely(level, [PAPER, AUTO, *named])
        right = near if near.endswith("?") else f"{near}, and any number of lumps from 1"
        raise refuse(spot, f"there is no level '{short(level)}'", right)
    if not any(node.is_bar for node in machine.nodes.values()):
        raise refuse(spot, f"level {level} means lumps, and the machine has no bar", "name levels of the machine file")
    return Machine.read(set_lumps(machine.tree, level, spot), machine.file)


def run_level(job: Job, level: str) -> LevelRun:
    """The machine at that level, run; how long it takes is the median of three solutions."""
    if level == PAPER:
        return _run_paper(job)
    if level == AUTO:
        return run_machine(job, choose_lumps(job.machine, job.source, start=job.start).machine, level)
    return run_machine(job, at_level(job.machine, level), level)


def run_machine(job: Job, machine: Machine, level: str) -> LevelRun:
    """A machine run as a level of that name."""
    sensed = any(sensor.place is not None for sensor in machine.sensors.values())
    runs = list(_repeat(job, machine, parts=not sensed))
    run, seconds = runs[0], median(run.solve_seconds for run in runs)
    shown = {n: v for n, v in run.sensors.items() if machine.sensors[n].place is not None}
    if not sensed:
        shown = {name: T for name, T in run.parts.items() if machine.nodes[name].is_part}
    return LevelRun(level, machine.lumps, run.t, run.tcp, shown, *_in_noise(job, run.sensors), seconds, run.method)


def _repeat(job: Job, machine: Machine, parts: bool) -> Iterator[Trajectory]:
    for _ in range(REPEATS):
        run = simulate(machine, job.source, start=job.start, method=job.method, parts=parts)
        yield run
        if run.solve_seconds > LONG:
            return


def _run_paper(job: Job) -> LevelRun:
    forms = [closed_form(job.machine, job.source, job.start) for _ in range(REPEATS)]
    form, seconds = forms[0], median(form.solve_seconds for form in forms)
    sensors = {
        name: channel(name, sensor, {}, form.tcp, {}, {"time": form.t})
        for name, sensor in job.machine.sensors.items()
        if sensor.axis in form.tcp
    }
    lumps = 1 + (form.unit.beam is not None)
    return LevelRun(PAPER, lumps, form.t, form.tcp, {}, *_in_noise(job, sensors), seconds, "closed form", form)


def _in_noise(job: Job, simulated: Mapping[str, Array]) -> tuple[float, float]:
    """Rms of the residuals to the recording in units of noise: of all channels, and of displacements alone."""
    if not isinstance(job.source, Recording):
        return float("nan"), float("nan")
    sensors, columns, t = job.machine.sensors, job.source.columns, job.source.t
    residuals = [
        ChannelResidual(name, sensors[name].unit, t, columns[name].values, values, sensors[name].sigma)
        for name, values in simulated.items()
        if name in columns
    ]
    moved = [residual for residual in residuals if sensors[residual.name].axis is not None]
    everything, displacement = (pool_residuals(some) if some else float("nan") for some in (residuals, moved))
    return everything, displacement


@dataclass(frozen=True)
class Gap:
    """How far a level is from the finest: the largest and the rms difference, in SI."""

    largest: float
    rms: float

    @classmethod
    def between(cls, values: Array, finest: Array) -> Gap:
        off = np.abs(values - finest)
        return cls(float(off.max()), float(np.sqrt(np.mean(off**2))))
