"""How far a fit is off, in noise, and how much less its readings therefore tell.

χ is the rms of whitened residuals: 1 where the model is right and the noise as stated. Where the model is not right its
error lasts: n cells with a correlation ρ from one to the next tell as much as n (1 − ρ)/(1 + ρ) independent ones, so
that all of them together count as if the noise were χ √((1 + ρ)/(1 − ρ)) as large. Source: Bayley & Hammersley,
J. R. Statist. Soc. Suppl. 8 (1946) 184, for a first-order process; unverified.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from network.analysis.calibration.linearised import Linearised
from network.catalogue.declaration.declare import Array

CHANCE = 2.0
"""Standard errors of ρ of white noise that are taken off it."""


def chi_of(at: Linearised) -> float:
    """Rms of the whitened residual."""
    return float(np.sqrt(at.misfit / len(at.residual))) if len(at.residual) else 0.0


def lasting_misfit(at: Linearised) -> float:
    """χ √((1 + ρ)/(1 − ρ)), at least 1: the factor that the noise of the readings counts with."""
    return max(1.0, chi_of(at) * float(np.sqrt((1 + (rho := persistence(at))) / (1 - rho))))


def prior_firmness(at: Linearised) -> float:
    """By how much priors of constants of a run are narrowed: by the misfit that lasts where they are as wide as stated,
    so that they take what they explain and do not mend the rest."""
    return lasting_misfit(at.temper(1.0, 1.0))


def persistence(at: Linearised) -> float:
    """ρ ≥ 0: correlation of whitened residuals from one cell of a channel to the next, less what chance brings."""
    return correlate_neighbours(_channel_residuals(at))


def correlate_neighbours(several: Iterable[Array]) -> float:
    """ρ ≥ 0 of all series together: Σ xᵢxᵢ₊₁ over Σ (xᵢ² + xᵢ₊₁²)/2, less CHANCE standard errors of white noise."""
    along = square = 0.0
    pairs = 0
    for x in several:
        along += float(x[1:] @ x[:-1])
        square += float(x[1:] @ x[1:] + x[:-1] @ x[:-1]) / 2
        pairs += max(len(x) - 1, 0)
    if pairs < 1 or square <= 0:
        return 0.0
    return float(np.clip(along / square - CHANCE / np.sqrt(pairs), 0.0, 1 - 1 / pairs))


def _channel_residuals(at: Linearised) -> Iterator[Array]:
    first = 0
    for whitener in at.problem.whiteners:
        for rows, _ in whitener.blocks:
            yield at.left[first + rows.start : first + rows.stop]
        first += whitener.blocks[-1][0].stop if whitener.blocks else 0
