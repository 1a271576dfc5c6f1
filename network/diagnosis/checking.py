"""Backward: the first finding is judged again beside the others, each is taken out once, and runs are left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from network.diagnosis.candidates import Candidate
from network.diagnosis.case import Case, Hypothesis, rejudged, relaid
from network.diagnosis.confirm import left_out
from network.diagnosis.slimming import slim
from network.diagnosis.standing_in import carried, corrected, stand_in
from network.diagnosis.together import spread

HOLDS = 1.02
"""Misfit on left-out runs, relative to before, that a finding may leave."""
RERANKED, REACH = 3, 3.0
"""Rivals of the first finding that are tried in its stead, and how many times what the later findings gained they may
be behind it."""
STEPS, NEAR = 8, 300.0
"""Of a fit with other findings, and the evidence by which it may stay behind to be told what its lumps lack."""


def checked(
    null: Hypothesis, case: Case, current: Hypothesis, befores: Sequence[Hypothesis],
    steps: Sequence[Sequence[Hypothesis]], threshold: float, jobs: int,
) -> tuple[Hypothesis, tuple[float, ...]]:  # fmt: skip
    """What was found without what is superfluous, and the evidence that each finding adds; the null where it does not
    tell runs left out. befores, steps: what stood before each step, and its rivals."""
    before = rejudged(case, null)
    if not current.found:
        return before, ()
    coarse = stand_in(current)
    later = sum(ranked[0].evidence - h.evidence for h, ranked in zip(befores[1:], steps[1:], strict=True))
    close = [h for h in steps[0][1 : RERANKED + 1] if steps[0][0].evidence - h.evidence < REACH * later]
    coarse = _reranked(coarse, current, close, jobs)
    coarse, gains = _needed(coarse, current, threshold, jobs)
    if [c.key for c in coarse.found] != [c.key for c in current.found]:
        current = _like(coarse, current, case)
    return (current, gains) if _predicts(stand_in(before), coarse, jobs) else (before, ())


def _like(coarse: Hypothesis, current: Hypothesis, case: Case) -> Hypothesis:
    """Other findings on the lumps of what is there."""
    is_one = coarse.root.to_plain() == current.root.to_plain()
    return rejudged(case, coarse) if is_one else carried(case, coarse, current.root) or current


def _refitted(
    coarse: Hypothesis, current: Hypothesis, other: tuple[Sequence[Candidate], Mapping[str, float]]
) -> Hypothesis | None:  # fmt: skip
    """Other findings from some numbers in the stead of those of a hypothesis, as if on the lumps of what is there."""
    found = relaid(coarse.case, coarse.root, *other, steps=STEPS)
    if found is None or not coarse.case.lacking or found.switches or found.evidence < coarse.evidence - NEAR:
        return found and slim(found)
    found = corrected(found, current.root)
    return found and slim(found)


def _reranked(best: Hypothesis, current: Hypothesis, rivals: Sequence[Hypothesis], jobs: int) -> Hypothesis:
    """The first finding against its rivals, now that the others are in."""
    others = [((h.found[-1], *best.found[1:]), h.values | best.values) for h in rivals]
    told = spread(partial(_refitted, best, current), others, jobs, None)
    better = max((h for h in told if h is not None), key=lambda h: h.evidence, default=best)
    if better.evidence <= best.evidence:
        return best
    return relaid(better.case, better.root, better.found, better.values) or best


def _needed(
    coarse: Hypothesis, current: Hypothesis, threshold: float, jobs: int
) -> tuple[Hypothesis, tuple[float, ...]]:  # fmt: skip
    """Without the findings that the others have made superfluous, and the evidence that each of the rest adds."""
    gains: list[float] = []
    while coarse.found:
        rests = [[c for c in coarse.found if c is not out] for out in coarse.found]
        less = spread(partial(_refitted, coarse, current), [(rest, coarse.values) for rest in rests], jobs, None)
        gains = [float("inf") if h is None else coarse.evidence - h.evidence for h in less]
        k = int(np.argmin(gains))
        other = less[k]
        if other is None or len(gains) < 2 or gains[k] >= threshold:
            break
        coarse = relaid(other.case, other.root, other.found, other.values) or other
    return coarse, tuple(gains)


def _predicts(before: Hypothesis, after: Hypothesis, jobs: int) -> bool:
    """Whether runs left out of the fit are told at least as well."""
    was, now = (left_out(h, jobs) for h in (before, after))
    return not np.isfinite(was) or now < HOLDS * was
