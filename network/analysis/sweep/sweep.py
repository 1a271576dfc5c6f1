"""Sweeps: how far a machine may be simplified, and how the tool centre point answers to numbers of the machine file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

from network.analysis.sweep.level_runs import PAPER, Gap, Job, LevelRun, check_levels, run_level, usual_levels
from network.analysis.sweep.tolerance import Tolerance, parse_tolerance
from network.analysis.sweep.variations import (
    Extremes,
    GridJob,
    Variation,
    VariedRun,
    check_grid,
    grid,
    parse_variation,
    run_varied,
)
from network.engine.simulation import check_known, schedule_for
from network.engine.trajectory import axis_unit
from network.machine.machine import Machine
from network.platform.parallel import Told, run_all
from network.platform.quantities.units import unit
from network.platform.refusal import Complaints, Spot, refuse
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Sweep:
    """What a sweep gives: `levels` of one machine compared with the finest of them, or `runs` over the grid of the
    `variations`. source: name of the scenario or recording."""

    machine: Machine
    source: str
    levels: tuple[LevelRun, ...] = ()
    variations: tuple[Variation, ...] = ()
    runs: tuple[VariedRun, ...] = ()
    tolerance: Tolerance | None = None

    @cached_property
    def finest(self) -> LevelRun:
        """The level with the most lumps; among equals the last."""
        return max(reversed(self.levels), key=lambda run: (run.level != PAPER, run.lumps))

    def gap(self, run: LevelRun, axis: str) -> Gap | None:
        """How far a level's tool centre point is from the finest level's [m or rad]; None where the level does not
        move that axis."""
        if axis not in run.tcp or axis not in self.finest.tcp:
            return None
        return Gap.between(run.tcp[axis], self.finest.tcp[axis])

    def temperature_gap(self, run: LevelRun) -> float | None:
        """The largest difference of a temperature to the finest level's [K]; None where they share none."""
        shared = [name for name in run.temperatures if name in self.finest.temperatures]
        gaps = [Gap.between(run.temperatures[name], self.finest.temperatures[name]) for name in shared]
        return max((gap.largest for gap in gaps), default=None)

    def stays_within(self, run: LevelRun, tolerance: Tolerance) -> bool:
        """Whether a level keeps to the tolerance on every axis that it concerns."""
        gaps = [self.gap(run, axis) for axis in self.finest.tcp if tolerance.concerns(axis)]
        return all(gap is not None and gap.largest <= tolerance.value for gap in gaps)

    @property
    def coarsest_within(self) -> LevelRun | None:
        """The level with the fewest lumps, other than the finest, that keeps to the tolerance; None where none does."""
        if self.tolerance is None:
            return None
        good = [run for run in self.levels if run is not self.finest and self.stays_within(run, self.tolerance)]
        return min(good, key=lambda run: run.lumps, default=None)

    def summary(self) -> dict[str, Any]:
        """What sweep.json holds and --json prints."""
        from network.report.words.sweep_words import tell_tolerance

        told: dict[str, Any] = {"machine": self.machine.name, "source": self.source}
        if self.runs:
            return told | {"vary": [v.summary() for v in self.variations], "runs": [self._point(r) for r in self.runs]}
        told |= {"levels": [self._level(run) for run in self.levels], "finest": self.finest.level}
        for form in (run.closed_form for run in self.levels if run.closed_form is not None):
            told["closed_form"] = form.summary()
        if self.tolerance is not None:
            level = self.coarsest_within.level if self.coarsest_within else None
            told["tolerance"] = self.tolerance.summary() | {"level": level, "sentence": tell_tolerance(self)}
        return told

    def _level(self, run: LevelRun) -> dict[str, Any]:
        tcp = {axis: Extremes.of(axis, values).summary() for axis, values in run.tcp.items()}
        for axis, told in tcp.items():
            if gap := self.gap(run, axis):
                scale = unit(axis_unit(axis)).scale
                told["difference"] = {"max": gap.largest / scale, "rms": gap.rms / scale}
        return {
            "level": run.level, "lumps": run.lumps, "tcp": tcp, "temperature_difference": self.temperature_gap(run),
            "rmse_in_noise": run.in_noise, "tcp_rmse_in_noise": run.tcp_in_noise,
            "solve_seconds": run.solve_seconds, "method": run.method,
        }  # fmt: skip

    def _point(self, run: VariedRun) -> dict[str, Any]:
        values = {v.path: value for v, value in zip(self.variations, run.values, strict=True)}
        return {"values": values, "tcp": {axis: extremes.summary() for axis, extremes in run.tcp.items()}}

    def __str__(self) -> str:
        from network.report.words.sweep_words import tell_sweep

        return tell_sweep(self)


def sweep(
    machine: Machine, source: Scenario | Recording, *, levels: Sequence[str | int] = (), vary: Sequence[str] = (),
    tolerance: str | None = None, start: Start | None = None, method: str = "auto", jobs: int = 1,
    cluster: str | None = None, progress: Told | None = None,
) -> Sweep:  # fmt: skip
    """Runs a machine at several levels of simplification, or over a grid of values.

    levels: 'paper' (the closed form), numbers of lumps for every bar, names of levels of the machine file; without
    levels and vary: the usual ones; vary: 'path=lo..hi unit:N' or 'path=a,b,c unit', several make a grid; tolerance:
    like '1 um'; start, method: as in `simulate`; jobs: processes; cluster: address of a dask scheduler; progress: told
    the share of the runs that are done. Raises Refused, and Failed where a run breaks down.
    """
    job = Job(machine, source, start, method)
    variations = tuple(parse_variation(text) for text in vary)
    names = tuple(dict.fromkeys(str(level).strip() for level in levels))
    allowed = _checked(job, names, variations, tolerance)
    result = Sweep(machine, source.name, variations=variations, tolerance=allowed)
    if variations:
        check_grid(machine, variations)
        runs = run_all(partial(run_varied, GridJob(job, variations)), list(grid(variations)), jobs, progress, cluster)
        return replace(result, runs=tuple(runs))
    names = names or usual_levels(machine)
    if len(names) < 2:
        raise refuse(Spot("--levels"), "one level has nothing to be compared with", "give two or more, as in 1,2,4,8")
    check_levels(job, names)
    return replace(result, levels=tuple(run_all(partial(run_level, job), names, jobs, progress, cluster)))


def _checked(
    job: Job, levels: Sequence[str], variations: Sequence[Variation], tolerance: str | None
) -> Tolerance | None:
    """The tolerance. Raises Refused for what no sweep can do."""
    complaints, machine = Complaints(), job.machine
    if levels and variations:
        right = "vary at one level with --level or --lumps, or sweep the levels alone"
        complaints.refuse(Spot("--vary"), "levels and values are two different sweeps", right)
    if tolerance is not None and variations:
        complaints.refuse(Spot("--tolerance"), "compares levels, and --vary gives none", "leave one of them out")
    if not machine.expansions:
        right = "add entries below `tcp:`, or use lptn simulate"
        complaints.refuse(Spot(machine.file), "the machine moves no tool centre point, which a sweep looks at", right)
    complaints.raise_if_any()
    if not variations:
        check_known(machine)
    schedule_for(machine, job.source, job.start)
    return parse_tolerance(tolerance, machine) if tolerance is not None else None
