"""From what a search found to what is said: confidence, rivals, notes, the machine with its findings, the gain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from network.analysis.calibration.growing_horizon import has_relays
from network.analysis.diagnosis.experiments.advice import experiments
from network.analysis.diagnosis.experiments.experiment import Experiment
from network.analysis.diagnosis.findings.diagnosis_notes import (
    tell_corrections,
    tell_recordings,
    tell_refuted,
    tell_unseen,
)
from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding
from network.analysis.diagnosis.findings.findings import list_findings, list_rivals
from network.analysis.diagnosis.findings.invariants import doubt_fitted, doubt_unseen
from network.analysis.diagnosis.findings.isolability import Isolability, isolability
from network.analysis.diagnosis.findings.joined_findings import join_alike, join_rests
from network.analysis.diagnosis.findings.result import Diagnosis, Fits
from network.analysis.diagnosis.findings.simulated_findings import is_finer, leave_fault, numbers_in, withdraw_refuted
from network.analysis.diagnosis.findings.simulated_runs import SimulatedRuns
from network.analysis.diagnosis.findings.unnamed_findings import list_read, trace_first
from network.analysis.diagnosis.findings.verdict import decide_verdict, find_beside, list_shifts
from network.analysis.diagnosis.findings.withheld_names import withhold_names
from network.analysis.diagnosis.lumps.lumping_finding import find_lumping, gain_of_lumps
from network.analysis.diagnosis.screening.screened_gain import list_screened
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.strategies import list_unsearched
from network.analysis.diagnosis.time_budget import TimeBudget

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search

WITHDRAWN = "what explains the fitted runs better did not hold when it was simulated"
"""Why something without a name is not sure of its place."""


def conclude(search: Search, before: SimulatedRuns, warnings: Sequence[str], seed: int, jobs: int) -> Diagnosis:
    """The diagnosis that a search amounts to; before: all runs as calibrated, those that were held out, too."""
    is_late = partial(_is_late, search.case.budget, search.ended)
    whole = replace(search, case=replace(search.case, budget=TimeBudget()))
    search, found, fits, refuted = withdraw_refuted(whole, before, jobs)
    listed = list_findings(search, search.calibrated.fitted if found is None else found)
    findings, verdict = decide_verdict(search, listed, _find_coarse(search, refuted), bool(refuted), jobs)
    if beside := find_beside(whole, search, findings, jobs):
        findings, verdict = [*findings, *beside], "missing_physics"
    findings = _weigh_findings(search, findings, fits, bool(refuted))
    known = isolability(search.screened.scores, search.screened.proposed)
    is_looked = whole.null.chi > SETTINGS.noise or bool(whole.steps)
    is_room, tried = search.unrecorded is not None, _list_tried(search, findings)
    cut_short = "" if search.selection.is_checked and search.best.found else search.ended
    unsearched = list_unsearched(search.screened, cut_short, tried, is_room) if is_looked else []
    sentences = [*tell_refuted(refuted), *tell_recordings(search), *(u.sentence for u in unsearched)]
    sentences += _tell_runs(search, before, findings, fits)
    calibrated = search.calibrated.state_numbers(is_late) if found is None else search.calibrated.fitted
    after = calibrated if found is None else numbers_in(search.told, is_late)
    return Diagnosis(
        search.given.machine, calibrated, leave_fault(search, after, before.held, fits),
        "sensor_fault" if verdict == "missing_physics" and _are_sensors(findings) else verdict, tuple(findings),
        _channels(fits), trace_first(search), fits,
        tuple(list_rivals(search.steps[0], search.befores[0]) if search.steps else ()),
        (*warnings, *sentences, *([known.sentence] if known.sentence else ())), _advise(search, known),
        list_shifts(search.told), seed, explained=search.selection.explained, ended=search.ended,
        refuted=tuple(refuted), unsearched=tuple(unsearched), screened=list_screened(search.screened.scores),
    )  # fmt: skip


def _is_late(budget: TimeBudget, ended: str) -> bool:
    """Whether how far a machine holds is to be found briefly."""
    return bool(ended) or budget.is_searched()


def _find_coarse(search: Search, refuted: Sequence[str]) -> Finding | None:
    """Lumps that the machine as written has too few of."""
    gain = gain_of_lumps(search.written, search.null, search.best)
    if gain <= search.threshold or not (is_finer(search) or _is_untaken(search, refuted)):
        return None
    finest = search.best.root if is_finer(search) else search.null.root
    return find_lumping(search.written, finest, gain, search.threshold)


def _is_untaken(search: Search, refuted: Sequence[str]) -> bool:
    """Whether lumps alone leave nothing, but were taken back, as simulated runs speak against them: what switches falls
    out of step with them."""
    null = search.null
    if search.fault is not None or null.machine.lumps <= search.written.machine.lumps:
        return False
    return bool(refuted) and not search.best.found and null.chi <= SETTINGS.noise and has_relays(null.machine)


def _weigh_findings(search: Search, findings: Sequence[Finding], fits: Fits, is_refuted: bool) -> list[Finding]:
    """Each thing once, as sure as what is left lets it be; nothing is sure where the search was ended."""
    doubt, much_left = doubt_unseen(fits), doubt_fitted(fits)
    doubted = [f.doubted(doubt).doubted(much_left) for f in _share_belief(findings)]
    told = join_rests(withhold_names(join_alike(doubted)), partial(list_read, search.best.machine))
    told = [f.doubted(WITHDRAWN) if is_refuted and f.kind == UNKNOWN else f for f in told]
    return [replace(f, confidence=min(f.confidence, SETTINGS.half)) for f in told] if search.ended else told


def _share_belief(findings: Sequence[Finding]) -> list[Finding]:
    """What has no name is believed in as far as names beside it do not hold, and no less than half."""
    holds = [f.holds for f in findings if f.holds is not None]
    if not holds or not any(f.is_unnamed for f in findings):
        return [*findings]
    nameless = max(1 - holds[0], SETTINGS.half)
    return [f.weigh(nameless if f.is_unnamed else 1 - nameless) for f in findings]


def _are_sensors(findings: Sequence[Finding]) -> bool:
    """Whether all that is told, but for lumps, are faults of channels with a name."""
    told = [f for f in findings if not f.is_cut]
    return bool(told) and all(f.channels and not f.is_unnamed for f in told)


def _list_tried(search: Search, findings: Sequence[Finding]) -> set[str]:
    """The kinds of which something was fitted, and those that are told."""
    return {h.found[-1].kind.kind for ranked in search.steps for h in ranked} | {f.kind for f in findings}


def _tell_runs(search: Search, before: SimulatedRuns, findings: Sequence[Finding], fits: Fits) -> Iterator[str]:
    """What is said of runs that were held out."""
    if not findings and doubt_unseen(fits):
        yield from tell_unseen(fits)
    yield from tell_corrections(search, before.held, fits)


def _advise(search: Search, known: Isolability) -> tuple[Experiment, ...]:
    """What to record next, once a search has come to its end, on inputs that the file has."""
    can_advise = not search.ended and {*search.case.machine.inputs} <= {*search.given.machine.inputs}
    return tuple(experiments(search, known.unseen)) if can_advise else ()


def _channels(fits: Fits) -> Mapping[str, float]:
    """Channels by how far they were off before, the worst first."""
    told: dict[str, float] = fits.summary()["train"]["before"]["channels"]
    return dict(sorted(told.items(), key=lambda pair: -pair[1]))
