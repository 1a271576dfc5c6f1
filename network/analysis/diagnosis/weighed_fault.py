"""A search on readings set right beside the one without that: where the first leaves much, which of them is told.

What is wrong with a reading and what is missing from the machine explain the same to begin with: each is followed a
step, and the fault has to explain more than what comes without it.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from network.analysis.calibration.misfit import lasting_misfit
from network.analysis.diagnosis.hypotheses.case_noise import use_file_noise
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import reweight
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.unseen_runs import unseen_misfit


def weigh_fault(now: Search, states: Iterator[Search], others: Iterator[Search], jobs: int) -> Iterator[Search]:
    """On from the null of a machine whose readings were set right (now), and from the one without that: from the other
    alone where its lumps explain more, or its first step hardly leaves anything while that with the fault leaves much,
    and else to what it comes to where that explains more."""
    other = next(others)
    if is_told_better(lay_alike(now, other), now.best, jobs):
        yield from chain([other], others)
        return
    for now in states:
        yield now
        if now.best.found and now.best.chi > SETTINGS.adequate and not other.best.found:
            other = _take_first_step(other, others)
            if other.best.chi <= SETTINGS.adequate and is_told_better(lay_alike(now, other), now.best, jobs):
                yield from chain([other], others)
                return
    *_, other = chain([other], others)
    if is_told_better(lay_alike(now, other), now.best, jobs):
        yield other


def _take_first_step(now: Search, states: Iterator[Search]) -> Search:
    """What a search comes to with its first finding; to its end where it has none."""
    for now in states:
        if now.best.found:
            break
    return now


def lay_alike(now: Search, other: Search) -> Hypothesis:
    """What a search without the fault came to, on the readings that the one with it has."""
    assert now.fault is not None
    best = other.best
    return reweight(now.fault.lay_alike(best.case), best)


def is_told_better(other: Hypothesis, now: Hypothesis, jobs: int) -> bool:
    """Whether what a search came to explains more than another, in units of how long lasts what both leave, and, where
    that is much, tells runs that it has not seen better, too: what bends itself to the runs explains these alone. What
    was found beside a number that stands far from the file is not, where the other leaves all of them near."""
    if other.found and other.is_bent and not now.is_bent:
        return False
    ends = [reweight(use_file_noise(h.case), h) for h in (other, now)]
    firm = min(lasting_misfit(h.linearised) for h in ends)
    if (ends[0].evidence - ends[1].evidence) / firm**2 <= SETTINGS.alike:
        return False
    return ends[0].chi <= SETTINGS.adequate or unseen_misfit(ends[0], jobs) < unseen_misfit(ends[1], jobs)
