"""Forward, step by step, from one null: what explains most is kept while it gains more than chance does."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

from network.analysis.calibration.gauss_newton import STEPS
from network.analysis.diagnosis.hypotheses.case_noise import have_same_noise, use_file_noise
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.falling_short import explains_half
from network.analysis.diagnosis.hypotheses.few_runs import SEARCHED, on_all_runs, on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, reweight
from network.analysis.diagnosis.screening.screening import (
    Screening,
    leaves_something,
    scores_as_much,
    screen_candidates,
)
from network.analysis.diagnosis.screening.significance import null_threshold
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.backward_elimination import check_selection
from network.analysis.diagnosis.steps.faint_candidates import settle_lumps, shows_name
from network.analysis.diagnosis.steps.first_rivals import rerank_first
from network.analysis.diagnosis.steps.next_finding import HOPE, is_told_so_far, select_next, shows_nothing
from network.analysis.diagnosis.steps.rival_acceptance import INTERIM_STEPS
from network.analysis.diagnosis.steps.selection import Selection
from network.analysis.diagnosis.steps.thermometer_fit import fit_thermometers, leaves_heat
from network.analysis.diagnosis.time_budget import BudgetReached


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
    begun, seen = settle_lumps(first.whole or null, first, seed, jobs)
    now = yield from _take_steps(null, Selection(begun), seen, seed, jobs, tell)
    told = check_selection(null, _on_all_runs(null, now), jobs)
    yield told
    if _shows_more(now, told):
        again = None if now.went_from(told.best) else _go_on(null, told, first, seed, jobs, tell)
        if again is not None and _tells_more(again, told):
            yield again
        return
    apart = _select_by_thermometers(null, told, first, seed, jobs, tell)
    if apart is not None and _tells_more(apart, told):
        yield (told := apart)
    for held in _select_under_file_noise(null, told, seed, jobs, tell):
        if not (told.best.found and _tells_more(told, held)):
            yield (told := held)


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
) -> Iterator[Selection]:
    """What the first step comes to from a tested selection under the noise of the file, then all of them, each tested,
    where that leaves much there; nothing where no candidate is worth a name: what one alone explains may have passed
    for coloured noise, which many things together are. Where the time is up beside what was found, that was no part of
    the search."""
    bare = reweight(use_file_noise(told.best.case), told.best)
    if bare.chi <= SETTINGS.doubtful or len(bare.found) >= SETTINGS.findings:
        return
    try:
        if not scores_as_much(bare, HOPE * SETTINGS.worth, seed, jobs):
            return
        seen = screen_candidates(bare, seed, jobs)
        most = max((s.gain for s in seen.scores), default=0.0)
        if most < SETTINGS.worth * len(seen.before.fit.left):
            return
        about = replace(told.keep_steps_found(), best=seen.whole or bare)
        for count in range(len(about.best.found) + 1, int(SETTINGS.findings) + 1):
            further = _run_out(_take_steps(bare, about, seen, seed, jobs, tell, count))
            if len(further.best.found) < count:
                return
            told = check_selection(null, _on_all_runs(null, about := further), jobs)
            yield told
    except BudgetReached:
        if not told.best.found:
            raise


def _take_steps(
    null: Hypothesis, now: Selection, first: Screening, seed: int, jobs: int, tell: Callable[[float], None],
    most: float = SETTINGS.findings,
) -> Generator[Selection, None, Selection]:  # fmt: skip
    """The steps from a selection, each as it is taken if it may be told so far, and where they come to; most:
    findings."""
    while (leaves_something(now.best) or shows_name(now.best, first)) and len(now.best.found) < most:
        current, count = now.best, len(now.steps)
        seen = first if not current.found or current is first.whole else screen_candidates(current, seed, jobs)
        if shows_nothing(seen):
            break
        threshold = now.threshold if now.steps else null_threshold(seen.scores, seed)
        told = partial(_report_share, tell, min(0.15 + 0.25 * count, 0.65))
        before, kept = now, None
        for kept, ranked in select_next(current, seen, threshold, seed, jobs, told, _may_show_relays(now)):
            now = before if kept is None else _add_step(before, seen, kept, ranked, threshold)
            if is_told_so_far(current):
                yield _on_all_runs(null, now, INTERIM_STEPS)
        now = replace(now, threshold=threshold)
        if kept is None:
            break
        if len(now.steps) > 1:
            now = rerank_first(now, jobs)
        tell(min(0.4 + 0.25 * count, 0.75))
        if _shows_again(now):
            yield _on_all_runs(null, now, INTERIM_STEPS)
    return now


def _shows_again(now: Selection) -> bool:
    """Whether nothing but time is wanting for what a step found beside something: it leaves nothing, or shows where it
    was not chosen. Else the last test may not let it stand."""
    test = now.unseen_of(now.best.found[-1])
    return len(now.best.found) < 2 or test is None or test.shows_again or now.best.chi <= SETTINGS.noise


def _may_show_relays(now: Selection) -> bool:
    """Whether relays may show beside what was found: where its last step found none it has to leave less than half of
    what was there, for that they have been looked for in vain."""
    if not now.befores or not now.best.found or now.best.found[-1].switches:
        return True
    case, before = now.best.case, now.befores[-1]
    return explains_half(before if have_same_noise(before.case, case) else reweight(case, before), now.best)


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


def _add_step(
    now: Selection, seen: Screening, kept: Hypothesis, ranked: Sequence[Hypothesis], threshold: float
) -> Selection:  # fmt: skip
    """A selection with a further finding."""
    befores, steps = (*now.befores, compact(seen.before)), (*now.steps, _put_first(kept, ranked))
    gains, unseen = (*now.gains, kept.evidence - now.best.evidence), (*now.unseen, seen.unseen)
    return Selection(kept, befores, steps, gains, threshold, unseen=unseen)


def _report_share(tell: Callable[[float], None], done: float, share: float) -> None:
    tell(done + 0.1 * share)


def _put_first(best: Hypothesis, ranked: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """The rivals, the one that was kept first."""
    return tuple(sorted(ranked, key=lambda h: (h.found[-1].key != best.found[-1].key, -h.weighed)))
