"""A hypothesis on ever finer lumps, while that helps: tried on coarse lumps that are told what they lack."""

from __future__ import annotations

from network.diagnosis.case import Case, Hypothesis, relaid
from network.diagnosis.refine import ENOUGH, FINEST, GAIN, ever_finer
from network.diagnosis.standing_in import carried, corrected, stand_in

LITTLE = 0.015
"""Share of the misfit χ that finer lumps must take away for still finer ones to be tried."""


def settled(case: Case, best: Hypothesis) -> Hypothesis:
    """The hypothesis on as many lumps as it takes."""
    if best.found and best.chi < ENOUGH:
        return best
    return _step_by_step(case, best) if best.switches else _at_a_distance(case, best)


def _at_a_distance(case: Case, best: Hypothesis) -> Hypothesis:
    """By what the finer lumps would read, and a few steps on them."""
    coarse = stand_in(best)
    again = None if coarse is best else carried(case, coarse, best.root)
    best = again if again is not None and again.evidence > best.evidence else best
    for root in ever_finer(best.root, FINEST):
        told = corrected(coarse, root)
        other = None if told is None else carried(case, told, root)
        if told is None or other is None or other.evidence < best.evidence + GAIN:
            break
        is_little = other.chi > (1 - LITTLE) * best.chi
        coarse, best = told, other
        if is_little or (best.found and best.chi < ENOUGH):
            break
    return best


def _step_by_step(case: Case, best: Hypothesis) -> Hypothesis:
    """By fits on the finer lumps, led back into step."""
    for finer_root in ever_finer(best.root, FINEST):
        finer_one = relaid(case, finer_root, best.found, best.values, False)
        if finer_one is None or finer_one.evidence < best.evidence + GAIN:
            break
        best = finer_one
        if best.chi < ENOUGH:
            break
    return best
