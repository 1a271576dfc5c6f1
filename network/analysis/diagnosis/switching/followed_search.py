"""The search for relays whose instants are read, off what they watch or off all channels: followed, then in step."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

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
    fit_over_more,
    keep_of_each,
    leave_of_null,
    linearise_firmly,
)
from network.analysis.diagnosis.switching.relay_search import MOST
from network.analysis.diagnosis.switching.shown_relays import LevelsOf, ShownRelay, follow_shown, read_relays
from network.analysis.diagnosis.switching.traced_relays import read_levels, trace_relays
from network.engine.assembly import build
from network.engine.response.switchings import check_followed
from network.platform.refusal import Refused


def search_shown_relays(case: Case, current: Hypothesis, switched: Sequence[Candidate], jobs: int) -> list[Hypothesis]:
    """The relays whose switching the readings show, fitted so that they keep step, of each place the best; told under
    the noise of the case."""
    shown = read_relays(case, [c for c in switched if _may_keep_step(c)])
    white = use_file_noise(case)
    return _fit_in_step(case, reweight(white, current), shown, jobs) if shown else []


def search_traced_relays(case: Case, current: Hypothesis, switched: Sequence[Candidate], jobs: int) -> list[Hypothesis]:
    """The same of those whose switching the mismatch shows."""
    able = [c for c in switched if _may_keep_step(c)]
    null = reweight(use_file_noise(case), current) if able else current
    shown = trace_relays(null, able, jobs) if able else []
    return _fit_in_step(case, null, shown, jobs, read_levels) if shown else []


def _may_keep_step(c: Candidate) -> bool:
    """Whether a fit can simulate it."""
    try:
        check_followed(build(c.machine))
    except Refused:
        return False
    return True


def _fit_in_step(
    case: Case, null: Hypothesis, shown: Sequence[ShownRelay], jobs: int, levels_of: LevelsOf | None = None
) -> list[Hypothesis]:
    starts = follow_shown(null.case, null, shown, jobs, levels_of)[:MOST]
    onset = min(s.onset(case.recordings) for s in shown)
    leave = partial(leave_of_null, [linearise_firmly(null, null.fit.theta)])
    ladders = (SHOWN_LADDER, SHOWN_LADDER[-1:]) if levels_of else (SHOWN_LADDER,)
    fits = [h for each in ladders if starts for h in fit_over_more(null.case, null, starts, each, leave, onset, jobs)]
    if levels_of:
        followed = {start.candidate.key: start.followed for start in starts}
        fits = [h for h in fits if _keeps_step(h, null, followed[h.found[-1].key])]
    best = keep_of_each(sorted(fits, key=lambda h: h.chi), 1)
    return [compact(reweight(case, h)) for h in best if h.chi < WELL * null.chi]


def _keeps_step(h: Hypothesis, null: Hypothesis, followed: float) -> bool:
    """Whether a relay explains half of what its heat does where that follows the instants that were traced; followed:
    misfit χ beside these. What does not is heat that goes on and off by something else."""
    return null.chi**2 - h.chi**2 >= SETTINGS.half * (null.chi**2 - followed**2)
