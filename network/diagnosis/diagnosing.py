"""diagnose: from a machine and its recordings to what is missing, with what speaks for it and against its rivals.

Structure first: lumps are refined where that mends more than it costs. Then step by step: locate, screen, refit, keep
what gains more than chance does and predicts runs left out of its fit; the first finding is judged again beside the
second, and each is taken out once to see whether it is still needed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from network.calibration.slack import installed_power
from network.diagnosis.candidates import candidates
from network.diagnosis.case import Case, Hypothesis, rejudged, renoised, suppose, under_file_noise
from network.diagnosis.chance import LEAST, threshold_of
from network.diagnosis.confirm import ADEQUATE, left_out, rebuilt, rivals, without
from network.diagnosis.intake import taken_in
from network.diagnosis.judging import diagnosis_of
from network.diagnosis.locate import locate
from network.diagnosis.refine import FAR, refined, settled
from network.diagnosis.screen import screen
from network.diagnosis.verdict import Diagnosis, UnknownHeat
from network.inputs import Start
from network.machine import Machine
from network.recording import Recording

MOST_FINDINGS = 3
FULL = 1.06
"""Misfit χ below which nothing more is looked for."""
WORTH = 0.015
"""Share of the misfit χ that a finding must take away."""
HOLDS = 1.02
"""Misfit on left-out runs, relative to before, that a finding may leave."""


@dataclass(frozen=True, eq=False)
class Search:
    """What a diagnosis tried on its way: the machine as written and calibrated, the best, all rivals of each step,
    where it differed, and the gain that chance reaches."""

    case: Case
    written: Hypothesis
    plain: Hypothesis
    null: Hypothesis
    best: Hypothesis
    steps: tuple[tuple[Hypothesis, ...], ...]
    gains: tuple[float, ...]
    located: tuple[UnknownHeat, ...]
    threshold: float


def diagnose(
    machine: Machine, recordings: Recording | Iterable[Recording], holdout: Iterable[Recording] = (), *,
    start: Start | None = None, seed: int = 0, jobs: int = 1, progress: Callable[[float], None] | None = None,
) -> Diagnosis:  # fmt: skip
    """Finds out which physics a machine lacks. holdout: recordings never used in any fit; jobs: processes; progress:
    told the share that is done.

    The same seed gives the same diagnosis. Raises Refused for recordings that cannot tell anything.
    """
    began, tell = time.perf_counter(), progress or (lambda share: None)
    runs = (recordings,) if isinstance(recordings, Recording) else tuple(recordings)
    let_in = taken_in(machine, runs, tuple(holdout), start)
    found = _searched(Case(machine, let_in.recordings, start), seed, jobs, tell)
    return diagnosis_of(found, let_in.holdout, let_in.warnings, seed, time.perf_counter() - began)


def _searched(case: Case, seed: int, jobs: int, tell: Callable[[float], None]) -> Search:
    written = suppose(case, case.machine)
    tell(0.05)
    levels = refined(case, written)
    tell(0.15)
    best = max(levels, key=lambda h: h.evidence)
    case = renoised(case, best)
    tracks = [rejudged(case, h) for h in _tracks(levels, best)]
    as_written = rejudged(case, written)
    if best is not written and tracks[0].chi < FAR:
        tracks[0] = settled(case, tracks[0])
    null = max(tracks, key=lambda h: h.evidence)
    located = locate(null.fit, null.machine)
    found: list[Found] = []
    for track in sorted(tracks, key=lambda h: -h.evidence):
        found.append(_followed(track, located, seed, jobs, tell))
        if found[-1][0].chi < ADEQUATE:
            break
    winner, steps, gains, threshold = max(found, key=lambda f: rejudged(case, f[0]).evidence)
    plain = suppose(under_file_noise(case), case.machine, offsets=False)
    return Search(case, as_written, plain, null, winner, steps, gains, located, threshold)


def _tracks(levels: Sequence[Hypothesis], best: Hypothesis) -> list[Hypothesis]:
    """The best refinement, and the machine as written where that is another."""
    return [best] if best is levels[0] or best.chi < FULL else [best, levels[0]]


Found = tuple[Hypothesis, tuple[tuple[Hypothesis, ...], ...], tuple[float, ...], float]


def _followed(
    null: Hypothesis, located: Sequence[UnknownHeat], seed: int, jobs: int, tell: Callable[[float], None]
) -> Found:
    """Forward, step by step, from one null; then the first finding beside the others, then each taken out."""
    case, current = null.case, null
    steps: list[tuple[Hypothesis, ...]] = []
    threshold = LEAST
    while current.chi > FULL and len(current.found) < MOST_FINDINGS:
        proposed = candidates(current.machine, case.drivers)
        scores = screen(current.fit, proposed, current.values)
        threshold = threshold if steps else threshold_of(scores, seed)
        where = located if not steps else locate(current.fit, current.machine)
        power = installed_power(current.predictions)
        ranked = rivals(case, current, proposed, scores, where, power, seed, jobs)
        if not ranked or not _is_gain(current, ranked[0], threshold):
            break
        case = renoised(case, ranked[0])
        ranked = sorted((rejudged(case, h) for h in ranked), key=lambda h: -h.evidence)
        if not _is_gain(rejudged(case, current), ranked[0], threshold):
            break
        steps.append(tuple(ranked))
        current = settled(case, ranked[0])
        tell(0.15 + 0.25 * len(steps))
    if len(steps) > 1:
        current = _reranked(case, current, steps)
    current = _needed(case, current, threshold)
    before = rejudged(case, null)
    if current.found and not _predicts(case, before, current):
        current, steps = before, []
    gains = _gains(case, current)
    return current, tuple(steps), gains, threshold


def _is_gain(before: Hypothesis, after: Hypothesis, threshold: float) -> bool:
    """More evidence than chance gives, and a misfit that is worth a name."""
    return after.evidence - before.evidence > threshold and after.chi < before.chi * (1 - WORTH)


def _reranked(case: Case, current: Hypothesis, steps: Sequence[Sequence[Hypothesis]]) -> Hypothesis:
    """The first finding against its rivals, now that the others are in."""
    best = current
    for rival in steps[0][1:4]:
        other = rebuilt(case, current, [rival.found[-1], *current.found[1:]])
        if other is not None and other.evidence > best.evidence:
            best = other
    return best


def _needed(case: Case, current: Hypothesis, threshold: float) -> Hypothesis:
    """Without the findings that the others have made superfluous."""
    i = 0
    while len(current.found) > 1 and i < len(current.found):
        less = without(case, current, i)
        if less is not None and current.evidence - less.evidence < threshold:
            current, i = less, 0
        else:
            i += 1
    return current


def _predicts(case: Case, before: Hypothesis, after: Hypothesis) -> bool:
    """Whether runs left out of the fit are told at least as well."""
    was, now = left_out(case, before), left_out(case, after)
    return not np.isfinite(was) or now < HOLDS * was


def _gains(case: Case, current: Hypothesis) -> tuple[float, ...]:
    """What each finding adds to the evidence."""
    gains = []
    for i in range(len(current.found)):
        less = without(case, current, i)
        gains.append(current.evidence - less.evidence if less is not None else float("inf"))
    return tuple(gains)
