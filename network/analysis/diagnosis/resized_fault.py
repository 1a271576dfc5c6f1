"""A fault of readings of the size that it has beside what was found, and what of that holds then.

It was found beside numbers that were bent to what was missing: what its size is off by remains in readings that were
set right by it, and looks like one thing more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, fit_hypothesis
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.backward_elimination import check_selection
from network.analysis.diagnosis.time_budget import BudgetReached
from network.platform.refusal import Failed

ROUNDS = 3
"""Times at most that the size is found again about the better fit; the first takes nearly all of the way."""


def resize_fault(now: Search, recorded: Case, jobs: int) -> Iterator[Search]:
    """What a search came to, tested again on readings set right by the fault's size beside it, as long as that leaves
    less of it. Nothing where much is left: then numbers are bent as before. Where the time is up, or a run breaks down,
    that was no part of the search. recorded: the case as it was recorded."""
    if now.best.chi > SETTINGS.adequate:
        return
    again = _attempt(partial(_resize_and_test, now, recorded, jobs))
    if again is not None:
        yield again
        if len(again.best.found) < len(now.best.found):
            yield from resize_fault(again, recorded, jobs)


def resize_beside(now: Search, recorded: Case) -> Search | None:
    """What a search came to, of which much is left, on readings set right by the fault's size beside it; not tested.
    None where that leaves more than hardly anything."""
    if now.fault is None or not now.best.found or now.best.chi <= SETTINGS.adequate:
        return None
    again = _attempt(partial(_resize, now, recorded))
    return again if again is not None and again.best.chi <= SETTINGS.adequate else None


def _attempt(resize: Callable[[], Search | None]) -> Search | None:
    """None where the time is up, or a run breaks down."""
    try:
        return resize()
    except (BudgetReached, Failed, np.linalg.LinAlgError):
        return None


def _resize_and_test(now: Search, recorded: Case, jobs: int) -> Search | None:
    """With its findings tested beside each other and on runs that they were not fitted to."""
    again = _resize(now, recorded)
    return again and replace(again, selection=check_selection(again.null, again.selection, jobs))


def _resize(now: Search, recorded: Case) -> Search | None:
    """None where the size is no other."""
    assert now.fault is not None
    fault, best = now.fault, now.best
    for _ in range(ROUNDS):
        other = fault.resize(best)
        again = None if other is None else _refit(_set_right(other, recorded, best), best)
        if other is None or again is None or again.chi > best.chi:
            break
        fault, best = other, again
    if fault is now.fault:
        return None
    case = _set_right(fault, recorded, best)
    written, null = (_refit(case, h) or h for h in (now.written, now.null))
    return replace(now, case=case, fault=fault, written=written, null=null, selection=replace(now.selection, best=best))


def _set_right(fault: ReadingFault, recorded: Case, h: Hypothesis) -> Case:
    """The case without the fault, under the noise of a hypothesis."""
    return replace(fault.set_right(recorded), noise=h.case.noise, sigma=h.case.sigma)


def _refit(case: Case, h: Hypothesis) -> Hypothesis | None:
    """On other readings, from its numbers."""
    return fit_findings(case, h.root, h.found, h.values) if h.found else fit_hypothesis(case, h.machine, start=h.values)
