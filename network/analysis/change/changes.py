"""What `lptn diagnose … --reference …` finds: numbers and sensors that changed, and how far each moves the tool."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from network.analysis.calibration.calibrated_patch import with_fitted_numbers
from network.analysis.calibration.recording_admission import admit, check_apart, check_parameters
from network.analysis.change.change_screening import Difference
from network.analysis.change.change_search import Split, split_changes
from network.analysis.change.paired_fit import PairedFit
from network.analysis.comparison.common_start import doubt_starts, share_starts
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter, at_values, free_parameters, values_at
from network.engine.simulation import simulate
from network.engine.trajectory import axis_unit
from network.machine.machine import Machine
from network.platform.printing import tell
from network.platform.quantities.units import difference, unit
from network.platform.threads import on_one_thread
from network.recordings.call_arguments import as_several, expect_fit
from network.recordings.channel_match import overheard
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.runs import runs_of

MOST = 10.0
"""Logarithm of a change beyond which it is no matter how much more it would have to be."""


@dataclass(frozen=True)
class Change:
    """number: its path, or that of a sensor's constant error, `sensors.T.offset`; parameter: None of a sensor; then,
    now, std: values and 1σ of their difference, in `unit`; sigma: the difference in its σ; moved: axis → the largest
    movement [m, rad] that it makes over the recordings of now; alike: numbers that explain the same."""

    number: str
    parameter: Parameter | None
    unit: str
    then: float
    now: float
    std: float
    sigma: float
    moved: Mapping[str, float]
    alike: tuple[str, ...]

    @property
    def most(self) -> tuple[str, float]:
        """The axis that it moves furthest, and how far [m, rad]; nothing where there is none."""
        return max(self.moved.items(), key=lambda item: abs(item[1]), default=("", 0.0))

    def summary(self) -> dict[str, Any]:
        axis, far = self.most
        return {
            "number": self.number, "then": self.then, "now": self.now, "unit": self.unit, "std": self.std,
            "sigma": self.sigma, "um": far / unit(axis_unit(axis)).scale if axis else None, "axis": axis,
            "alike": list(self.alike),
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Changes:
    """machine: as given; before, after: with the numbers of then and of now, and their ±; found: the gravest first;
    tested: numbers and sensors that could have changed → difference in its σ, each alone beside what was found; least:
    number → relative change from which it would have been told; limit: σ that counts as a change; scales: what both
    sets leave, in noise, longer-lasting misfit counting more; then, now: files."""

    machine: Machine
    before: Machine
    after: Machine
    found: tuple[Change, ...]
    tested: Mapping[str, float]
    least: Mapping[str, float]
    limit: float
    scales: tuple[float, float]
    then: tuple[str, ...]
    now: tuple[str, ...]
    warnings: tuple[str, ...]
    seed: int
    seconds: float

    @cached_property
    def verdict(self) -> str:
        numbers = any(change.parameter is not None for change in self.found)
        return "parameters_only" if numbers else "sensor_fault" if self.found else "adequate"

    def summary(self) -> dict[str, Any]:
        """diagnosis.json."""
        return {
            "verdict": self.verdict, "changed": [change.summary() for change in self.found], "findings": [],
            "tested": dict(self.tested), "least": dict(self.least),
            "limit_sigma": self.limit, "misfit": dict(zip(("then", "now"), self.scales,
                                                                                 strict=True)),
            "reference": list(self.then), "recordings": list(self.now), "notes": list(self.warnings),
            "machine": "machine.diagnosed.yaml", "seed": self.seed, "seconds": self.seconds,
        }  # fmt: skip

    def __str__(self) -> str:
        return tell(self)


@on_one_thread
def find_changes(
    machine: Machine, now: Recording | Iterable[Recording], then: Recording | Iterable[Recording], *,
    start: Start | None = None, seed: int = 0, progress: Callable[[float], None] | None = None,
) -> Changes:  # fmt: skip
    """Which numbers with ±, and which sensors, differ between the recordings of now and of then.

    start: overrides where runs begin; seed: of further beginnings of the fit; progress: told the share done. Raises
    Refused for recordings that cannot be used, or that stand on both sides, Failed where every run breaks down.
    """
    began, given = time.perf_counter(), (as_several(then), as_several(now))
    expect_fit(machine, given[0] and given[1], start)
    parameters = free_parameters(machine)
    check_parameters(machine, parameters)
    check_apart([*given[0], *given[1]], [])
    parted = [runs_of(machine, some, keeps_departures=True) for some in given]
    sides = share_starts(machine, parted[0], parted[1], start)
    let_in = admit(machine, parameters, [*sides[0], *sides[1]], start)
    data = let_in.data[: len(sides[0])], let_in.data[len(sides[0]) :]
    with np.errstate(over="ignore", invalid="ignore"):
        split = split_changes(machine, *data, start, seed, progress or (lambda share: None))
    doubts = doubt_starts(machine, [*sides[0], *sides[1]], start)
    return Changes(
        machine, _machine_at(split.at, 0), _machine_at(split.at, 1), tuple(_tell_all(split, sides[1], start)),
        {_name(split.at, each.entry): each.value / each.std for each in split.tested}, _least(split), split.limit,
        split.at.sets.scales, _files(given[0]), _files(given[1]),
        (*overheard(machine, *given), *doubts, *let_in.warnings), seed, time.perf_counter() - began,
    )  # fmt: skip


def _least(split: Split) -> dict[str, float]:
    """Of numbers that only have a size, by how much more or less they would have to be to be told."""
    numbers = split.at.sets.parameters
    least = {numbers[d.entry].path: math.expm1(min(split.limit * d.std, MOST)) for d in split.tested
             if d.entry < len(numbers) and numbers[d.entry].is_log}  # fmt: skip
    return dict(sorted(least.items(), key=lambda item: item[1]))


def _files(recordings: Iterable[Recording]) -> tuple[str, ...]:
    return tuple(recording.file for recording in recordings)


def _numbers_of(at: PairedFit, now: int) -> Array:
    return np.asarray((at.p + now * at.d)[: len(at.sets.parameters)])


def _machine_at(at: PairedFit, now: int) -> Machine:
    """The machine with the numbers of then (0) or now (1) and their 1σ."""
    H, _ = at.system(at.spread)
    size, n, free = len(at.p), len(at.sets.parameters), np.flatnonzero(at.free)
    C = np.linalg.inv(H)
    G = np.zeros((n, len(H)))
    G[:, :n] = np.eye(n)
    for k, j in enumerate(free.tolist()):
        if now and j < n:
            G[j, size + k] = 1.0
    std = np.sqrt(np.einsum("ij,jk,ik->i", G, C, G))
    std = np.minimum(std, [p.spread for p in at.sets.parameters])
    return with_fitted_numbers(at.sets.machine, at.sets.parameters, _numbers_of(at, now), std)


def _tell_all(split: Split, runs: Sequence[Recording], start: Start | None) -> list[Change]:
    found = [_tell(split, each, runs, start) for each in split.differences]
    return sorted(found, key=lambda change: -change.sigma)


def _tell(split: Split, each: Difference, runs: Sequence[Recording], start: Start | None) -> Change:
    at, j = split.at, each.entry
    n = len(at.sets.parameters)
    if j >= n:
        return _tell_sensor(split, each)
    p, theta = at.sets.parameters[j], (float(at.p[j]), float(at.p[j] + at.d[j]))
    then, now = (p.to_unit(p.value(x)) for x in theta)
    std = p.std_to_unit(p.std(theta[1], each.std))
    moved = _movement(at, j, runs, start)
    return Change(p.path, p, p.field.unit, then, now, std, each.sigma, moved, _equals(split, j))


def _tell_sensor(split: Split, each: Difference) -> Change:
    at, j = split.at, each.entry
    sensor = at.sets.machine.sensors[at.sets.channels[j - len(at.sets.parameters)]]
    scale = difference(unit(sensor.unit)).scale
    then, now, std = (float(x) / scale for x in (at.p[j], at.p[j] + each.value, each.std))
    moved = {sensor.axis: each.value} if sensor.axis is not None else dict[str, float]()
    name = "K" if sensor.unit == "degC" else sensor.unit
    return Change(_name(at, j), None, name, then, now, std, each.sigma, moved, _equals(split, j))


def _equals(split: Split, entry: int) -> tuple[str, ...]:
    return tuple(_name(split.at, k) for k in split.alike.get(entry, ()))


def _name(at: PairedFit, entry: int) -> str:
    n = len(at.sets.parameters)
    return at.sets.parameters[entry].path if entry < n else f"sensors.{at.sets.channels[entry - n]}.offset"


def _movement(at: PairedFit, entry: int, runs: Sequence[Recording], start: Start | None) -> dict[str, float]:
    """What the tool moves otherwise along the recordings of now because this number is what it is now."""
    parameters, theta = at.sets.parameters, _numbers_of(at, 1)
    before = theta.copy()
    before[entry] = at.p[entry]
    machines = [at_values(at.sets.machine, values_at(parameters, x)) for x in (before, theta)]
    moved = dict.fromkeys(at.sets.machine.tcp, 0.0)
    for run in runs:
        then, now = (simulate(machine, run, start=start, parts=False) for machine in machines)
        for axis in moved:
            change = now.tcp[axis] - then.tcp[axis]
            far = float(change[np.argmax(np.abs(change))])
            moved[axis] = max(moved[axis], far, key=abs)
    return moved
