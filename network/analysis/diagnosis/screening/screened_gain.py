"""What each kind at each place would explain by itself, by the linear score of the screening: the map of gains."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from network.analysis.diagnosis.screening.screen import SHOWS, Score


@dataclass(frozen=True)
class ScreenedGain:
    """gain: log evidence [nats] that a kind at some places or channels would add at most, all numbers refitted along
    their slopes, what is left counted as noise."""

    kind: str
    places: tuple[str, ...]
    channels: tuple[str, ...]
    gain: float

    @property
    def seats(self) -> tuple[str, ...]:
        return self.places or self.channels

    def summary(self) -> dict[str, Any]:
        return {"kind": self.kind, "places": list(self.places), "channels": list(self.channels), "gain": self.gain}


def list_screened(scores: Iterable[Score]) -> tuple[ScreenedGain, ...]:
    """Those that show, the best of each kind and place; scores: the best first, as those told are."""
    told: dict[tuple[str, tuple[str, ...]], ScreenedGain] = {}
    for s in scores:
        c = s.candidate
        of = ScreenedGain(c.kind.kind, c.places, c.channels, float(s.gain))
        if s.gain > SHOWS:
            told.setdefault((of.kind, of.seats), of)
    return tuple(told.values())
