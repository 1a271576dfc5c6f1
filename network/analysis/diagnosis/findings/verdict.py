"""What a search came to, in a word, and the findings that are told of it, in their order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from network.analysis.calibration.gauss_newton import chi_of
from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding
from network.analysis.diagnosis.findings.findings import is_shadow
from network.analysis.diagnosis.findings.simulated_findings import is_finer
from network.analysis.diagnosis.findings.unnamed_findings import find_unknown, list_read
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.lumps.lump_shortfall import lacks_what_is_left
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.refit import linearise_at_priors
from network.analysis.diagnosis.steps.selection import Selection
from network.machine.machine import Machine

if TYPE_CHECKING:
    from network.analysis.diagnosis.search_record import Search


def decide_verdict(
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
    if (coarse and not is_finer(search)) or (is_left and _may_be_lumps(search, jobs)):
        return cut, "too_coarse"
    if is_left or (is_refuted and best.chi > SETTINGS.adequate and _stands_out(search)):
        unknown = find_unknown(search)
        return [*cut, unknown], "unexplained" if unknown.kind == UNKNOWN else "missing_physics"
    if coarse:
        return cut, "too_coarse"
    wrong = any(abs(x) > SETTINGS.shift for x in list_shifts(best).values()) or _was_off(search)
    return [], "parameters_only" if wrong else "adequate"


def find_beside(whole: Search, search: Search, findings: Sequence[Finding], jobs: int) -> list[Finding]:
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
    """Whether the time was up before lumps were found that do not lack as much as is left; what all bars lack a little
    of is not heat in one part alone."""
    if search.ended != "budget" or _is_in_one_part(search.located[0]):
        return False
    return lacks_what_is_left(search.best, jobs)


def _is_in_one_part(first: UnknownHeat) -> bool:
    return first.at.kind == "node" and first.probability > SETTINGS.most_sure


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
    read = {*list_read(machine, faulty)}
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


def list_shifts(h: Hypothesis) -> dict[str, float]:
    """How far the numbers of the file moved, in prior σ, the farthest first."""
    own = {p.path for p in h.own}
    names = [p.path for p in h.fit.problem.parameters if p.path not in own]
    return dict(sorted(zip(names, h.shift.tolist(), strict=True), key=lambda pair: -abs(pair[1])))
