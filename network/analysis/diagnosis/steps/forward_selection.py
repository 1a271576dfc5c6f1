"""Forward, step by step, from one null: what explains most is kept while it gains more than chance does."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

from network.analysis.calibration.gauss_newton import STEPS
from network.analysis.diagnosis.hypotheses.case_noise import use_file_noise
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.falling_short import explains_half, explains_most
from network.analysis.diagnosis.hypotheses.few_runs import SEARCHED, on_all_runs, on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, reweight
from network.analysis.diagnosis.latent_heat.latent_rest import rank_beside_rest
from network.analysis.diagnosis.lumps.lump_convergence import refine_until_converged
from network.analysis.diagnosis.screening.screen import Score
from network.analysis.diagnosis.screening.screening import (
    Screening,
    find_best_gain,
    leaves_something,
    screen_candidates,
)
from network.analysis.diagnosis.screening.significance import null_threshold
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.backward_elimination import check_selection, rerank_first
from network.analysis.diagnosis.steps.placement import place_ranked
from network.analysis.diagnosis.steps.ranking import best_first
from network.analysis.diagnosis.steps.refit import LATE, TrialFits, start_trials
from network.analysis.diagnosis.steps.rival_acceptance import INTERIM_STEPS, accept_best, list_contenders, take_first
from network.analysis.diagnosis.steps.selection import Selection
from network.analysis.diagnosis.steps.thermometer_fit import fit_thermometers, leaves_heat
from network.analysis.diagnosis.switching.relay_search import (
    rank_likely_places,
    search_relays,
    search_shown_relays,
)
from network.analysis.diagnosis.time_budget import BudgetReached

HOPE = 0.5
"""Linear score of a further candidate over what a name is worth, below which it is not fitted."""
Told = tuple[Hypothesis | None, list[Hypothesis]]
"""What is kept so far beside a hypothesis, and its rivals."""


def select_forward(
    null: Hypothesis, first: Screening, seed: int, jobs: int, tell: Callable[[float], None]
) -> Iterator[Selection]:
    """The steps from one null, each as it is taken, then what of them holds. first: its screening. The first step is
    told while it is made, for there may be no time to end it; but not of a single recording, which nothing else tests.
    Of many runs the steps are taken on those that are told worst, and what they come to is tested on all.

    The noise of the steps is that of the null: evidence under different noises cannot be compared. What is missing may
    have passed for noise there: where it shows under the noise that is left in the end, or where one of several
    findings is left, the steps go on under that, and what they come to is told where it explains more. Else they are
    taken on thermometers alone, where displacements leave much, and under the noise of the file, where that does not
    explain what is left. What these come to is tested under the noise that it leaves, as all is.
    """
    now = yield from _take_steps(null, Selection(first.whole or null), first, seed, jobs, tell)
    told = check_selection(null, _on_all_runs(null, now), jobs)
    yield told
    if _shows_more(now, told):
        again = _go_on(null, told, first, seed, jobs, tell)
        if again is not None and _tells_more(again, told):
            yield again
        return
    apart = _select_by_thermometers(null, told, first, seed, jobs, tell)
    if apart is not None and _tells_more(apart, told):
        yield (told := apart)
    held = _select_under_file_noise(null, told, seed, jobs, tell)
    if held is not None and not (told.best.found and _tells_more(told, held)):
        yield held


def _tells_more(other: Selection, told: Selection) -> bool:
    """Under the noise that the second leaves."""
    return reweight(told.best.case, other.best).evidence > told.best.evidence


def _go_on(
    null: Hypothesis, told: Selection, first: Screening, seed: int, jobs: int, tell: Callable[[float], None]
) -> Selection | None:
    """What further steps beside a tested selection come to, tested; None where these find nothing. Where the time is up
    that was no part of the search."""
    about = replace(told.keep_steps_found(), best=on_few_runs(told.best, SEARCHED))
    try:
        further = _run_out(_take_steps(null, about, first, seed, jobs, tell))
        is_more = len(further.best.found) > len(about.best.found)
        return check_selection(null, _on_all_runs(null, further), jobs) if is_more else None
    except BudgetReached:
        return None


def _select_by_thermometers(
    null: Hypothesis, told: Selection, first: Screening, seed: int, jobs: int, tell: Callable[[float], None]
) -> Selection | None:
    """What the steps come to that are taken on thermometers alone, then on all channels, tested, where a tested
    selection leaves much, and the null much of a displacement: numbers bent by what moves the tool centre point hide
    what is missing of the heat. None where thermometers alone show nothing, or where the time is up."""
    try:
        alone = fit_thermometers(on_few_runs(null, SEARCHED)) if told.best.chi > SETTINGS.adequate else None
        if alone is None or not leaves_heat(alone):
            return None
        seen, most = screen_candidates(alone, seed, jobs), SETTINGS.findings - 1
        heat = _run_out(_take_steps(alone, Selection(seen.whole or alone), seen, seed, jobs, tell, most))
        case = replace(heat.best.case, sigma=null.case.sigma)
        whole = fit_findings(case, heat.best.root, heat.best.found, heat.best.values) if heat.best.found else None
        if whole is None:
            return None
        further = _run_out(_take_steps(null, replace(heat, best=whole), first, seed, jobs, tell))
        return check_selection(null, _on_all_runs(null, further), jobs)
    except BudgetReached:
        return None


def _select_under_file_noise(
    null: Hypothesis, told: Selection, seed: int, jobs: int, tell: Callable[[float], None]
) -> Selection | None:
    """What the steps come to from a tested selection under the noise of the file, tested, where that leaves much there;
    None where no candidate is worth a name: what one alone explains may have passed for coloured noise, which many
    things together are. Where the time is up beside what was found, that was no part of the search."""
    bare = reweight(use_file_noise(told.best.case), told.best)
    if bare.chi <= SETTINGS.doubtful or len(bare.found) >= SETTINGS.findings:
        return None
    try:
        gain, readings = find_best_gain(bare, jobs)
        if gain < HOPE * SETTINGS.worth * readings:
            return None
        seen = screen_candidates(bare, seed, jobs)
        most = max((s.gain for s in seen.scores), default=0.0)
        if most < SETTINGS.worth * len(seen.before.fit.left):
            return None
        about = replace(told.keep_steps_found(), best=seen.whole or bare)
        further = _run_out(_take_steps(bare, about, seen, seed, jobs, tell))
        is_more = len(further.best.found) > len(about.best.found)
        return check_selection(null, _on_all_runs(null, further), jobs) if is_more else None
    except BudgetReached:
        if told.best.found:
            return None
        raise


def _take_steps(
    null: Hypothesis, now: Selection, first: Screening, seed: int, jobs: int, tell: Callable[[float], None],
    most: float = SETTINGS.findings,
) -> Generator[Selection, None, Selection]:  # fmt: skip
    """The steps from a selection, each as it is taken, and where they come to; most: findings."""
    while leaves_something(now.best) and len(now.best.found) < most:
        current, count = now.best, len(now.steps)
        seen = first if not current.found or current is first.whole else screen_candidates(current, seed, jobs)
        if _shows_nothing(seen):
            break
        threshold = now.threshold if now.steps else null_threshold(seen.scores, seed)
        told = partial(_report_share, tell, min(0.15 + 0.25 * count, 0.65))
        before, kept = now, None
        for kept, ranked in _select_next(current, seen, threshold, seed, jobs, told, _may_show_relays(now)):
            now = before if kept is None else _add_step(before, seen, kept, ranked, threshold)
            if _is_told_so_far(current):
                yield _on_all_runs(null, now, INTERIM_STEPS)
        now = replace(now, threshold=threshold)
        if kept is None:
            break
        if len(now.steps) > 1:
            now = rerank_first(now, jobs)
        tell(min(0.4 + 0.25 * count, 0.75))
        yield _on_all_runs(null, now, INTERIM_STEPS)
    return now


def _may_show_relays(now: Selection) -> bool:
    """Whether relays may show beside what was found: where its last step found none it has to leave less than half of
    what was there, for that they have been looked for in vain."""
    if not now.befores or not now.best.found or now.best.found[-1].switches:
        return True
    case, before = now.best.case, now.befores[-1]
    is_alike = (before.case.noise, before.case.sigma) == (case.noise, case.sigma)
    return explains_half(before if is_alike else reweight(case, before), now.best)


def _run_out(steps: Generator[Selection, None, Selection]) -> Selection:
    """Where steps come to, nothing of them told on the way: what was tested before stands until they are, too."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return cast(Selection, end.value)


