"""One case judged: what diagnosis.json says, laid beside the opened key."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any

INNOCENT = ("adequate", "parameters_only", "too_coarse")
"""Verdicts that accuse nobody."""
LUMPING = "lumping"
"""A finding that adds cells, not physics: never an accusation, never an answer."""
SURE = 0.9
MOST = 6
"""Findings of a case that are looked at."""

Groups = Sequence[Sequence[str]]


@dataclass(frozen=True)
class Finding:
    """A finding of a diagnosis: kinds that it names or cannot tell apart, bare names of its places and channels."""

    kind: str
    kinds: frozenset[str]
    names: frozenset[str]
    confidence: float

    @classmethod
    def read(cls, told: Mapping[str, Any]) -> Finding:
        alike = [other if isinstance(other, str) else other["kind"] for other in told.get("indistinguishable") or ()]
        names = {name.partition("@")[0] for name in [*(told.get("places") or ()), *(told.get("channels") or ())]}
        kind, confidence = str(told.get("kind")), float(told.get("confidence") or 0)
        return cls(kind, frozenset([kind, *alike]), frozenset(names), confidence)

    def is_a(self, kinds: Sequence[str]) -> bool:
        return not self.kinds.isdisjoint(kinds)

    def is_at(self, groups: Groups) -> bool:
        """It names one of each group."""
        return all(not self.names.isdisjoint(group) for group in groups)


@dataclass(frozen=True)
class Concealed:
    """What a key holds: for each effect the kinds that would be right, and groups of places to name one of each."""

    kinds: Groups
    places: Sequence[Groups]

    def named(self, findings: Sequence[Finding]) -> bool:
        """Every effect has a finding of its own that names it."""
        return any(
            all(finding.is_a(kinds) for finding, kinds in zip(some, self.kinds, strict=True))
            for some in permutations(findings, len(self.kinds))
        )

    def placed(self, findings: Sequence[Finding]) -> bool:
        """Every effect has a finding at its place, whatever it is called."""
        return all(any(finding.is_at(groups) for finding in findings) for groups in self.places)

    def both(self, findings: Sequence[Finding]) -> bool:
        """Every effect has a finding of its own with the right name at the right place."""
        pairs = list(zip(self.kinds, self.places, strict=True))
        return any(
            all(finding.is_a(kinds) and finding.is_at(at) for finding, (kinds, at) in zip(some, pairs, strict=True))
            for some in permutations(findings, len(pairs))
        )

    def knows(self, finding: Finding) -> bool:
        return any(finding.is_a(kinds) for kinds in self.kinds)


@dataclass(frozen=True)
class Judgement:
    """How a case went; `accused` is for machines with nothing concealed, named to both for the others."""

    case: str
    layout: str
    truth: str
    what: str
    expected: str
    visible: float
    answer: str = "no answer"
    verdict: str = ""
    named: bool = False
    placed: bool = False
    both: bool = False
    first: bool = False
    accused: bool = False
    spurious: int = 0
    confidence: float | None = None
    before: float | None = None
    after: float | None = None
    seconds: float | None = None

    @property
    def answered(self) -> bool:
        return bool(self.verdict)

    @property
    def innocent(self) -> bool:
        """Nothing was concealed."""
        return not self.expected

    @property
    def outside(self) -> bool:
        return self.expected == "unknown"

    @property
    def sure_and_wrong(self) -> bool:
        return (self.confidence or 0) > SURE and (self.accused if self.innocent else not self.first)

    @property
    def removed(self) -> float | None:
        """Share of the held-out excess over the noise that went away: (before − after)/(before − 1)."""
        if self.before is None or self.after is None or self.before <= 1.02:
            return None
        return (self.before - self.after) / (self.before - 1)

    @property
    def worse(self) -> bool:
        """The held-out recording is predicted worse than before, by more than 2 %."""
        return self.before is not None and self.after is not None and self.after > 1.02 * self.before


def judge(case: str, key: Mapping[str, Any], told: Mapping[str, Any] | None, seconds: float | None = None) -> Judgement:
    """Lays a diagnosis beside the key; None is a diagnosis that did not come."""
    about = {"case": case, "layout": key["layout"], "truth": key["truth"], "what": key["class"]}
    about["expected"] = " + ".join(kinds[0] for kinds in key["kinds"])
    numbers: dict[str, Any] = {"visible": float(key["in_noise"]["after_calibration"]), "seconds": seconds}
    if told is None:
        return Judgement(**about, **numbers)
    findings = [Finding.read(each) for each in told.get("findings") or ()][:MOST]
    physics = [finding for finding in findings if finding.kind != LUMPING]
    numbers |= held_out(told) | {"seconds": told.get("seconds") if seconds is None else seconds}
    numbers["confidence"] = physics[0].confidence if physics else None
    answer = " + ".join(finding.kind for finding in physics) or told["verdict"]
    judged = judged_findings(Concealed(key["kinds"], key["places"]), told, physics)
    return Judgement(**about, **numbers, answer=answer, verdict=told["verdict"], **judged)


def judged_findings(concealed: Concealed, told: Mapping[str, Any], physics: Sequence[Finding]) -> dict[str, Any]:
    """Names, places and accusations, by what the key conceals: nothing, something outside, or effects."""
    if not concealed.kinds:
        return {"accused": bool(physics) or told["verdict"] not in INNOCENT}
    if concealed.kinds[0][0] == "unknown":
        return judged_outside(concealed, told, physics)
    named = {"named": concealed.named(physics), "placed": concealed.placed(physics), "both": concealed.both(physics)}
    first = bool(physics) and concealed.knows(physics[0])
    return {**named, "first": first, "spurious": sum(not concealed.knows(finding) for finding in physics)}


def judged_outside(concealed: Concealed, told: Mapping[str, Any], physics: Sequence[Finding]) -> dict[str, Any]:
    """Right is `unexplained`, or a finding `unknown`; its place, else the first node that `located` names."""
    unknown = [finding for finding in physics if finding.is_a(["unknown"])]
    named = told["verdict"] == "unexplained" or bool(unknown)
    suspects = (told.get("located") or {}).get("nodes") or ()
    likeliest = frozenset(node["name"].partition("@")[0] for node in suspects[:1])
    placed = concealed.placed(unknown or [Finding("unknown", frozenset(), likeliest, 0.0)])
    first = named and (not physics or physics[0] in unknown)
    return {"named": named, "placed": placed, "both": named and placed, "first": first,
            "spurious": len(physics) - len(unknown)}  # fmt: skip


def held_out(told: Mapping[str, Any]) -> dict[str, float | None]:
    """Residual of the held-out recording in units of noise, before and after."""
    fit = (told.get("fit") or {}).get("holdout") or {}
    return {when: (fit.get(when) or {}).get("rmse_in_noise") for when in ("before", "after")}
