"""The search for relays whose instants are read, off what they watch or off all channels: followed, then in step."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.case_noise import use_file_noise
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import reweight
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.switching.relay_fits import (
    SHOWN_LADDER,
    WELL,
    Ladder,
    RelayStart,
    fit_over_more,
    keep_of_each,
    leave_of_null,
    linearise_firmly,
)
from network.analysis.diagnosis.switching.relay_levels import read_levels
from network.analysis.diagnosis.switching.relay_search import MOST, search_near
from network.analysis.diagnosis.switching.shown_relays import SLACK, ShownRelay, follow_shown, read_relays
from network.analysis.diagnosis.switching.traced_relays import trace_again, trace_relays
from network.engine.assembly import build
from network.engine.response.switchings import check_followed
from network.platform.refusal import Refused


def search_shown_relays(case: Case, current: Hypothesis, switched: Sequence[Candidate], jobs: int) -> list[Hypothesis]:
    """The relays whose switching the readings show, fitted so that they keep step, of each place the best; told under
    the noise of the case."""
    shown = read_relays(case, [c for c in switched if _may_keep_step(c)])
    if not shown:
        return []
    null = reweight(use_file_noise(case), current)
    starts = follow_shown(null.case, null, shown, jobs)[:MOST]
    return _tell_best(case, null, _fit_in_step(null, starts, _onset(case, shown, starts), jobs))


def search_traced_relays(
    case: Case, current: Hypothesis, switched: Sequence[Candidate], seed: int, jobs: int
) -> list[Hypothesis]:  # fmt: skip
    """The same of those whose switching the mismatch shows: from what is read off it, where that does not keep step
    from what is read off it beside the numbers that were found so, and then from draws about that."""
    able = [c for c in switched if _may_keep_step(c)]
    if not able:
        return []
    null = reweight(use_file_noise(case), current)
    shown = trace_relays(null, able, jobs)
    starts = _keep_telling(null, follow_shown(null.case, null, shown, jobs, read_levels))
    onset = _onset(case, shown, starts)
    kept = _fit_traced(null, starts, onset, jobs)
    if again := trace_again(null, _list_lost(starts, kept), jobs):
        found = _keep_telling(null, follow_shown(null.case, null, again, jobs, read_levels))
        kept += _fit_traced(null, found, _onset(case, again, found), jobs)
        starts = _take_again(starts, found)
    lost = _list_lost(starts, kept)
    return _tell_best(case, null, [*kept, *_keep_in_step(null, lost, search_near(null, lost, onset, seed, jobs))])


def _fit_traced(null: Hypothesis, starts: Sequence[RelayStart], onset: float, jobs: int) -> list[Hypothesis]:
    """Those that keep step: led over ever more of the runs, or else over the whole of them at once."""
    kept = list[Hypothesis]()
    for ladder in (SHOWN_LADDER, SHOWN_LADDER[-1:]):
        kept += _keep_in_step(null, starts, _fit_in_step(null, _list_lost(starts, kept), onset, jobs, ladder))
    return kept


def _list_lost(starts: Sequence[RelayStart], kept: Sequence[Hypothesis]) -> list[RelayStart]:
    """Those that leave less, by more than a little, where they follow what was traced than any that keeps step."""
    least = min((h.chi for h in kept), default=np.inf)
    return [start for start in starts if start.followed * (1 + SLACK) < least]


def _take_again(starts: Sequence[RelayStart], again: Sequence[RelayStart]) -> list[RelayStart]:
    """Each as it was followed again, unless that leaves more by far."""
    told = {start.candidate.key: start for start in again}
    pairs = ((start, told.get(start.candidate.key, start)) for start in starts)
    return [new if new.followed < start.followed * (1 + SLACK) else start for start, new in pairs]


def _keep_telling(null: Hypothesis, starts: Sequence[RelayStart]) -> list[RelayStart]:
    """Those whose heat explains much where it follows what was traced, and half of what the best does at least."""
    explained = [null.chi**2 - start.followed**2 for start in starts]
    least = max((1 - WELL**2) * null.chi**2, SETTINGS.half * max(explained, default=0.0))
    return [start for start, e in zip(starts, explained, strict=True) if e > least]


def _keep_in_step(null: Hypothesis, starts: Sequence[RelayStart], fits: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Relays that explain half of what their heat does where it follows the instants that were traced. What does not is
    heat that goes on and off by something else."""
    followed = {start.candidate.key: start.followed for start in starts}
    least = {key: SETTINGS.half * (null.chi**2 - chi**2) for key, chi in followed.items()}
    return [h for h in fits if null.chi**2 - h.chi**2 >= least[h.found[-1].key]]


def _onset(case: Case, shown: Sequence[ShownRelay], starts: Sequence[RelayStart]) -> float:
    """Share of the runs until which none of those that go on has switched."""
    keys = {start.candidate.key for start in starts}
    return min((s.onset(case.recordings) for s in shown if s.candidate.key in keys), default=0.0)


def _may_keep_step(c: Candidate) -> bool:
    """Whether a fit can simulate it."""
    try:
        check_followed(build(c.machine))
    except Refused:
        return False
    return True


def _fit_in_step(
    null: Hypothesis, starts: Sequence[RelayStart], onset: float, jobs: int, ladder: Ladder = SHOWN_LADDER
) -> list[Hypothesis]:
    if not starts:
        return []
    leave = partial(leave_of_null, [linearise_firmly(null, null.fit.theta)])
    return fit_over_more(null.case, null, starts, ladder, leave, onset, jobs)


def _tell_best(case: Case, null: Hypothesis, fits: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Of each place the best, under the noise of the case."""
    best = keep_of_each(sorted(fits, key=lambda h: h.chi), 1)
    return [compact(reweight(case, h)) for h in best if h.chi < WELL * null.chi]
