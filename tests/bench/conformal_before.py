"""Beliefs of an answer that was written before answers carried them, from what it tells of its rivals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from network.analysis.diagnosis.conformal import Explanation
from network.analysis.diagnosis.finding import UNKNOWN, Finding, Rival
from network.analysis.diagnosis.ranking import belief_in_nothing
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.patch import Patch

UNTESTED, ALONE = "it was not tested to the end", "that alone explains more"


def explanations_before(told: Mapping[str, Any], finding: Mapping[str, Any]) -> tuple[Explanation, ...]:
    """Of a finding: what its rivals have not is its own share."""
    alternatives, alike = (tuple(map(rival_of, finding[key])) for key in ("alternatives", "indistinguishable"))
    others = {(r.kind, r.places, r.channels): r.confidence for r in (*alternatives, *alike)}
    is_unknown, is_first = finding["kind"] == UNKNOWN, finding is told["findings"][0]
    share = probability(told, finding) if is_unknown else min(max(1 - sum(others.values()), 0.0), 1.0)
    gain = (finding.get("evidence") or {}).get("delta_log_evidence")
    nothing = belief_in_nothing(math.inf if gain is None else gain, told["left"]["rmse_in_noise"]["train"])
    of = Finding(
        finding["kind"], finding["section"], tuple(finding["places"]), tuple(finding["channels"]),
        finding["confidence"], finding["parameters"], "", Patch({}), 0.0, 0.0, (), alternatives, alike, share=share,
        holds=holds(told, finding, bool(others)), nothing=nothing if is_first else None,
    )  # fmt: skip
    return tuple(of.explanations)


def rival_of(told: Mapping[str, Any]) -> Rival:
    return Rival(told["kind"], tuple(told["places"]), tuple(told["channels"]), told["confidence"], 1.0, 0.0, "")


def probability(told: Mapping[str, Any], finding: Mapping[str, Any]) -> float:
    """Of the place of what has no name, not capped by doubts where the map has it."""
    name = " to ".join(finding["places"])
    nodes = {node["name"]: node["probability"] for node in told["located"]["nodes"]}
    return float(max(finding["confidence"], nodes.get(name, 0.0)))


def holds(told: Mapping[str, Any], finding: Mapping[str, Any], has_rivals: bool) -> float | None:
    """Belief that it is among what was named; None of a fault of readings, which was not weighed against names."""
    if finding["channels"] and not has_rivals:
        return None
    explained = float(told["left"]["share_explained"])
    nameless = [f for f in told["findings"] if f["kind"] == UNKNOWN]
    if nameless and len(nameless) == sum(bool(f["parameters"]) for f in told["findings"]):
        return 1.0
    least = SETTINGS.half if any(ALONE in f["sentence"] for f in nameless) else 0.0
    if finding["kind"] == UNKNOWN:
        return max(1 - explained, least)
    return min(1.0 if UNTESTED in (finding.get("doubts") or ()) else explained, 1 - least)
