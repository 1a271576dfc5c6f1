"""What the cut into lumps costs a run: the same run once more with every bar cut more finely."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from network.analysis.comparison.compare import RecordingResidual, compare
from network.analysis.sweep.finer_lumps import SHARE, Change, bars_of, compare_courses, cut_bars
from network.analysis.sweep.lump_choice import LumpChoice, choose_lumps
from network.catalogue.nodes import MOST_IN_ALL
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.printing import Result
from network.platform.refusal import Failed, Refused
from network.recordings.call_arguments import expect_run
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

FINE = 16
"""Lumps of every bar in the finer run, at least: what a bar of one lump is off by shrinks at least with the length of a
lump, so what is seen is 94 % of it or more."""
QUICK = 10.0
"""s that a run may have taken for it to be run again without being asked."""
EXACT, MOST_STEPPED = ("modal", "expm", "krylov", "switched"), 2000
"""Methods that many lumps do not make slow; how many another one may be given: some 20 s."""
FEW, SHORT = 40, 20_000
"""Bars and samples of a linear machine without switchings up to which the lumps of every bar are looked for unasked."""


@dataclass(frozen=True, eq=False, repr=False)
class LumpingError(Result):
    """changes: finer run less this one, by channel; lumps, finer: of every bar in both; choice: lumps that would be
    enough, where they were looked for; noise: rms residual of a recording [σ], as cut and cut finely."""

    machine: Machine
    lumps: Mapping[str, int]
    finer: Mapping[str, int]
    changes: tuple[Change, ...]
    choice: LumpChoice | None = None
    noise: tuple[float, float] | None = None

    @property
    def is_within(self) -> bool:
        """Whether no channel is off by more than the tolerance."""
        return all(change.is_within for change in self.changes)

    def summary(self) -> dict[str, Any]:
        noise = None if self.noise is None else {"as_cut": self.noise[0], "finer": self.noise[1]}
        return {
            "within": self.is_within, "tolerance": SHARE, "lumps": dict(self.lumps), "finer": dict(self.finer),
            "channels": {change.name: change.summary() for change in self.changes}, "rmse_in_noise": noise,
            "needed": None if self.choice is None else dict(self.choice.lumps),
        }  # fmt: skip

    def __repr__(self) -> str:
        worst = max(self.changes, key=lambda change: change.share)
        return f"<lumping of {self.machine.name}: {worst.name} off by {worst.share:.2g} of its range>"


def estimate_lumping(
    machine: Machine, source: Scenario | Recording, run: Trajectory | None = None, *, start: Start | None = None,
    method: str = "auto", asks: bool = True,
) -> LumpingError | None:  # fmt: skip
    """What finer lumps would change along a scenario or recording: every bar twice as fine, 16 lumps at least.

    run: as simulated, without noise; asks: where channels are off by more than 2 % of their range and the machine is
    linear, finds the lumps that would be enough, too. None for a machine without bars, one that is cut as finely as can
    be, a run that took long or would then, or one that breaks down or is too much to tell when cut more finely.
    """
    expect_run(machine, source, start)
    finer = cut_finely(machine)
    if finer is None:
        return None
    run = run or simulate(machine, source, start=start, method=method)
    if run.solve_seconds > QUICK or _would_take_long(run, finer):
        return None
    try:
        fine = simulate(finer, source, start=start, method=method)
    except (Failed, Refused):  # it breaks down, or has more courses than there is room for
        return None
    return _judge(machine, source, run, fine, start, asks)


def estimate_over(machine: Machine, runs: Iterable[tuple[Scenario | Recording, Trajectory]]) -> LumpingError | None:
    """The same along the one of several runs on which finer lumps would change most, without asking for more."""
    found = (estimate_lumping(machine, source, run, asks=False) for source, run in runs)
    known = [error for error in found if error is not None]
    return max(known, key=lambda error: max(change.size for change in error.changes), default=None)


def estimate_on_recording(
    machine: Machine, residuals: Sequence[RecordingResidual], *, start: Start | None = None, method: str = "auto",
    asks: bool = True,
) -> LumpingError | None:  # fmt: skip
    """The same along the one of several recordings on which the machine is furthest off, with what finer lumps would
    leave there."""
    finer = cut_finely(machine)
    residual = max(residuals, key=lambda r: r.rmse_in_noise)
    run = residual.trajectory
    if finer is None or run.solve_seconds > QUICK or _would_take_long(run, finer):
        return None
    try:
        if residual.constants is not None:
            residual = compare(machine, residual.recording, start=start, method=method).recordings[0]
        fine = compare(finer, residual.recording, start=start, method=method).recordings[0]
    except (Failed, Refused):
        return None
    found = _judge(machine, residual.recording, residual.trajectory, fine.trajectory, start, asks)
    return replace(found, noise=(residual.rmse_in_noise, fine.rmse_in_noise))


def _would_take_long(run: Trajectory, finer: Machine) -> bool:
    return run.method not in EXACT and finer.lumps > MOST_STEPPED


def cut_finely(machine: Machine) -> Machine | None:
    """Every bar twice as fine, into 16 lumps at least; None where there is none, or it would be too many."""
    lumps = bars_of(machine)
    finer = {name: max(FINE, 2 * count) for name, count in lumps.items()}
    if not lumps or machine.lumps + sum(finer.values()) - sum(lumps.values()) > MOST_IN_ALL:
        return None
    try:
        return cut_bars(machine, finer)
    except Refused:  # more pairs of lumps than can be joined
        return None


def _judge(
    machine: Machine, source: Scenario | Recording, run: Trajectory, fine: Trajectory, start: Start | None, asks: bool
) -> LumpingError:
    found = LumpingError(machine, bars_of(machine), bars_of(fine.machine), compare_courses(run, fine))
    easy = run.network.is_affine() and not run.switches and len(found.lumps) <= FEW and len(run.t) <= SHORT
    if found.is_within or not asks or not easy:
        return found
    return replace(found, choice=choose_lumps(machine, source, start=start))
