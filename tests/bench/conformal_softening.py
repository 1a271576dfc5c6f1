"""The softening of beliefs that development cases would like best, by log loss."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from bench.conformal_cases import Told, Truth
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import logsumexp

from network.analysis.diagnosis.settings import SETTINGS

LEAST, MOST = 0.1, 1e4
"""Nats that are tried."""
FLOOR = 1e-300
"""Of a belief, which may be too small for a float."""

Shares = tuple[NDArray[np.float64], NDArray[np.bool_]]
"""Logarithms of the beliefs in names, and which of them are right."""


@dataclass(frozen=True)
class Softening:
    """nats: T with the least mean of −ln p(truth); loss_now: at the present one; count: truths; first: that came first
    among the names."""

    nats: float
    loss: float
    loss_now: float
    count: int
    first: int


def fit_softening(truths: Sequence[Truth]) -> Softening | None:
    """Over the truths that were named beside a rival, of which p ∝ e^(−behind/T): b^(T₀/T) of a belief b at T₀."""
    told = [shares for truth in truths if (shares := shares_of(truth.told)) is not None]
    if not told:
        return None
    span = (float(np.log(LEAST)), float(np.log(MOST)))
    best = minimize_scalar(lambda x: loss(told, float(np.exp(x))), bounds=span, method="bounded")
    first = sum(bool(right[np.argmax(logs)]) for logs, right in told)
    return Softening(float(np.exp(best.x)), float(best.fun), loss(told, SETTINGS.softening), len(told), first)


def shares_of(told: Told) -> Shares | None:
    """None where the truth is not among several names."""
    named = [(e.belief, hit) for e, hit in zip(told.explanations, told.hits, strict=True) if e.confidence is not None]
    beliefs, right = (np.array(column) for column in zip(*named, strict=True))
    if len(named) < 2 or not right.any() or not beliefs.any():
        return None
    return np.log(np.maximum(beliefs, FLOOR)), right.astype(bool)


def loss(told: Sequence[Shares], nats: float) -> float:
    """Mean of −ln p(truth) at a softening."""
    power = SETTINGS.softening / nats
    return float(np.mean([logsumexp(power * x) - logsumexp(power * x[right]) for x, right in told]))
