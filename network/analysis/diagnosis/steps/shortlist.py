"""Candidates that are fitted: the best of several screenings, not all of one kind."""

from __future__ import annotations

from collections.abc import Sequence

from network.analysis.diagnosis.screening.screen import SHOWS, Score
from network.catalogue.declaration.sections import TCP

SHORTLIST, LONGER, OF_A_KIND, THAT_MOVE = 5, 14, 3, 7
"""Candidates refitted for each point they were screened about, where lumps are few and fits quick, how many of one
kind, and how many that move the tool centre point: whatever grows moves an axis alike, and would fill the list."""
WIDER = (20, 8, 20)
"""The same where the best of them leaves much: far from the fit the linear score of what is missing may be poor."""


def shortlist(
    scores: Sequence[Score], about_file: Sequence[Score], most: int = SHORTLIST, aside: Sequence[Score] = ()
) -> list[Score]:
    """The best of the screening about the fit (scores), about the file's own numbers, and about those that thermometers
    alone tell (aside)."""
    each = (s for of in (scores, about_file, aside) for s in limit_kinds(of, most, OF_A_KIND, THAT_MOVE))
    return list({s.candidate.key: s for s in reversed([*each])}.values())


def limit_kinds(scores: Sequence[Score], most: int, of_a_kind: int, that_move: int) -> list[Score]:
    """The best scores, at most so many of a kind and that move the tool centre point."""
    kept: list[Score] = []
    for s in scores:
        kinds = sum(k.candidate.kind is s.candidate.kind for k in kept)
        moving = sum(k.candidate.section == TCP for k in kept) if s.candidate.section == TCP else 0
        if s.gain > SHOWS and kinds < of_a_kind and moving < that_move:
            kept.append(s)
    return kept[:most]


def list_others(scores: Sequence[Score], than: Sequence[Score]) -> tuple[Score, ...]:
    """Scores of candidates that do not stand among some."""
    among = {s.candidate.key for s in than}
    return tuple(s for s in scores if s.candidate.key not in among)
