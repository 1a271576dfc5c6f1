"""How explanations that were fitted beside each other rank: one of each kind and place, with its share of belief."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from network.analysis.diagnosis.hypothesis import Hypothesis
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Array


def best_first(*rivals: Hypothesis) -> list[Hypothesis]:
    """By their evidence."""
    return sorted(rivals, key=lambda h: -h.evidence)


def distinct(ranked: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The best of each kind and place."""
    seen: dict[tuple[object, ...], Hypothesis] = {}
    for h in ranked:
        seen.setdefault((h.found[-1].kind.kind, frozenset(h.found[-1].places), h.found[-1].channels), h)
    return list(seen.values())


def shares(of: Sequence[Hypothesis]) -> Array:
    """Their shares of the evidence, softened; they add up to 1. The first was kept: where another is before it by this
    evidence, it was behind on finer lumps, and counts as much."""
    gains = np.minimum([h.evidence for h in of], of[0].evidence)
    share = np.exp((gains - gains.max()) / (SETTINGS.softening * max(1.0, of[0].chi) ** 2))
    return np.asarray(share / share.sum())