def _shows_more(now: Selection, told: Selection) -> bool:
    """Whether what was found leaves something under the noise that is left in the end, and did not before, or has held
    in the stead of another finding."""
    count = len(told.best.found)
    is_new = count < len(now.best.found) or not leaves_something(now.best)
    return 0 < count < SETTINGS.findings and is_new and leaves_something(told.best)


def _on_all_runs(null: Hypothesis, now: Selection, steps: int = STEPS) -> Selection:
    """A selection whose best is fitted to all runs of the null; without findings where it does not fit these."""
    best = on_all_runs(null, now.best, steps)
    return replace(now, best=best, gains=now.gains[: len(best.found)])


def _is_told_so_far(current: Hypothesis) -> bool:
    """Whether a step is told while it is made: better than nothing where the time is up."""
    return not current.found and len(current.case.recordings) > 1


def _add_step(
    now: Selection, seen: Screening, kept: Hypothesis, ranked: Sequence[Hypothesis], threshold: float
) -> Selection:  # fmt: skip
    """A selection with a further finding."""
    befores, steps = (*now.befores, compact(seen.before)), (*now.steps, _put_first(kept, ranked))
    gains, unseen = (*now.gains, kept.evidence - now.best.evidence), (*now.unseen, seen.unseen)
    return Selection(kept, befores, steps, gains, threshold, unseen=unseen)


