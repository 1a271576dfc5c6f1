"""One piece of what is missing, with its numbers and its rivals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from network.analysis.diagnosis.crossed_splits import UnseenTest
from network.analysis.diagnosis.located_heat import UnknownHeat
from network.analysis.diagnosis.lump_sentences import cuts_only, lump_sentence
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.patch import Patch

UNKNOWN = "unknown"
"""The kind of a finding that no kind of the catalogue explains."""


@dataclass(frozen=True)
class Quantity:
    """A number of a finding, SI; unit: as it is shown; std: 0 where it was not free."""

    value: float
    std: float
    unit: str

    def summary(self) -> dict[str, Any]:
        from network.platform.quantities.units import difference, unit

        of = unit(self.unit)
        shown = difference(of) if self.unit == "K" else of
        return {"value": shown.from_si(self.value), "std": self.std / difference(of).scale, "unit": self.unit}


@dataclass(frozen=True)
class Rival:
    """Another explanation that was fitted. chi: rms residual it leaves, in noise; gain: log evidence over nothing
    missing [nats]; why_not: what speaks against it, as a sentence."""

    kind: str
    places: tuple[str, ...]
    channels: tuple[str, ...]
    confidence: float
    chi: float
    gain: float
    why_not: str

    def summary(self) -> dict[str, Any]:
        return {"kind": self.kind, "places": list(self.places), "channels": list(self.channels),
                "confidence": self.confidence}  # fmt: skip


@dataclass(frozen=True)
class Finding:
    """One piece of missing physics. gain: log evidence it adds [nats]; threshold: what chance reaches; windows: times
    [s] in which the residual differed most before; patch: what adds it to the machine, numbers as fitted."""

    kind: str
    section: str
    places: tuple[str, ...]
    channels: tuple[str, ...]
    confidence: float
    parameters: Mapping[str, Quantity]
    sentence: str
    patch: Patch
    gain: float
    threshold: float
    windows: tuple[tuple[float, float], ...] = ()
    alternatives: tuple[Rival, ...] = ()
    indistinguishable: tuple[Rival, ...] = ()
    doubts: tuple[str, ...] = ()
    course: UnknownHeat | None = None
    unseen: UnseenTest | None = None

    @property
    def part(self) -> str:
        """Whether it is all that was missing or a part of the truth."""
        return "part" if self.doubts or self.kind == UNKNOWN else "whole"

    @property
    def is_room(self) -> bool:
        """Whether it is surroundings that are not what is given for them, for which no number of a file can stand."""
        return self.course is not None and self.course.is_room

    @property
    def members(self) -> list[str]:
        """The explanations of which it is one, with SETTINGS.covered of the belief, the most likely first."""
        told, belief = [name_member(self.kind, self.places, self.channels)], self.confidence
        rest = sorted((*self.indistinguishable, *self.alternatives), key=lambda r: -r.confidence)
        for r in rest:
            name = name_member(r.kind, r.places, r.channels)
            if (belief < SETTINGS.covered or r in self.indistinguishable) and name not in told:
                told.append(name)
                belief += r.confidence
        return told

    @property
    def whole_sentence(self) -> str:
        """As it was found; where its patch does nothing but cut parts more finely, every part of the patch."""
        only_lumps = not self.parameters and cuts_only(self.patch)
        return lump_sentence(self.patch["nodes"]) if only_lumps else self.sentence

    def summary(self) -> dict[str, Any]:
        return {
            "kind": self.kind, "section": self.section, "places": list(self.places), "channels": list(self.channels),
            "confidence": self.confidence, "parameters": {n: q.summary() for n, q in self.parameters.items()},
            "alternatives": [r.summary() for r in self.alternatives],
            "indistinguishable": [r.summary() for r in self.indistinguishable],
            "sentence": self.whole_sentence, "patch": self.patch.to_plain(),
            "evidence": {"delta_log_evidence": self.gain, "threshold": self.threshold,
                         "windows": [list(w) for w in self.windows], **(self.unseen.summary() if self.unseen else {})},
            "part": self.part, "doubts": list(self.doubts), "set": self.members,
            **({"course": self.course.list_courses()} if self.course else {}),
        }  # fmt: skip


def name_member(kind: str, places: Sequence[str], channels: Sequence[str]) -> str:
    """kind@place, or kind@place|place."""
    return f"{kind}@{'|'.join((*places, *channels))}"
