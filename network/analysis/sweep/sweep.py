"""Sweeps: how far a machine may be simplified, and how the tool centre point answers to numbers of the machine file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from network.analysis.sweep.finer_lumps import bars_of, cut_bars
from network.analysis.sweep.grid_runs import GridJob, VariedRun, run_grid
from network.analysis.sweep.level_runs import (
    PAPER,
    Gap,
    Job,
    LevelRun,
    at_level,
    check_levels,
    run_level,
    run_machine,
    usual_levels,
    with_written,
)
from network.analysis.sweep.tolerance import Tolerance, parse_tolerance
from network.analysis.sweep.variations import Variation, check_grid, parse_variation
from network.engine.simulation import check_known, schedule_for
from network.machine.machine import Machine
from network.machine.overrides import AUTO
from network.platform.parallel import Told, run_all
from network.platform.printing import Tabled, summarise
from network.platform.refusal import Complaints, Spot, refuse
from network.recordings.call_arguments import expect_run
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

FINEST, QUICK = 500, 2.0
"""Lumps, and seconds of a solution, up to which the finest level is run once more with twice as many."""


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Tabled):
    """What a sweep gives: `levels` of one machine compared with the finest of them, or `runs` over the grid of the
    `variations`. source: name of the scenario or recording; beyond: the finest level with every bar cut once more."""

    machine: Machine
    source: str
    levels: tuple[LevelRun, ...] = ()
    variations: tuple[Variation, ...] = ()
    runs: tuple[VariedRun, ...] = ()
    tolerance: Tolerance | None = None
    beyond: LevelRun | None = None

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
        return max(self._temperature_gaps(run).values(), default=None)

    def furthest_temperature(self, run: LevelRun) -> str:
        """Where that difference is; empty where they share none, or do not differ."""
        gaps = self._temperature_gaps(run)
        return max(gaps, key=lambda name: gaps[name]) if any(gaps.values()) else ""

    def _temperature_gaps(self, run: LevelRun) -> dict[str, float]:
        shared = [name for name in run.temperatures if name in self.finest.temperatures]
        return {n: Gap.between(run.temperatures[n], self.finest.temperatures[n]).largest for n in shared}

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
        return summarise(self)


def sweep(
    machine: Machine, source: Scenario | Recording, *, levels: Sequence[str | int] = (), vary: Sequence[str] = (),
    tolerance: str | None = None, start: Start | None = None, method: str = "auto", jobs: int = 1,
    cluster: str | None = None, resume: str | Path | None = None, progress: Told | None = None,
) -> Sweep:  # fmt: skip
    """Runs a machine at several levels of simplification, or over a grid of values.

    levels: 'paper' (the closed form), numbers of lumps for every bar, 'auto' (see `choose_lumps`), names of levels of
    the machine file, which is itself run as written, too; without levels and vary: the usual ones; vary: 'path=lo..hi
    unit:N' or 'path=a,b,c unit', several make a grid; tolerance: like '1 um'; start, method: as in `simulate`; jobs:
    processes; cluster: address of a dask scheduler; resume: a file that keeps what is done of a grid, and from which a
    stopped sweep goes on; progress: told the share of the runs that are done. Raises Refused, and Failed where a run
    breaks down.
    """
    expect_run(machine, source, start)
    job = Job(machine, source, start, method)
    variations = tuple(parse_variation(text) for text in ([vary] if isinstance(vary, str) else vary))
    given = levels.split(",") if isinstance(levels, str) else levels
    names = tuple(dict.fromkeys(str(level).strip() for level in given))
    allowed = _check(job, names, variations, tolerance)
    if resume is not None and not variations:
        raise refuse(Spot("--resume"), "keeps the runs of a grid, and levels are few", "add --vary, or leave it out")
    result = Sweep(machine, source.name, variations=variations, tolerance=allowed)
    if variations:
        check_grid(machine, variations)
        return replace(result, runs=tuple(run_grid(GridJob(job, variations), jobs, cluster, resume, progress)))
    names = names or usual_levels(machine)
    check_levels(job, names)
    names = with_written(machine, names)
    if len(names) < 2:
        raise refuse(Spot("--levels"), "one level has nothing to be compared with", "give two or more, as in 1,2,4,8")
    result = replace(result, levels=tuple(run_all(partial(run_level, job), names, jobs, progress, cluster)))
    return replace(result, beyond=_run_beyond(job, result.finest))


def _run_beyond(job: Job, finest: LevelRun) -> LevelRun | None:
    """The finest level with twice the lumps in every bar; None for what has none, or would have too many."""
    if finest.level in (PAPER, AUTO):
        return None
    machine = at_level(job.machine, finest.level)
    twice = {name: 2 * count for name, count in bars_of(machine).items()}
    if not twice or machine.lumps + sum(twice.values()) > 2 * FINEST or finest.solve_seconds > QUICK:
        return None
    return run_machine(job, cut_bars(machine, twice), f"twice {finest.level}")


def _check(job: Job, levels: Sequence[str], variations: Sequence[Variation], tolerance: str | None) -> Tolerance | None:
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
