"""What a diagnosis names, and what a key conceals: kinds and places of both, and which belong together."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

Groups = Sequence[Sequence[str]]
"""Groups of places: a right answer names one of each."""
UNKNOWN = "unknown"
BETWEEN = re.compile(r"\s*[,|+/]\s*|\s+[–-]\s+")
"""What stands between the places of one member of a set."""


@dataclass(frozen=True)
class Member:
    """One of the explanations that a finding cannot tell apart; no names where it does not say where."""

    kind: str
    names: frozenset[str] = frozenset()

    @classmethod
    def read(cls, told: str | Mapping[str, Any]) -> Member:
        """From `kind@place`, `kind`, or a mapping with kind, places and channels."""
        if not isinstance(told, str):
            return cls(str(told["kind"]), bare([*(told.get("places") or ()), *(told.get("channels") or ())]))
        kind, _, places = told.partition("@")
        return cls(kind.strip(), bare(BETWEEN.split(places)) if places else frozenset())

    def is_at(self, groups: Groups) -> bool:
        """It names one of each group, or as many as it names at all."""
        hits = sum(not self.names.isdisjoint(group) for group in groups)
        return hits >= min(len(groups), len(self.names))


def bare(places: Iterable[str]) -> frozenset[str]:
    """Names without what follows the @."""
    return frozenset(name for place in places if (name := place.partition("@")[0].strip()))


@dataclass(frozen=True)
class Finding:
    """A finding: its own kind, the bare names of its places and channels, and the set that it cannot tell apart."""

    kind: str
    names: frozenset[str]
    confidence: float
    members: frozenset[Member] = field(default=frozenset())
    is_part: bool = False

    @classmethod
    def read(cls, told: Mapping[str, Any]) -> Finding:
        own = Member.read({"channels": (), "places": (), **told, "kind": str(told.get("kind"))})
        members = [Member.read(each) for each in told.get("set") or ()]
        members = members or [own, *(Member.read(each) for each in told.get("indistinguishable") or ())]
        confidence = float(told.get("confidence") or 0)
        return cls(own.kind, own.names, confidence, frozenset(members), told.get("part") == "part")

    def is_at(self, groups: Groups) -> bool:
        """It names one of each group; what is unknown has one place, and that is enough."""
        there = any if self.kind == UNKNOWN else all
        return there(not self.names.isdisjoint(group) for group in groups)


@dataclass(frozen=True)
class Concealed:
    """One effect: kinds that are right, groups of places, and kinds that would be a part of the truth."""

    kinds: Sequence[str]
    places: Groups
    near: Sequence[str] = ()

    def is_named(self, finding: Finding) -> bool:
        """By the finding's own kind alone."""
        return finding.kind in self.kinds

    def is_placed(self, finding: Finding) -> bool:
        return finding.is_at(self.places)

    def is_met(self, finding: Finding) -> bool:
        return self.is_named(finding) and self.is_placed(finding)

    def is_covered(self, finding: Finding) -> bool:
        """The truth is in the finding's set."""
        return any(member.kind in self.kinds and member.is_at(self.places) for member in finding.members)

    def is_neared(self, finding: Finding) -> bool:
        return finding.kind in self.near


def concealed_in(key: Mapping[str, Any]) -> list[Concealed]:
    near = [*(key.get("near") or ()), *([()] * len(key["kinds"]))]
    return [Concealed(*each) for each in zip(key["kinds"], key["places"], near, strict=False)]


def met(
    effects: Sequence[Concealed], findings: Sequence[Finding], fits: Callable[[Concealed, Finding], bool]
) -> int:  # fmt: skip
    """How many effects have a finding of their own that fits them, at the most."""
    if not effects or not findings:
        return 0
    first, *rest = effects
    ways = [met(rest, findings, fits)]
    for i, finding in enumerate(findings):
        if fits(first, finding):
            ways.append(1 + met(rest, [*findings[:i], *findings[i + 1 :]], fits))
    return max(ways)
