"""The search: structure first, then what a sensor does by fits and starts, then effects step by step.

Every state that is yielded is better founded than the one before and could be told; the last one is what the search
comes to. Lumps are refined where that mends more than it costs; from which of them the steps go is a matter of tracks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from network.analysis.calibration.misfit import lasting_misfit
from network.analysis.calibration.null import Null
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.case_noise import estimate_noise
from network.analysis.diagnosis.hypotheses.faced_relays import fit_written, keep_in_step
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis, reweight, state
from network.analysis.diagnosis.latent_heat.unrecorded_surroundings import find_unrecorded, weigh_unrecorded
from network.analysis.diagnosis.lumps.lump_convergence import refine_until_converged
from network.analysis.diagnosis.lumps.lump_refinement import hardly_matter, is_late, refine_lumps
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.analysis.diagnosis.readings_set_right import set_right, set_right_on_lumps
from network.analysis.diagnosis.resized_fault import resize_beside, resize_fault
from network.analysis.diagnosis.screening.screening import Screening, leaves_something
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.forward_selection import select_forward
from network.analysis.diagnosis.steps.selection import Selection
from network.analysis.diagnosis.time_budget import BudgetReached
from network.analysis.diagnosis.tracks import Track, list_begins, list_tracks
from network.analysis.diagnosis.weighed_fault import is_told_better, lay_alike, weigh_fault
from network.platform.refusal import Failed


def search(case: Case, calibrated: Null, seed: int, jobs: int, tell: Callable[[float], None]) -> Iterator[Search]:
    """Ever better states."""
    given, case = case, keep_in_step(case, calibrated)
    written = state(case, case.machine, calibrated.values)
    yield Search(given, case, None, written, calibrated, written, Selection(written), Screening(written))
    written = fit_written(written)
    first = Search(given, written.case, None, written, calibrated, written, Selection(written), Screening(written))
    fault, mended = set_right(written, jobs)
    begun = first if fault is None else _with_fault(first, fault, mended)
    yield begun
    states = _search_set_right(begun, first, seed, jobs, tell)
    yield (now := next(states))
    if not _is_found_again(now, first):
        yield first
        states = _search_from(first, seed, jobs, tell, sets_right=False)
        yield (now := next(states))
    if now.fault is not None and now.fault.competes and now.null.chi > SETTINGS.adequate:
        states = weigh_fault(now, states, _search_from(first, seed, jobs, tell, sets_right=False), jobs)
    for now in states:
        yield now
    if now.best.found and now.fault is not None:
        if not _shows_beside(now.best, now.fault, first):
            yield from _search_without(now, first, seed, jobs, tell)
        else:
            yield from resize_fault(now, first.case, jobs)
    if now.fault is None and now.best.found and leaves_something(now.best):
        yield from _search_beside(now, seed, jobs, tell)


def _is_found_again(now: Search, first: Search) -> bool:
    """Whether the fault of readings explains more than chance on the lumps and under the noise of the null, too, where
    these are others than those it was found on (first): what coarse lumps leave looks like a fault."""
    if now.fault is None or now.null.machine is now.written.machine:
        return True
    return _shows_beside(now.null, now.fault, first)


def _shows_beside(h: Hypothesis, fault: ReadingFault, first: Search) -> bool:
    """Whether a fault of readings explains more than chance beside a hypothesis that was fitted to readings set right
    (first: as they were)."""
    case = replace(fault.leave_wrong(first.case), noise=h.case.noise, sigma=h.case.sigma)
    try:
        bare = fit_hypothesis(case, h.machine, h.found, h.own, start=h.values)
    except (Failed, np.linalg.LinAlgError):
        return True
    return h.evidence - bare.evidence > SETTINGS.least * lasting_misfit(h.linearised) ** 2


def _search_without(
    now: Search, first: Search, seed: int, jobs: int, tell: Callable[[float], None]
) -> Iterator[Search]:
    """What a search comes to on readings as they were, where it explains more than those set right."""
    *_, other = _search_from(first, seed, jobs, tell, sets_right=False)
    if is_told_better(lay_alike(now, other), now.best, jobs):
        yield other


def _search_beside(found: Search, seed: int, jobs: int, tell: Callable[[float], None]) -> Iterator[Search]:
    """What a search comes to on readings set right, where a fault of them shows beside what was found; where it leaves
    much or competes otherwise, as long as that explains more. Where the time is up before that is known, this was no
    part of the search."""
    try:
        fault, mended = set_right(reweight(found.best.case, found.best), jobs, is_finest=True)
    except BudgetReached:
        return
    if fault is not None:
        *_, last = _search_set_right(_with_fault(found, fault, mended), found, seed, jobs, tell)
        if not fault.competes or is_told_better(last.best, lay_alike(last, found), jobs):
            yield last


def _search_set_right(
    begun: Search, first: Search, seed: int, jobs: int, tell: Callable[[float], None]
) -> Iterator[Search]:
    """Ever better states from readings that may be set right (first: as they were). Where what was found leaves much
    because the fault was found beside numbers bent to what was missing, all begins again on readings set right by the
    size that it has beside that: what comes of that is told as soon as something is found, or hardly anything is left,
    and in the end."""
    for now in _search_from(begun, seed, jobs, tell):
        again = resize_beside(now, first.case)
        yield again or now
        if again is not None and again.fault is not None:
            states = _search_from(_with_fault(first, again.fault, again.best), seed, jobs, tell)
            yield from _list_worth_telling(states)
            return


def _list_worth_telling(states: Iterator[Search]) -> Iterator[Search]:
    """Of the states of a search those that have found something or leave hardly anything, and the last."""
    is_told, now = True, None
    for now in states:
        if is_told := bool(now.best.found) or now.best.chi <= SETTINGS.adequate:
            yield now
    if now is not None and not is_told:
        yield now


def _with_fault(now: Search, fault: ReadingFault, mended: Hypothesis) -> Search:
    """The machine as written, fitted to readings that were set right; mended: a fit to such readings."""
    case = fault.set_right(now.written.case)
    written = fit_hypothesis(case, case.machine, start=mended.values)
    screened = Screening(written)
    return replace(
        now, case=case, fault=fault, written=written, null=written, selection=Selection(written), screened=screened
    )


def _search_from(
    now: Search, seed: int, jobs: int, tell: Callable[[float], None], sets_right: bool = True
) -> Iterator[Search]:
    """Ever better states from the machine as written; sets_right: whether readings may be at fault. Where the time is
    up before the first, what is known of finer lumps."""
    now = now.allot()
    levels = refine_lumps(now.case, now.written, jobs)
    tell(0.1)
    try:
        now, begins = _settle_null(now, levels, jobs, tell, sets_right)
    except BudgetReached:
        yield _begin_from(now, max(levels, key=_evidence))
        raise
    yield now
    states = _follow_tracks(now, list_tracks(now.null, now.written, begins, seed, jobs), seed, jobs, tell)
    yield from states if now.unrecorded is None else weigh_unrecorded(now.unrecorded, states)


def _settle_null(
    now: Search, levels: Sequence[Hypothesis], jobs: int, tell: Callable[[float], None], sets_right: bool
) -> tuple[Search, list[Hypothesis]]:
    """The null on the lumps that it takes, on readings that were set right, under the noise that it leaves; and what
    steps may go from."""
    may_mend, finest = now.fault is None and sets_right, max(levels, key=_evidence)
    fault, mended = set_right_on_lumps(now.written, finest, jobs) if may_mend else (None, finest)
    if fault is not None:
        now = _with_fault(now, fault, mended).allot()
        levels = refine_lumps(now.case, now.written, jobs)
    tell(0.15)
    best = _choose_level(levels)
    case = estimate_noise(now.case, best)
    if best is not levels[0] and not hardly_matter(best, levels[0]):
        best = refine_until_converged(case, reweight(case, best), jobs, is_late)
        case = estimate_noise(case, best)
    written = reweight(case, levels[0])
    begins = [written if h is levels[0] else reweight(case, h) for h in list_begins(levels, best)]
    null = max(begins, key=_evidence)
    now = _begin_from(replace(now, case=case, written=written), null)
    return replace(now, unrecorded=find_unrecorded(null)), begins


def _begin_from(now: Search, null: Hypothesis) -> Search:
    """With another null, of which nothing is known yet."""
    return replace(now, null=null, selection=Selection(null), screened=Screening(null))


def _choose_level(levels: Sequence[Hypothesis]) -> Hypothesis:
    """The machine on the lumps that explain most; as it was written where finer ones hardly matter and are slow."""
    written, best = levels[0], max(levels, key=_evidence)
    return written if is_late(best) and hardly_matter(best, written) else best


def _follow_tracks(
    now: Search, tracks: Iterator[Track], seed: int, jobs: int, tell: Callable[[float], None]
) -> Iterator[Search]:
    """The steps from one track after the other, as long as they leave much."""
    best: Search | None = None
    for track in tracks:
        if best is not None and best.best.chi < SETTINGS.adequate:
            return
        begun = replace(now, screened=track.screened)
        if best is None:
            yield (best := begun)
        before = best
        for selection in select_forward(track.begin, track.screened, seed, jobs, tell):
            after = replace(begun, selection=selection) if _is_taken(selection, track, before) else before
            if after is not best:
                yield (best := after)


def _is_taken(selection: Selection, track: Track, before: Search) -> bool:
    """Whether the steps of a track come to more than those before it, once they are tested where these found something
    or were tested; whatever those of the null come to where nothing was found."""
    if track.begin is before.null and not before.best.found:
        return True
    is_tested = before.selection.is_checked or bool(before.best.found)
    return (selection.is_checked or not is_tested) and _beats(selection, before, before.case)


def _beats(selection: Selection, best: Search, case: Case) -> bool:
    """Under one noise."""
    return reweight(case, selection.best).evidence > reweight(case, best.best).evidence


def _evidence(h: Hypothesis) -> float:
    return h.evidence
