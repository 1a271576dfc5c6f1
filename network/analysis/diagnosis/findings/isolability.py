"""What these recordings could not have shown, whatever their readings: told before any residual is looked at.

About the null a candidate of its usual size moves the channels by d; what the parameters do not take up of it is M d,
and √(dᵀMd) is how clearly it would show (σ). Two whose M d point one way, cosine above SAME, are one to these sensors
and schedules. Strengths are positive, so the opposite way is another one. Source: fault detectability and isolability,
Krysander & Frisk, IEEE Trans. SMC A 38 (2008) 1398; unverified.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.experiments.experiment import CLEAR
from network.analysis.diagnosis.screening.screen import Score
from network.catalogue.declaration.declare import Array
from network.platform.wording import name_of, sentence

SAME = 0.95
"""Cosine from which two candidates are one."""
SHOWN = 4
"""Kinds, or sets of kinds, that are named."""
DETAILS = "In detail:"
"""What stands before what only a report has room for."""


@dataclass(frozen=True)
class Isolability:
    """looked_at: how many candidates; unseen: those that would not show; classes: those that would show, but not which
    of them it is, the clearest first."""

    looked_at: int
    unseen: tuple[Candidate, ...]
    classes: tuple[tuple[Candidate, ...], ...]

    @property
    def sentence(self) -> str:
        """What that means for a verdict, in one line, then in detail; empty where all would show and be told apart."""
        if not (self.unseen or self.classes):
            return ""
        parts = [part for part in (self._unseen, self._alike) if part]
        return f"{sentence(', and '.join(parts))}. {DETAILS} {'; '.join(self._details())}."

    @property
    def _unseen(self) -> str:
        count = len(self.unseen)
        return f"{count} of {self.looked_at} possible effects {_be(count)} too small to show here" if count else ""

    @property
    def _alike(self) -> str:
        count = len(self.classes)
        groups = f"{count} group{'s' * (count > 1)} of {'others' if self.unseen else 'possible effects'}"
        return f"{groups} look{'s' * (count == 1)} alike" if count else ""

    def _details(self) -> Iterator[str]:
        if self.unseen:
            yield f"too small at their usual size: {count_kinds([(c,) for c in self.unseen])}"
        if self.classes:
            yield f"alike: {count_kinds(self.classes)}"


def _be(count: int) -> str:
    return "is" if count == 1 else "are"


def count_kinds(groups: Iterable[Sequence[Candidate]]) -> str:
    """The kinds in each group, the most frequent first, with how often."""
    counts = Counter(_kinds(group) for group in groups).most_common()
    rest = sum(count for _, count in counts[SHOWN:])
    told = [f"{kinds} ({count})" for kinds, count in counts[:SHOWN]]
    return ", ".join([*told, *([f"others ({rest})"] if rest else [])])


def _kinds(group: Sequence[Candidate]) -> str:
    kinds = sorted({name_of(c.kind.kind) for c in group})
    return f"{kinds[0]} at several places" if len(kinds) == 1 < len(group) else " or ".join(kinds)


def name_candidate(c: Candidate) -> str:
    """Kind and places, as a reader says it."""
    return name_of(c.kind.kind) + c.name.removeprefix(c.kind.kind)


def isolability(scores: Sequence[Score], proposed: Sequence[Candidate] = ()) -> Isolability:
    """From the screening about the null. proposed: all that was to be screened; what has no score moves no channel."""
    have = {s.candidate.key for s in scores}
    silent = [c for c in proposed if not (c.key in have or c.is_structural or c.switches)]
    shown = sorted((s for s in scores if s.detectable >= CLEAR), key=lambda s: -s.detectable)
    unseen = [s.candidate for s in scores if s.detectable < CLEAR]
    return Isolability(len(scores) + len(silent), (*unseen, *silent), tuple(_classes(shown)))


def _classes(shown: Sequence[Score]) -> Iterator[tuple[Candidate, ...]]:
    """Each candidate joins the clearest one that it is alike; those of one kind and place count once."""
    if not shown:
        return
    cosine = _cosines(np.stack([s.lean for s in shown]))
    left = np.ones(len(shown), bool)
    for i in range(len(shown)):
        if left[i]:
            own = left & (cosine[i] > SAME)
            left &= ~own
            group = {name_candidate(s.candidate): s.candidate for s, is_own in zip(shown, own, strict=True) if is_own}
            if len(group) > 1:
                yield tuple(group.values())


def _cosines(lean: Array) -> Array:
    unit = lean / np.linalg.norm(lean, axis=1, keepdims=True)
    return np.asarray(unit @ unit.T)
