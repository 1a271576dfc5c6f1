"""From what a search found to what is said: verdict, confidence, rivals, the machine with its findings, the gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from network.analysis.calibration.gauss_newton import chi_of
from network.analysis.calibration.growing_horizon import has_relays
from network.analysis.diagnosis.experiments.advice import experiments
from network.analysis.diagnosis.findings.diagnosis_notes import (
    tell_corrections,
    tell_recordings,
    tell_refuted,
    tell_unseen,
)
from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding
from network.analysis.diagnosis.findings.findings import is_shadow, list_findings, list_rivals
from network.analysis.diagnosis.findings.invariants import doubt_fitted, doubt_unseen
from network.analysis.diagnosis.findings.isolability import isolability
from network.analysis.diagnosis.findings.joined_findings import join_alike, join_rests
from network.analysis.diagnosis.findings.result import Diagnosis, Fits
from network.analysis.diagnosis.findings.simulated_findings import is_finer, leave_fault, numbers_in, withdraw_refuted
from network.analysis.diagnosis.findings.simulated_runs import SimulatedRuns
from network.analysis.diagnosis.findings.unnamed_findings import find_unknown, list_read, trace_first
from network.analysis.diagnosis.findings.withheld_names import withhold_names
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.lumps.lump_shortfall import lacks_what_is_left
from network.analysis.diagnosis.lumps.lumping_finding import find_lumping, gain_of_lumps
from network.analysis.diagnosis.screening.screened_gain import list_screened
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.refit import linearise_at_priors
from network.analysis.diagnosis.steps.selection import Selection
from network.analysis.diagnosis.strategies import list_unsearched
from network.analysis.diagnosis.time_budget import TimeBudget
from network.machine.machine import Machine

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search

WITHDRAWN = "what explains the fitted runs better did not hold when it was simulated"
"""Why something without a name is not sure of its place."""


def _is_late(budget: TimeBudget, ended: str) -> bool:
    """Whether how far a machine holds is to be found briefly."""
    return bool(ended) or budget.is_searched()


def conclude(search: Search, before: SimulatedRuns, warnings: Sequence[str], seed: int, jobs: int) -> Diagnosis:
    """The diagnosis that a search amounts to; before: all runs as calibrated, those that were held out, too."""
    is_late = partial(_is_late, search.case.budget, search.ended)
    search = replace(search, case=replace(search.case, budget=TimeBudget()))
    whole = search
    search, found, fits, refuted = withdraw_refuted(search, before, jobs)
    finer_gain = gain_of_lumps(search.written, search.null, search.best)
    is_told = finer_gain > search.threshold and (is_finer(search) or _is_untaken(search, refuted))
    finest = search.best.root if is_finer(search) else search.null.root
    coarse = find_lumping(search.written, finest, finer_gain, search.threshold) if is_told else None
    listed = list_findings(search, search.calibrated.fitted if found is None else found)
    findings, verdict = _decide_verdict(search, listed, coarse, bool(refuted), jobs)
    if beside := _find_beside(whole, search, findings, jobs):
        findings, verdict = [*findings, *beside], "missing_physics"
    doubt, much_left = doubt_unseen(fits), doubt_fitted(fits)
    doubted = [f.doubted(doubt).doubted(much_left) for f in _share_belief(findings)]
    findings = join_rests(withhold_names(join_alike(doubted)), partial(list_read, search.best.machine))
    findings = [f.doubted(WITHDRAWN) if refuted and f.kind == UNKNOWN else f for f in findings]
    verdict = "sensor_fault" if verdict == "missing_physics" and _are_sensors(findings) else verdict
    if search.ended:  # nothing is sure
        findings = [replace(f, confidence=min(f.confidence, SETTINGS.half)) for f in findings]
    known = isolability(search.screened.scores, search.screened.proposed)
    can_advise = not search.ended and {*search.case.machine.inputs} <= {*search.given.machine.inputs}
    advice = tuple(experiments(search, known.unseen)) if can_advise else ()
    is_looked = search.null.chi > SETTINGS.noise
    unsearched = list_unsearched(search.screened, search.ended, _list_tried(search, findings)) if is_looked else []
    told = [*tell_refuted(refuted), *tell_recordings(search), *(u.sentence for u in unsearched)]
    told += list(tell_unseen(fits)) if doubt and not findings else []
    told += list(tell_corrections(search, before.held, fits))
    notes = (*warnings, *told, *([known.sentence] if known.sentence else ()))
    calibrated = search.calibrated.state_numbers(is_late) if found is None else search.calibrated.fitted
    after = calibrated if found is None else numbers_in(search.told, is_late)
    after = leave_fault(search, after, before.held, fits)
    return Diagnosis(
        search.given.machine, calibrated, after, verdict, tuple(findings), _channels(fits), trace_first(search), fits,
        tuple(list_rivals(search.steps[0], search.befores[0]) if search.steps else ()), notes, advice,
        _shifts(search.told), seed, explained=search.selection.explained, ended=search.ended, refuted=tuple(refuted),
        unsearched=tuple(unsearched), screened=list_screened(search.screened.scores),
    )  # fmt: skip


def _is_untaken(search: Search, refuted: Sequence[str]) -> bool:
    """Whether lumps alone leave nothing, but were taken back, as simulated runs speak against them: what switches falls
    out of step with them."""
    null = search.null
    if search.fault is not None or null.machine.lumps <= search.written.machine.lumps:
        return False
    return bool(refuted) and not search.best.found and null.chi <= SETTINGS.noise and has_relays(null.machine)


def _list_tried(search: Search, findings: Sequence[Finding]) -> set[str]:
    """The kinds of which something was fitted, and those that are told."""
    return {h.found[-1].kind.kind for ranked in search.steps for h in ranked} | {f.kind for f in findings}


def _decide_verdict(
    search: Search, findings: list[Finding], coarse: Finding | None, is_refuted: bool, jobs: int = 1
) -> tuple[list[Finding], str]:
    """Findings and verdict. What holds on unseen runs is told, as a part of the truth where much is left; before it,
    what has no name, where that is more, the names are less likely than not, or heat at one place alone explains more
    than they do. Without names nothing is told that coarse lumps may be, where there was no time for finer ones."""
    best, cut = search.best, [coarse] if coarse else []
    is_left = best.chi > SETTINGS.doubtful and bool(search.located)
    if findings:
        holds = min(search.share_that_holds, max(f.confidence for f in findings))
        is_more = (is_left and holds < SETTINGS.half) or _is_vain(search)
        is_bent = is_left and search.fault is None and is_shadow(search)
        only_sensors = not (is_more or is_bent) and all(f.channels for f in findings)
        unnamed = [find_unknown(search, is_bent)] if is_more or is_bent else []
        told = _put_in_order(best.machine, unnamed, [*map(_doubt_stop, findings)]) if unnamed else findings
        return [*told, *cut], "sensor_fault" if only_sensors else "missing_physics"
    if not is_finer(search) and (coarse or (is_left and _may_be_lumps(search, jobs))):
        return cut, "too_coarse"
    if is_left or (is_refuted and best.chi > SETTINGS.adequate and _stands_out(search)):
        unknown = find_unknown(search)
        return [*cut, unknown], "unexplained" if unknown.kind == UNKNOWN else "missing_physics"
    if coarse:
        return cut, "too_coarse"
    wrong = any(abs(x) > SETTINGS.shift for x in _shifts(best).values()) or _was_off(search)
    return [], "parameters_only" if wrong else "adequate"


def _find_beside(whole: Search, search: Search, findings: Sequence[Finding], jobs: int) -> list[Finding]:
    """What has no name beside a fault of readings that is told alone, where the time was up before anything was looked
    for beside it, and lumps are not what is left: at the numbers as fitted (whole), though these were taken back."""
    is_alone = bool(findings) and search.fault is not None and not search.best.found
    if not is_alone or search.ended != "budget" or any(f.is_unnamed for f in findings):
        return []
    null, is_left = whole.null, whole.null.chi > SETTINGS.doubtful and bool(whole.located)
    if not is_left or lacks_what_is_left(null, jobs):
        return []
    return [find_unknown(replace(whole, selection=Selection(null)))]


def _may_be_lumps(search: Search, jobs: int) -> bool:
    """Whether the time was up before lumps were found that do not lack as much as is left."""
    return search.ended == "budget" and lacks_what_is_left(search.best, jobs)


def _are_sensors(findings: Sequence[Finding]) -> bool:
    """Whether all that is told, but for lumps, are faults of channels with a name."""
    told = [f for f in findings if not f.is_cut]
    return bool(told) and all(f.channels and not f.is_unnamed for f in told)


def _share_belief(findings: Sequence[Finding]) -> list[Finding]:
    """What has no name is believed in as far as names beside it do not hold, and no less than half."""
    holds = [f.holds for f in findings if f.holds is not None]
    if not holds or not any(f.is_unnamed for f in findings):
        return [*findings]
    nameless = max(1 - holds[0], SETTINGS.half)
    return [f.weigh(nameless if f.is_unnamed else 1 - nameless) for f in findings]


def _doubt_stop(finding: Finding) -> Finding:
    """A finding beside what has no name: what fades or comes and goes can look like a drive that stood still."""
    return finding.doubted("what has no name may look like a stop") if finding.is_stop else finding


def _is_vain(search: Search) -> bool:
    """Whether what was found leaves more than it should, and explains less than half."""
    best = search.best
    is_much = best.chi > SETTINGS.adequate and bool(search.located)
    return is_much and bool(best.found) and search.share_that_holds < SETTINGS.half


def _put_in_order(machine: Machine, unknown: list[Finding], findings: list[Finding]) -> list[Finding]:
    """What has no name first, but in a channel whose fault is named, and in the parts that it reads: there it is what
    the name leaves."""
    faulty = {name for f in findings for name in f.channels}
    read = {place.node for name in faulty for place in list_read(machine, name)}
    is_same = any((u.channels or u.places) and faulty.issuperset(u.channels) and read.issuperset(u.places)
                  for u in unknown)  # fmt: skip
    return [*findings, *unknown] if is_same else [*unknown, *findings]


def _stands_out(search: Search) -> bool:
    """Whether unknown heat at one place explains more than chance would."""
    return bool(search.located) and search.located[0].gain > search.threshold


def _was_off(search: Search) -> bool:
    """Whether the numbers of the file, as they stand, leave more than noise."""
    at = linearise_at_priors(search.null.linearised)
    return at is None or chi_of(at) > SETTINGS.doubtful


def _channels(fits: Fits) -> Mapping[str, float]:
    """Channels by how far they were off before, the worst first."""
    told: dict[str, float] = fits.summary()["train"]["before"]["channels"]
    return dict(sorted(told.items(), key=lambda pair: -pair[1]))


def _shifts(h: Hypothesis) -> dict[str, float]:
    """How far the numbers of the file moved, in prior σ, the farthest first."""
    own = {p.path for p in h.own}
    names = [p.path for p in h.fit.problem.parameters if p.path not in own]
    return dict(sorted(zip(names, h.shift.tolist(), strict=True), key=lambda pair: -abs(pair[1])))
