"""Beliefs of an answer that was written before answers carried them, from what it tells of its rivals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from network.analysis.diagnosis.findings.conformal import Explanation
from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding, Rival
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import belief_in_nothing
from network.catalogue.declaration.patch import Patch

UNTESTED, ROOM = "it was not tested to the end", "does not stay at what is given for it"


def explanations_before(told: Mapping[str, Any], finding: Mapping[str, Any]) -> tuple[Explanation, ...]:
    """Of a finding: what its rivals have not is its own share."""
    alternatives, alike = (tuple(map(rival_of, finding[key])) for key in ("alternatives", "indistinguishable"))
    others = {(r.kind, r.places, r.channels): r.confidence for r in (*alternatives, *alike)}
    share = min(max(1 - sum(others.values()), 0.0), 1.0)
    if is_unnamed(finding):
        share = probability(told, finding) * nameless(told)
    gain = (finding.get("evidence") or {}).get("delta_log_evidence")
    chi = 1.0 if is_unnamed(finding) else told["left"]["rmse_in_noise"]["train"]
    nothing = belief_in_nothing(math.inf if gain is None else gain, chi)
    of = Finding(
        finding["kind"], finding["section"], tuple(finding["places"]), tuple(finding["channels"]),
        finding["confidence"], finding["parameters"], "", Patch({}), 0.0, 0.0, (), alternatives, alike, share=share,
        holds=holds(told, finding), nothing=nothing if finding is told["findings"][0] else None,
    )  # fmt: skip
    return tuple(of.explanations)


def rival_of(told: Mapping[str, Any]) -> Rival:
    return Rival(told["kind"], tuple(told["places"]), tuple(told["channels"]), told["confidence"], 1.0, 0.0, "")


def probability(told: Mapping[str, Any], finding: Mapping[str, Any]) -> float:
    """Of the place of what has no name, not capped by doubts where the map has it."""
    name = " to ".join(finding["places"])
    places = [*told["located"]["nodes"], *(told["located"].get("surroundings") or ())]
    return float(max([finding["confidence"], *(p["probability"] for p in places if p["name"] == name)]))


def holds(told: Mapping[str, Any], finding: Mapping[str, Any]) -> float | None:
    """Belief that it is among what was named; None of a fault of readings, which was not weighed against names, and of
    what has none."""
    return None if is_unnamed(finding) or is_fault(finding) else 1 - nameless(told)


def nameless(told: Mapping[str, Any]) -> float:
    """Belief in what has no name: all where nothing else is told, none where runs that were left out were not asked."""
    named = [f for f in told["findings"] if f["parameters"] and not is_unnamed(f) and not is_fault(f)]
    if not named:
        return 1.0
    is_tested = not any(UNTESTED in (f.get("doubts") or ()) for f in named)
    least = SETTINGS.half if any(map(is_unnamed, told["findings"])) else 0.0
    return max(1 - float(told["left"]["share_explained"]) if is_tested else 0.0, least)


def is_fault(finding: Mapping[str, Any]) -> bool:
    """Of readings, found before names were weighed: nothing was fitted beside it."""
    return bool(finding["channels"]) and not (finding["alternatives"] or finding["indistinguishable"])


def is_unnamed(finding: Mapping[str, Any]) -> bool:
    return finding["kind"] == UNKNOWN or ROOM in finding["sentence"]
