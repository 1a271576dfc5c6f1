"""What a search comes to, also where it is ended before it has come to its end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from network.analysis.diagnosis.hypotheses.few_runs import finish_in_passing
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.time_budget import BudgetReached, TimeBudget
from network.platform.parallel import check_each
from network.platform.refusal import Failed


def last_of(states: Iterator[Search], budget: TimeBudget) -> Search:
    """What a search comes to, or came to until it ran out of time, was stopped, or came upon runs that break down.
    Raises what ended it where that was before anything is known."""
    last: Search | None = None
    try:
        with check_each(budget.check):
            for state_now in states:
                last = state_now
    except (BudgetReached, KeyboardInterrupt, Failed, np.linalg.LinAlgError) as end:
        if last is None:
            raise
        return _end_early(last, end)
    assert last is not None
    return last


def _end_early(last: Search, end: BaseException) -> Search:
    """What a search had come to; what was not tested to the end was fitted in passing, and is now in a few steps, but
    the null stands where recordings that did not choose it neither show nor choose it."""
    last, chosen = replace(last, ended=_how_ended(end)), last.selection
    if last.ended != "budget" or chosen.is_checked:
        return last
    if chosen.is_doubted:
        return replace(last, selection=replace(chosen, best=last.null, gains=()))
    try:
        return replace(last, selection=replace(chosen, best=finish_in_passing(chosen.best)))
    except KeyboardInterrupt:
        return replace(last, ended="stopped")


def _how_ended(end: BaseException) -> str:
    if isinstance(end, BudgetReached):
        return "budget"
    return "stopped" if isinstance(end, KeyboardInterrupt) else "broken"
