"""Steps of inputs, which of them may make a channel jump, and whether it jumps with one by more than they make it jump.

What an input u makes a channel jump by goes with |Δu| or, as a shaft that grows with its speed, with |Δu²|: by least
squares with no coefficient below zero, from what the channel does at other steps of all inputs. What is left there says
how far off that may be (Student's t). Source: Lawson & Hanson, Solving Least Squares Problems (1974), ch. 23, as in
scipy.optimize.nnls; unverified.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.stats import binom
from scipy.stats import t as student

from network.analysis.diagnosis.intermittent.change_points import Steps
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Array
from network.engine.response.knots import list_jumps
from network.engine.response.measured_run import Run

MANY = 4
"""Steps elsewhere that say something of one: what is left at fewer says nothing of how far off it may be."""


@dataclass(frozen=True)
class InputStep:
    """Inputs that step in a run at a time [s]; moved: of each |Δu| and |Δu²| [SI]."""

    run: int
    t: float
    moved: Mapping[str, tuple[float, float]]

    def by(self, names: Sequence[str]) -> Array:
        """|Δu| and |Δu²| of some inputs."""
        return np.array([x for name in names for x in self.moved.get(name, (0.0, 0.0))])


def list_input_steps(runs: Iterable[Run]) -> list[InputStep]:
    """Of some runs, in their order."""
    return [InputStep(i, t, moved) for i, run in enumerate(runs) for t, moved in _steps_of(run).items()]


def _steps_of(run: Run) -> dict[float, dict[str, tuple[float, float]]]:
    """Of inputs, and of relays whose modes are read; what is averaged between knots steps where the run has a jump."""
    steps: dict[float, dict[str, tuple[float, float]]] = {}
    jumps, knots = {*run.knots.jumps.tolist()}, run.knots.t[:-1]
    for name, signal in run.schedule.signals.items():
        is_averaged = np.array_equal(signal.t, knots)
        for t, before, after in zip(*(x.tolist() for x in list_jumps(signal)), strict=True):
            if t in jumps or not is_averaged:
                steps.setdefault(t, {})[name] = (abs(after - before), abs(after**2 - before**2))
    return steps


def list_driving(moved: Sequence[InputStep], runs: Sequence[Steps | None]) -> list[tuple[float, ...]]:
    """When, in each run, inputs step that may make a channel jump: those that hardly step by half as much elsewhere, or
    at whose other steps it jumps as often as not or more often than chance has it. A relay that switches every few
    minutes is near every jump, and makes none."""
    watched = [(m, _jumps_at(of, m.t)) for m in moved if (of := runs[m.run]) is not None and of.covers(m.t, of.reach)]
    chance = _share_near_jumps([of for of in runs if of is not None])
    driving = [m for m in moved if (of := runs[m.run]) is None or _may_drive(m, of.reach, watched, chance)]
    return [tuple(m.t for m in driving if m.run == run) for run in range(len(runs))]


def _may_drive(own: InputStep, reach: float, watched: Sequence[tuple[InputStep, bool]], chance: float) -> bool:
    apart = [pair for pair in watched if pair[0].run != own.run or abs(pair[0].t - own.t) >= 2 * reach]
    for name, (by, _) in own.moved.items():
        jumped = [jumps for m, jumps in apart if m.moved.get(name, (0.0, 0.0))[0] >= by / 2]
        n, k = len(jumped), sum(jumped)
        if n < MANY or 2 * k >= n or binom.sf(k - 1, n, chance) < 1 - SETTINGS.quantile:
            return True
    return False


def _jumps_at(steps: Steps, t: float) -> bool:
    return any(abs(at - t) < steps.reach for at in steps.clear)


def _share_near_jumps(runs: Sequence[Steps]) -> float:
    """Of the time."""
    near = sum(2 * of.reach * len(of.clear) for of in runs)
    return min(1.0, near / max(sum(of.end for of in runs), 1e-300))


def exceeds_inputs(own: InputStep, jump: float, others: Sequence[InputStep], jumps: Sequence[float]) -> bool:
    """Whether a channel jumps at a step by more than inputs make it, by its jumps at others, the largest of all of them
    by chance; no where an input does not step often by at least half as much elsewhere."""
    if not all(_steps_often(name, by, others) for name, (by, _) in own.moved.items()):
        return False
    names = [*dict.fromkeys(name for step in (own, *others) for name in step.moved)]
    moved = np.array([step.by(names) for step in others])
    scale = np.maximum(moved.max(axis=0), 1e-300)
    slopes, left = nnls(moved / scale, np.array(jumps))
    free = len(others) - int(np.count_nonzero(slopes))
    if free < MANY:
        return False
    away = (jump - float(own.by(names) / scale @ slopes)) / max(left / np.sqrt(free), 1e-300)
    return bool(student.sf(away, free) * (len(others) + 1) < 1 - SETTINGS.quantile)


def _steps_often(name: str, by: float, others: Sequence[InputStep]) -> bool:
    return sum(step.moved.get(name, (0.0, 0.0))[0] >= by / 2 for step in others) >= MANY
