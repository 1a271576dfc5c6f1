"""A fault of readings of the size that it has beside what was found, and what of that holds then.

It was found beside numbers that were bent to what was missing: what its size is off by remains in readings that were
set right by it, and looks like one thing more.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, fit_hypothesis
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.backward_elimination import check_selection
from network.analysis.diagnosis.time_budget import BudgetReached
from network.platform.refusal import Failed

ROUNDS = 3
"""Times at most: without what looked like one thing more the size is another one again."""


def resize_fault(now: Search, recorded: Case, jobs: int) -> Iterator[Search]:
    """What a search came to, tested again on readings set right by the fault's size beside it, until that is no other.
    recorded: the case as it was recorded."""
    for _ in range(ROUNDS):
        again = _resize_once(now, recorded, jobs)
        if again is None:
            return
        yield (now := again)


def _resize_once(now: Search, recorded: Case, jobs: int) -> Search | None:
    """None where the size is no other, a run breaks down, or much is left: then numbers are bent as before. Where the
    time is up, that was no part of the search."""
    if now.fault is None or now.best.chi > SETTINGS.adequate:
        return None
    try:
        fault = now.fault.resize(now.best, recorded.recordings)
        if fault is None:
            return None
        case = replace(fault.set_right(recorded), noise=now.best.case.noise, sigma=now.best.case.sigma)
        written, null, best = (_refit(case, h) for h in (now.written, now.null, now.best))
        if best is None or written is None or null is None or best.chi > now.best.chi:
            return None
        selection = check_selection(null, replace(now.selection, best=best), jobs)
    except (BudgetReached, Failed, np.linalg.LinAlgError):
        return None
    return replace(now, case=case, fault=fault, written=written, null=null, selection=selection)


def _refit(case: Case, h: Hypothesis) -> Hypothesis | None:
    """On other readings, from its numbers."""
    return fit_findings(case, h.root, h.found, h.values) if h.found else fit_hypothesis(case, h.machine, start=h.values)