def _select_next(
    current: Hypothesis, seen: Screening, threshold: float, seed: int, jobs: int, tell: Callable[[float], None],
    may_switch: bool = True,
) -> Iterator[Told]:  # fmt: skip
    """What is kept beside a hypothesis, and its rivals, ever better founded: relays, if any may show, are looked for
    before much else is tried, where what is likely explains little, and last, where much is left, or else beside what
    is kept."""
    sway = partial(_search_switching, seen, seed, jobs)
    trials, passing = yield from _begin_trials(current, seen, threshold, jobs, tell)
    smooth = trials.rank(jobs)
    if _is_told_so_far(current):
        first = take_first(current, seen.before, smooth, threshold)
        if passing is None or _is_better(first, passing):
            yield first, smooth
    early = sway() if may_switch and trials.is_poor(smooth) else None
    if not seen.before.found:
        is_told = early is None or bool(early and early[0].chi <= trials.little)
        smooth = _fit_wider(trials, smooth, is_told, jobs)
    ranked = best_first(*(early or ()), *place_ranked(seen.before, smooth, jobs))
    if _is_told_so_far(current):
        yield take_first(current, seen.before, ranked, threshold), ranked
    ranked = rank_beside_rest(ranked, jobs)
    tried = list_contenders(current, seen.before, ranked, jobs)
    kept = accept_best(current, seen.before, tried, threshold, jobs)
    yield kept, ranked
    is_due = (kept or current).chi > SETTINGS.adequate and not _is_next(current, kept)
    switched = sway() if may_switch and early is None and is_due else []
    if not switched:
        return
    ranked = rank_beside_rest(best_first(*switched, *ranked), jobs)
    again = list_contenders(current, seen.before, ranked, jobs)
    other = accept_best(current, seen.before, again, threshold, jobs) if again != tried else None
    yield other if _is_better(other, kept) else kept, ranked


def _begin_trials(
    current: Hypothesis, seen: Screening, threshold: float, jobs: int, tell: Callable[[float], None]
) -> Generator[Told, None, tuple[TrialFits, Hypothesis | None]]:
    """What is likely, each fitted a few steps, and what was told of it: where it is late, the best as soon as it is,
    where it explains most."""
    is_late = _is_told_so_far(current) and current.case.budget.is_past(LATE * SETTINGS.searched)
    begun, passing = None, None
    for trials in start_trials(seen.before, seen.proposed, _worth_fitting(seen), jobs, tell, _is_near(seen), is_late):
        if is_late and trials.foremost not in (None, begun):
            begun = trials.foremost
            fitted = trials.fit_in_passing(begun)
            first = take_first(current, seen.before, fitted, threshold)
            if first is not None and explains_most(current, first) and _is_better(first, passing):
                yield (passing := first), fitted
    return trials, passing


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


def _search_switching(seen: Screening, seed: int, jobs: int) -> list[Hypothesis]:
    """The relays that explain most, where readings show how they switch, or else looked for where unknown heat would
    explain most; where the best leaves much, each on the lumps that it takes, for on coarse ones another place may seem
    the better."""
    switched, case = [c for c in seen.proposed if c.switches], seen.before.case
    found = search_shown_relays(case, seen.before, switched, jobs)
    if not found or found[0].chi >= SETTINGS.adequate:
        able = rank_likely_places(switched, seen.located) if switched else []
        found = best_first(*found, *(search_relays(case, seen.before, able, seed, jobs) if able else ()))
    if not found or found[0].chi < SETTINGS.adequate or case.lacking:
        return found
    return best_first(*(compact(refine_until_converged(h.case, h, jobs)) for h in found))


def _shows_nothing(seen: Screening) -> bool:
    """Whether no candidate scores what a name is worth, where not much is left."""
    return _is_near(seen) and not _worth_fitting(seen)


def _is_near(seen: Screening) -> bool:
    """Whether little is missing beside what was found, so that the linear scores can be believed."""
    return bool(seen.before.found) and seen.before.chi < SETTINGS.adequate


def _worth_fitting(seen: Screening) -> Sequence[Score]:
    """Scores of those that may be worth a name."""
    worth = HOPE * SETTINGS.worth * len(seen.before.fit.left) if _is_near(seen) else 0.0
    return [s for s in seen.scores if s.gain >= worth]


def _report_share(tell: Callable[[float], None], done: float, share: float) -> None:
    tell(done + 0.1 * share)


def _put_first(best: Hypothesis, ranked: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """The rivals, the one that was kept first."""
    return tuple(sorted(ranked, key=lambda h: (h.found[-1].key != best.found[-1].key, -h.weighed)))
