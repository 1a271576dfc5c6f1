"""Steps of inputs, which of them may make a channel jump, and whether it jumps with one by more than they make it jump.

What an input u makes a channel jump by goes with |Δu| or, as a shaft that grows with its speed, with |Δu²|: by least
squares with no coefficient below zero, from what the channel does at other steps of all inputs. What is left there says
how far off that may be (Student's t). Source: Lawson & Hanson, Solving Least Squares Problems (1974), ch. 23, as in
scipy.optimize.nnls; unverified.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.stats import binom
from scipy.stats import t as student

from network.analysis.diagnosis.intermittent.change_points import Steps, find_steps
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Array, Mask
from network.engine.response.knots import list_jumps
from network.engine.response.measured_run import Run
from network.recordings.inputs import Signal

MANY = 4
"""Steps elsewhere that say something of one: what is left at fewer says nothing of how far off it may be."""
ASIDE = (-6, -5, -4, -3, 3, 4, 5, 6)
"""By how many reaches jumps are moved to tell how often chance has one near a step: at work both are more often."""


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
    """Of inputs, and of relays whose modes are read; what is averaged between knots steps where the run has a jump, and
    what runs straight between samples, like a measured power, where it stands out from how else it changes."""
    steps: dict[float, dict[str, tuple[float, float]]] = {}
    jumps, knots = {*run.knots.jumps.tolist()}, run.knots.t[:-1]
    for name, signal in run.schedule.signals.items():
        is_averaged = np.array_equal(signal.t, knots)
        held = [*zip(*(x.tolist() for x in list_jumps(signal)), strict=True)]
        for t, before, after in held or _list_straight_steps(signal):
            if t in jumps or not (held and is_averaged):
                steps.setdefault(t, {})[name] = (abs(after - before), abs(after**2 - before**2))
    return steps


def _list_straight_steps(signal: Signal) -> Iterator[tuple[float, float, float]]:
    """When a signal without jumps steps [s], by as much as it varies at all, from where and to where."""
    seen = find_steps(signal.t, signal.start, np.ones(len(signal.t))) if len(signal.t) > 1 else None
    if seen is None:
        return
    for at in seen.clear:
        before, after = np.interp([at - seen.reach, at + seen.reach], signal.t, signal.start).tolist()
        if abs(after - before) > np.std(signal.start):
            yield at, before, after


def list_driven(moved: Sequence[InputStep], runs: Sequence[Steps | None]) -> list[tuple[float, ...]]:
    """Of each run the clear jumps of a channel that an input may make which steps there: one that hardly steps by half
    as much elsewhere, or at whose other steps it jumps as often as not, or more often than some time before and after
    them. A relay that switches every few minutes is near every jump, and makes none."""
    return [
        tuple(at for at in (of.clear if of else ()) if _may_be_driven(moved, runs, i, at)) for i, of in enumerate(runs)
    ]


def _may_be_driven(moved: Sequence[InputStep], runs: Sequence[Steps | None], run: int, at: float) -> bool:
    own = runs[run]
    assert own is not None
    here = [m for m in moved if m.run == run and abs(m.t - at) < own.reach]
    largest = {name: max(m.by([name])[0] for m in here) for m in here for name in m.moved}
    for name, by in largest.items():
        steps, jumps = list[Array](), list[Array]()
        for i, of in enumerate(runs):
            if of is not None:
                alike = np.array([m.t for m in moved if m.run == i and m.by([name])[0] >= by / 2])
                apart, clear = alike[_list_near(alike, of.t, of.reach)], np.array(of.clear)
                steps.append(apart[np.abs(apart - at) >= 2 * of.reach] if i == run else apart)
                jumps.append(clear[clear != at] if i == run else clear)
        if _may_drive(steps, jumps, own.reach):
            return True
    return False


def _may_drive(steps: Sequence[Array], jumps: Sequence[Array], reach: float) -> bool:
    """steps: other ones of an input, of every run; jumps: of the channel."""
    count = sum(map(len, steps))
    jumped = sum(int(_list_near(t, at, reach).sum()) for t, at in zip(steps, jumps, strict=True))
    if count < MANY or 2 * jumped >= count:
        return True
    near = [[_list_near(at + by * reach, t, reach) for t, at in zip(steps, jumps, strict=True)] for by in (0, *ASIDE)]
    own, *aside = (np.concatenate(each) for each in near)
    return bool(binom.sf(own.sum() - 1, len(own), np.mean(aside)) < 1 - SETTINGS.quantile) if len(own) else False


def _list_near(times: Array, others: Array, reach: float) -> Mask:
    """Which of some instants lie within reach of others."""
    edges = np.concatenate([[-np.inf], np.sort(others), [np.inf]])
    after = np.searchsorted(edges, times)
    return np.asarray(np.minimum(times - edges[after - 1], edges[after] - times) < reach)


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
