"""How explanations that were fitted beside each other rank: one of each kind and place, with its share of belief."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Array


def best_first(*rivals: Hypothesis) -> list[Hypothesis]:
    """By their evidence."""
    return sorted(rivals, key=lambda h: -h.evidence)


def by_weight(rivals: Sequence[Hypothesis]) -> list[Hypothesis]:
    """By their evidence, with heat of any course beside those that were weighed so."""
    return sorted(rivals, key=lambda h: -h.weighed)


def best_of(*fits: Hypothesis | None) -> Hypothesis | None:
    """The one with most evidence, of those that came to an end."""
    return max((h for h in fits if h is not None), key=lambda h: h.evidence, default=None)


def distinct(ranked: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The best of each kind and place."""
    seen: dict[tuple[object, ...], Hypothesis] = {}
    for h in ranked:
        seen.setdefault((h.found[-1].kind.kind, frozenset(h.found[-1].places), h.found[-1].channels), h)
    return list(seen.values())


def lead_rivals(lead: Hypothesis, weighed: float, ranked: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Rivals behind one that comes before them with some log evidence, in its own stead where it is among them."""
    return [replace(lead, beside=weighed), *leave_out([lead], ranked)]


def leave_out(others: Sequence[Hypothesis], ranked: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Rivals but for those that end in the finding of one of others."""
    keys = {h.found[-1].key for h in others}
    return [h for h in ranked if h.found[-1].key not in keys]


def weigh_on_lumps(
    ranked: Sequence[Hypothesis], tried: Sequence[Hypothesis], fitted: Sequence[Hypothesis | None]
) -> list[Hypothesis]:
    """Rivals, those that were tried on finer lumps among them, weighed by what these changed in each beside the first;
    fitted: those there, None where one does not fit."""
    told = [(h, there) for h, there in zip(tried, fitted, strict=True) if there is not None]
    if len(told) < 2:
        return [*ranked]
    changes = [there.evidence - h.evidence for h, there in told]
    weighed = [replace(h, beside=h.weighed + x - changes[0]) for (h, _), x in zip(told, changes, strict=True)]
    return by_weight([*weighed, *leave_out(weighed, ranked)])


def shares(of: Sequence[Hypothesis]) -> Array:
    """Their shares of the evidence, softened; they add up to 1. The first was kept: where another is before it by this
    evidence, it was behind on finer lumps, and counts as much."""
    gains = np.minimum([h.weighed for h in of], of[0].weighed)
    share = np.exp((gains - gains.max()) / (SETTINGS.softening * max(1.0, of[0].chi) ** 2))
    return np.asarray(share / share.sum())


def share_of(ranked: Sequence[Hypothesis], key: tuple[str, ...]) -> float:
    """That of one among its rivals; that of what is not sure where it was not fitted beside them."""
    apart = distinct(ranked)
    told = {h.found[-1].key: float(p) for h, p in zip(apart, shares(apart), strict=True)}
    return told.get(key, SETTINGS.barred)


def belief_in_nothing(gain: float, chi: float = 1.0) -> float:
    """That chance alone gained so much evidence [nats], softened the same way: 1/(1 + e^(gain/T)); chi: the misfit
    left, where the gain does not count it yet."""
    return float(expit(-gain / (SETTINGS.softening * max(1.0, chi) ** 2)))
