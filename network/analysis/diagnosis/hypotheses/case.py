"""A case: a machine and its recordings, laid out for fits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from network.analysis.calibration.gauss_newton import Problem, make_problem
from network.analysis.calibration.measured_means import Measured, RunPoint, weigh_recording
from network.analysis.calibration.noise import Noise
from network.analysis.diagnosis.candidates.recorded_powers import gather_runs, list_driving_columns
from network.analysis.diagnosis.lumps.additive_correction import AdditiveCorrection
from network.analysis.diagnosis.time_budget import TimeBudget
from network.catalogue.declaration.proposals import Runs
from network.engine.assembly import build
from network.engine.response.parameters import Parameter
from network.machine.machine import Machine
from network.recordings.inputs import Start
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class Case:
    """Recordings of a machine. sigma: white 1σ of a sample by channel where it was told from residuals; noise: coloured
    noise beside it; lacking: of each run, what its channels have more on finer lumps than on those of the machine,
    which stands in for them; began: of each run, the constants about which it is linear."""

    machine: Machine
    recordings: tuple[Recording, ...]
    start: Start | None = None
    noise: Noise = field(default_factory=Noise)
    sigma: Mapping[str, float] = field(default_factory=dict)
    lacking: tuple[AdditiveCorrection, ...] = ()
    began: tuple[RunPoint, ...] = ()
    budget: TimeBudget = field(default_factory=TimeBudget)

    @cached_property
    def drivers(self) -> tuple[str, ...]:
        """Columns of all recordings that may drive physics, written or missing."""
        return list_driving_columns(self.machine, self.recordings)

    @cached_property
    def runs(self) -> Runs:
        """What the recordings bring to proposals."""
        return gather_runs(self.machine, self.recordings, self.drivers)

    @cached_property
    def clock(self) -> tuple[float, float]:
        """When the first of the recordings begins and the last ends, by their own clocks [s]."""
        return min(float(r.t[0]) for r in self.recordings), max(float(r.t[-1]) for r in self.recordings)

    def of(self, runs: Sequence[int]) -> Case:
        """The case of some of its recordings."""
        lacking = tuple(self.lacking[i] for i in runs) if self.lacking else ()
        began = tuple(self.began[i] for i in runs) if self.began else ()
        return replace(self, recordings=tuple(self.recordings[i] for i in runs), lacking=lacking, began=began)

    def on(self, recordings: tuple[Recording, ...]) -> Case:
        """The case on other recordings, of which nothing is known beforehand."""
        return replace(self, recordings=recordings, start=None, lacking=(), began=())

    def until(self, share: float) -> Case:
        """The case of the beginnings of its recordings."""
        return replace(self, recordings=tuple(r.until(share) for r in self.recordings))

    def lay_out(self, machine: Machine) -> tuple[Measured, ...]:
        """The recordings for fits of one machine (this one, refined or with something added)."""
        network = build(machine)
        unread = {*self.drivers} - {*self.machine.inputs}
        data = [weigh_recording(machine, r, self.start, self._usable(r), network, unread) for r in self.recordings]
        laid = [replace(d, sigma={n: self.sigma.get(n, s) for n, s in d.sigma.items()}) for d in data]
        if self.lacking:
            laid = [replace(d, means=d.means - lack.at(d)) for d, lack in zip(laid, self.lacking, strict=True)]
        if self.began:
            laid = [d.about(point) for d, point in zip(laid, self.began, strict=True)]
        return tuple(laid)

    def _usable(self, recording: Recording) -> list[str]:
        """Drivers without gaps."""
        gaps = {n for n, c in recording.columns.items() if not np.isfinite(c.values).all()}
        return [n for n in self.drivers if n in recording.constants or n not in gaps]

    def problem(self, machine: Machine, parameters: Sequence[Parameter], offsets: bool = True) -> Problem:
        problem = make_problem(machine, parameters, self.lay_out(machine), self.noise)
        return problem if offsets else replace(problem, offsets=())
