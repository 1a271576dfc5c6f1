"""One piece of what is missing, with its numbers and its rivals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from network.analysis.diagnosis.findings.conformal import (
    EFFECT,
    NOTHING,
    NULL,
    OUTSIDE,
    SENSOR,
    Explanation,
    choose,
    shipped,
)
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.lumps.lump_sentences import cuts_only, lump_sentence
from network.analysis.diagnosis.screening.crossed_splits import UnseenTest
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.patch import Patch
from network.catalogue.suspects.input_fault import InputFault

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
    [s] of recording `run` in which the residual differed most before; patch: what adds it to the machine, numbers as
    fitted; share: of the evidence, among its rivals; holds: belief that it is one of these and not what has no name;
    nothing: belief that nothing is missing, None where that is not asked."""

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
    share: float | None = None
    holds: float | None = None
    nothing: float | None = None
    run: int = 0

    @property
    def part(self) -> str:
        """Whether it is all that was missing or a part of the truth."""
        return "part" if self.doubts or self.kind == UNKNOWN else "whole"

    @property
    def is_room(self) -> bool:
        """Whether it is surroundings that are not what is given for them, for which no number of a file can stand."""
        return self.course is not None and self.course.is_room

    @property
    def is_stop(self) -> bool:
        """Whether it is of what drives the machine, which stood while recordings say otherwise, and of no sensor."""
        return self.kind == InputFault.kind

    @property
    def is_unnamed(self) -> bool:
        """Whether it is what heat, or surroundings, would have to be, without a cause."""
        return self.kind == UNKNOWN or self.is_room

    @property
    def is_withheld(self) -> bool:
        """Whether it is in the machine by a name that is less likely than not."""
        return self.kind == UNKNOWN and bool(self.patch)

    def sits_with(self, other: Finding) -> bool:
        """Whether both are of the same channels or, where they are of none, of the same places."""
        return self.channels == other.channels and (bool(self.channels) or self.places == other.places)

    def doubted(self, why: str) -> Finding:
        """With a further doubt, where there is one: then it is not sure."""
        if not why:
            return self
        return replace(self, confidence=min(self.confidence, SETTINGS.barred), doubts=(*self.doubts, why))

    def weigh(self, belief: float) -> Finding:
        """With a belief in it beside other findings; a fault of readings stays as sure as it is."""
        if self.is_unnamed:
            return replace(self, share=belief * (self.confidence if self.share is None else self.share))
        return self if self.holds is None else replace(self, holds=belief)

    @property
    def members(self) -> list[str]:
        """The explanations of which it is one, itself first, then the most likely first."""
        return choose(self.explanations, shipped())

    @property
    def truth(self) -> str:
        """The class of truth that it claims."""
        return NULL if self.is_cut else _class_of(self.kind, self.channels)

    @property
    def explanations(self) -> list[Explanation]:
        """Itself, then all else that it could be, the most likely first: beliefs are shares of the evidence, times that
        something with a name is missing."""
        some = 1 - (self.nothing or 0.0)
        named = some * (1.0 if self.holds is None else self.holds)
        own = self.confidence if self.share is None else self.share
        name = name_member(self.kind, self.places, self.channels)
        rest = {e.name: e for e in (*self._list_others(named), *self._list_nameless(some - named))}
        rest.pop(name, None)
        first = Explanation(name, self.truth, named * own, self.confidence)
        return [first, *sorted(rest.values(), key=lambda e: -e.belief)]

    def _list_others(self, named: float) -> Iterator[Explanation]:
        """What else has a name; what cannot be told from it last, so that it stands for itself."""
        for r in (*self.alternatives, *self.indistinguishable):
            name, is_tied = name_member(r.kind, r.places, r.channels), r in self.indistinguishable
            yield Explanation(name, _class_of(r.kind, r.channels), named * r.confidence, r.confidence, is_tied)

    def _list_nameless(self, left: float) -> Iterator[Explanation]:
        """Something in its place that the catalogue does not have, and nothing at all."""
        if self.holds is not None:
            yield Explanation(name_member(UNKNOWN, self.places, self.channels), OUTSIDE, left)
        if self.nothing is not None:
            yield Explanation(NOTHING, NULL, self.nothing)

    def confidence_of(self, rival: Rival) -> float:
        """In another explanation, as its share of the evidence is to that of this one: what bars this one from being
        sure bars that, too. As it is where it is no share of one evidence."""
        if self.holds is None or not self.share:
            return rival.confidence
        return rival.confidence * min(1.0, self.confidence / self.share)

    def as_told(self, rival: Rival) -> Rival:
        return replace(rival, confidence=self.confidence_of(rival))

    @property
    def is_cut(self) -> bool:
        """Whether it does nothing but cut parts more finely."""
        return not self.parameters and cuts_only(self.patch)

    @property
    def whole_sentence(self) -> str:
        """As it was found; where its patch does nothing but cut parts more finely, every part of the patch."""
        return lump_sentence(self.patch["nodes"]) if self.is_cut else self.sentence

    def summary(self) -> dict[str, Any]:
        return {
            "kind": self.kind, "section": self.section, "places": list(self.places), "channels": list(self.channels),
            "confidence": self.confidence, "parameters": {n: q.summary() for n, q in self.parameters.items()},
            "alternatives": [self.as_told(r).summary() for r in self.alternatives],
            "indistinguishable": [self.as_told(r).summary() for r in self.indistinguishable],
            "sentence": self.whole_sentence, "patch": self.patch.to_plain(),
            "evidence": {"delta_log_evidence": self.gain, "threshold": self.threshold,
                         "windows": [list(w) for w in self.windows], **(self.unseen.summary() if self.unseen else {})},
            "run": self.run, "part": self.part, "doubts": list(self.doubts), "set": self.members,
            "beliefs": [e.summary() for e in self.explanations], "calibrated_on": shipped().count(self.truth),
            **({"course": self.course.list_courses()} if self.course else {}),
        }  # fmt: skip


def _class_of(kind: str, channels: Sequence[str]) -> str:
    return OUTSIDE if kind == UNKNOWN else SENSOR if channels else EFFECT


def name_member(kind: str, places: Sequence[str], channels: Sequence[str]) -> str:
    """kind@place, kind@place|place, or kind@channel."""
    return f"{kind}@{'|'.join(channels or places)}"
