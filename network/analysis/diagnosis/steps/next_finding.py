"""One step: what explains most beside a hypothesis, of all that was screened beside it."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import replace
from functools import partial

from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.falling_short import explains_half, explains_most
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.latent_rest import rank_beside_rest
from network.analysis.diagnosis.lumps.lump_convergence import refine_until_converged
from network.analysis.diagnosis.screening.screen import Score
from network.analysis.diagnosis.screening.screening import Screening
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.finer_lead import find_lead
from network.analysis.diagnosis.steps.other_kinds import exchange_kind, put_in_place
from network.analysis.diagnosis.steps.placement import near, place_ranked
from network.analysis.diagnosis.steps.ranking import best_first, by_weight, distinct, leave_out
from network.analysis.diagnosis.steps.refit import start_trials
from network.analysis.diagnosis.steps.rival_acceptance import accept_best, list_contenders, take_first
from network.analysis.diagnosis.steps.trial_fits import LATE, TrialFits
from network.analysis.diagnosis.switching.followed_search import search_shown_relays, search_traced_relays
from network.analysis.diagnosis.switching.relay_search import rank_likely_places, search_relays

HOPE = 0.5
"""Linear score of a further candidate over what a name is worth, below which it is not fitted, nor looked at along
bars."""
Told = tuple[Hypothesis | None, list[Hypothesis]]
"""What is kept so far beside a hypothesis, and its rivals."""


def select_next(
    current: Hypothesis, seen: Screening, threshold: float, seed: int, jobs: int, tell: Callable[[float], None],
    may_switch: bool = True,
) -> Iterator[Told]:  # fmt: skip
    """What is kept beside a hypothesis, and its rivals, ever better founded: relays, if any may show, are looked for
    before much else is tried, where what is likely explains little, and last, where much is left, or else beside what
    is kept."""
    sway = partial(_search_switching, seen, seed, jobs)
    trials, passing = yield from _begin_trials(current, seen, threshold, jobs, tell)
    smooth = trials.rank(jobs)
    if is_told_so_far(current):
        first = take_first(current, seen.before, smooth, threshold)
        if passing is None or _is_better(first, passing):
            yield first, smooth
    early = sway() if may_switch and trials.is_poor(smooth) else None
    if not seen.before.found:
        is_told = early is None or bool(early and _leaves_little(seen.before, trials, early[0]))
        smooth = _fit_wider(trials, smooth, is_told, jobs)
    ranked = best_first(*(early or ()), *place_ranked(seen.before, smooth, jobs))
    if is_told_so_far(current):
        yield take_first(current, seen.before, ranked, threshold), ranked
    foremost, ranked = ranked[:1], rank_beside_rest(ranked, jobs)
    lead = find_lead(current, trials, ranked, jobs)
    tried = list_contenders(current, seen.before, ranked, lead, jobs)
    if is_told_so_far(current) and _is_another(tried, foremost):
        yield take_first(current, seen.before, tried, threshold), ranked
    best, weighed = accept_best(current, seen.before, ranked, tried, threshold, jobs)
    kept = best and exchange_kind(current, best, seen.proposed, jobs)
    yield kept, put_in_place(kept, best, weighed)
    is_due = (kept or current).chi > SETTINGS.adequate and not _is_next(current, kept)
    switched = sway(kept) if may_switch and early is None and is_due else []
    if not switched:
        return
    ranked = rank_beside_rest(best_first(*switched, *ranked), jobs)
    again = list_contenders(current, seen.before, ranked, lead, jobs)
    other = None
    if _keys_of(again) != _keys_of(tried):
        other, weighed = accept_best(current, seen.before, ranked, again, threshold, jobs)
    weighed = by_weight([*weighed, *leave_out(weighed, ranked)])
    yield (other, weighed) if _is_better(other, kept) else (kept, put_in_place(kept, best, weighed))


def _begin_trials(
    current: Hypothesis, seen: Screening, threshold: float, jobs: int, tell: Callable[[float], None]
) -> Generator[Told, None, tuple[TrialFits, Hypothesis | None]]:
    """What is likely, each fitted a few steps, and what was told of it: where it is late, the best as soon as it is,
    where it explains most, and of all where it explains half."""
    is_late = partial(_is_late, current)
    begun, passing, first = None, None, None
    for trials in start_trials(seen.before, seen.proposed, _worth_fitting(seen), jobs, tell, _is_near(seen), is_late):
        if is_late() and trials.foremost not in (None, begun):
            begun = trials.foremost
            fitted = trials.fit_in_passing(begun)
            first = take_first(current, seen.before, fitted, threshold)
            if first is not None and explains_most(current, first) and _is_better(first, passing):
                yield (passing := first), fitted
    if passing is None and first is not None and explains_half(current, first):
        yield (passing := first), fitted
    return trials, passing


def _is_late(current: Hypothesis) -> bool:
    """Whether a step that is told while it is made may not come to its end."""
    return is_told_so_far(current) and current.case.budget.is_past(LATE * SETTINGS.searched)


def _leaves_little(before: Hypothesis, trials: TrialFits, h: Hypothesis) -> bool:
    """Whether so little is left that nothing has to be looked for in its stead."""
    return h.chi <= trials.little or explains_most(before, h)


def _is_another(tried: Sequence[Hypothesis], told: Sequence[Hypothesis]) -> bool:
    """Whether the first that may be kept is none that was told first."""
    return bool(tried) and _keys_of(tried[:1]) != _keys_of(told[:1])


def _keys_of(rivals: Sequence[Hypothesis]) -> list[tuple[str, ...]]:
    return [c.key for h in rivals for c in h.found[-1:]]


def _is_better(new: Hypothesis | None, told: Hypothesis | None) -> bool:
    """Whether there is something new, and more than what was told."""
    return new is not None and (told is None or new.evidence > told.evidence)


def _is_next(current: Hypothesis, kept: Hypothesis | None) -> bool:
    """Whether what was kept explains so much that nothing is looked for in its stead, but only beside it if there is a
    next step; not of heat by the clock, which in one run is what a relay does."""
    return kept is not None and explains_most(current, kept) and not kept.found[-1].is_timed


def _fit_wider(trials: TrialFits, ranked: list[Hypothesis], is_told: bool, jobs: int) -> list[Hypothesis]:
    """Explanations, and more of them where these leave much; then what else sits where the best of them does, and
    beside the best path."""
    if not is_told:
        wider = trials.wider(jobs)
        trials, ranked = replace(wider, fits=(*trials.fits, *wider.fits)), best_first(*ranked, *wider.rank(jobs))
    if ranked:
        ranked = best_first(*ranked, *trials.around(ranked, jobs).rank(jobs))
    return ranked


def _search_switching(seen: Screening, seed: int, jobs: int, kept: Hypothesis | None = None) -> list[Hypothesis]:
    """The relays that explain most, where readings show how they switch, or else looked for where unknown heat would
    explain most; where the best leaves much, each that may come before what is kept on the lumps that it takes, for on
    coarse ones another place may seem the better."""
    switched, case = [c for c in seen.proposed if c.switches], seen.before.case
    found = search_shown_relays(case, seen.before, switched, jobs)
    if not found or found[0].chi >= SETTINGS.adequate:
        found = best_first(*found, *search_traced_relays(case, seen.before, switched, seed, jobs))
    if not found or (found[0].chi >= SETTINGS.adequate and not explains_most(seen.before, found[0])):
        able = rank_likely_places(switched, seen.located) if switched else []
        found = best_first(*found, *(search_relays(case, seen.before, able, seed, jobs) if able else ()))
    found = distinct(found)
    if not found or found[0].chi < SETTINGS.adequate or case.lacking:
        return found
    close = _list_able(seen.before, kept, found)
    refined = [compact(refine_until_converged(h.case, h, jobs)) for h in close]
    return best_first(*refined, *found[len(close) :])


def _list_able(before: Hypothesis, kept: Hypothesis | None, found: Sequence[Hypothesis]) -> Sequence[Hypothesis]:
    """Those of explanations, the best first, that may come before what is kept: that do on its lumps, or come near it
    where it takes finer ones."""
    if kept is None:
        return found
    if kept.machine.lumps == before.machine.lumps:
        return [h for h in found if h.evidence > kept.evidence]
    return near(before, [kept, *found], len(found) + 1)[1:]


def shows_nothing(seen: Screening) -> bool:
    """Whether no candidate scores what a name is worth, where not much is left."""
    return _is_near(seen) and not _worth_fitting(seen)


def _is_near(seen: Screening) -> bool:
    """Whether little is missing beside what was found, so that the linear scores can be believed."""
    return bool(seen.before.found) and seen.before.chi < SETTINGS.adequate


def _worth_fitting(seen: Screening) -> Sequence[Score]:
    """Scores of those that may be worth a name."""
    worth = HOPE * SETTINGS.worth * len(seen.before.fit.left) if _is_near(seen) else 0.0
    return [s for s in seen.scores if s.gain >= worth]


def is_told_so_far(current: Hypothesis) -> bool:
    """Whether a step is told while it is made: better than nothing where the time is up."""
    return not current.found and len(current.case.recordings) > 1
