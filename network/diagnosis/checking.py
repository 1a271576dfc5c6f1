"""Backward: the first finding is judged again beside the others, each is taken out once, and runs are left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from network.diagnosis.candidates import Candidate
from network.diagnosis.case import Case, Hypothesis, rejudged, relaid
from network.diagnosis.confirm import left_out
from network.diagnosis.standing_in import carried, corrected, stand_in

HOLDS = 1.02
"""Misfit on left-out runs, relative to before, that a finding may leave."""
RERANKED = 3
"""Rivals of the first finding that are tried in its stead."""


def checked(
    null: Hypothesis, case: Case, current: Hypothesis, steps: Sequence[Sequence[Hypothesis]], threshold: float,
    jobs: int,
) -> tuple[Hypothesis, tuple[float, ...]]:  # fmt: skip
    """What was found without what is superfluous, and the evidence that each finding adds; the null where it does not
    tell runs left out."""
    before = rejudged(case, null)
    if not current.found:
        return before, ()
    coarse = stand_in(current)
    if len(steps) > 1:
        coarse = _reranked(coarse, current, steps[0])
    coarse, gains = _needed(coarse, current, threshold)
    if [c.key for c in coarse.found] != [c.key for c in current.found]:
        current = _like(coarse, current, case)
    return (current, gains) if _predicts(stand_in(before), coarse, jobs) else (before, ())


def _like(coarse: Hypothesis, current: Hypothesis, case: Case) -> Hypothesis:
    """Other findings on the lumps of what is there."""
    is_one = coarse.root.to_plain() == current.root.to_plain()
    return rejudged(case, coarse) if is_one else carried(case, coarse, current.root) or current


def _refitted(
    coarse: Hypothesis, current: Hypothesis, found: Sequence[Candidate], values: Mapping[str, float]
) -> Hypothesis | None:  # fmt: skip
    """Other findings in the stead of those of a hypothesis, as if on the lumps of what is there."""
    other = relaid(coarse.case, coarse.root, found, values)
    if other is None or not coarse.case.lacking or other.switches:
        return other
    return corrected(other, current.root)


def _reranked(best: Hypothesis, current: Hypothesis, first: Sequence[Hypothesis]) -> Hypothesis:
    """The first finding against its rivals, now that the others are in."""
    coarse = best
    for rival in first[1 : RERANKED + 1]:
        other = _refitted(coarse, current, [rival.found[-1], *coarse.found[1:]], rival.values | coarse.values)
        if other is not None and other.evidence > best.evidence:
            best = other
    return best


def _needed(
    coarse: Hypothesis, current: Hypothesis, threshold: float
) -> tuple[Hypothesis, tuple[float, ...]]:  # fmt: skip
    """Without the findings that the others have made superfluous, and the evidence that each of the rest adds."""
    gains: list[float] = []
    while len(gains) < len(coarse.found):
        less = _refitted(coarse, current, [c for k, c in enumerate(coarse.found) if k != len(gains)], coarse.values)
        gain = float("inf") if less is None else coarse.evidence - less.evidence
        if less is not None and len(coarse.found) > 1 and gain < threshold:
            coarse, gains = less, []
        else:
            gains.append(gain)
    return coarse, tuple(gains)


def _predicts(before: Hypothesis, after: Hypothesis, jobs: int) -> bool:
    """Whether runs left out of the fit are told at least as well."""
    was, now = (left_out(h, jobs) for h in (before, after))
    return not np.isfinite(was) or now < HOLDS * was
