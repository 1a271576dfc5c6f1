"""What chance gains: the largest evidence that noise alone gives any candidate, from draws of the null.

Under the null the whitened residual is normal with covariance M (parameters taken out), so the score of a candidate is
z = dᵀMε/√(dᵀMd), and chance reaches max over candidates of z²/2 (of z > 0 where a strength cannot be negative); its
99 % point over many draws is what a finding must exceed, with room for shapes that are chosen as well. Source:
parametric bootstrap of the maximum score, Davies, Biometrika 74 (1987) 33; unverified.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from network.analysis.diagnosis.screening.screen import Score
from network.analysis.diagnosis.settings import SETTINGS

DRAWS = 2000


def null_threshold(scores: Sequence[Score], seed: int) -> float:
    """The gain in log evidence that chance does not reach, from the scores of all candidates about the null. Instants
    have a price of their own."""
    if not scores:
        return SETTINGS.least
    lean = np.stack([s.lean / s.detectable for s in scores])
    rng = np.random.default_rng(seed)
    z = lean @ rng.standard_normal((lean.shape[1], DRAWS))
    is_signed = np.array([s.candidate.is_signed for s in scores])[:, None]
    chance = float(
        np.quantile(np.where(is_signed, np.abs(z), np.maximum(z, 0.0)).max(axis=0) ** 2 / 2, SETTINGS.quantile)
    )
    shapes = max(sum(not p.field.is_instant for p in s.candidate.own) for s in scores) - 1
    return max(SETTINGS.least, chance + SETTINGS.per_shape * shapes)
