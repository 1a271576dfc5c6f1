"""How far a fit is off, in noise, and how much less its readings therefore tell.

χ is the rms of whitened residuals: 1 where the model is right and the noise as stated. Where the model is not right its
error lasts: n cells with a correlation ρ from one to the next tell as much as n (1 − ρ)/(1 + ρ) independent ones, so
that all of them together count as if the noise were χ √((1 + ρ)/(1 − ρ)) as large. Source: Bayley & Hammersley,
J. R. Statist. Soc. Suppl. 8 (1946) 184, for a first-order process; unverified.

Channels are not told equally well: where numbers are already known, each counts by its own misfit, so that one that
the machine lacks the physics of does not bend what the others tell.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.estimate import Estimate
from network.analysis.calibration.linearised import Linearised
from network.catalogue.declaration.declare import Array
from network.machine.validity import Validity

CHANCE = 2.0
"""Standard errors of ρ of white noise that are taken off it."""


def chi_of(at: Linearised) -> float:
    """Rms of the whitened residual."""
    return float(np.sqrt(at.misfit / len(at.residual))) if len(at.residual) else 0.0


def strain_of(at: Linearised | Estimate) -> float:
    """What starts, jumps and offsets are strained by beyond chance: Σ ((η − η₀)/σ)² less their count, at least 0. What
    only these constants take up has not been explained, and counts beside |left|²."""
    mean, spread = (x[at.free :] for x in at.problem.prior)
    return max(float(np.sum(((at.eta - mean) / spread) ** 2)) - len(mean), 0.0)


def implausibility(at: Linearised) -> float:
    """−2 log of the posterior of (θ, η), but for a constant, where noise is s ≥ 1 times as large as stated: n log s² +
    |left|²/s² + priors, s = max(1, χ) its most probable. Minima that leave different misfits are compared by it: J in
    stated noise lets readings bend numbers however far from their priors for what no minimum fits."""
    s, n = max(1.0, chi_of(at)), len(at.residual)
    mean, spread = at.stated_prior
    here = np.concatenate([at.theta, at.eta])
    return 2 * n * float(np.log(s)) + at.misfit / s**2 + float(np.sum(((here - mean) / spread) ** 2))


def lasting_misfit(at: Linearised) -> float:
    """χ √((1 + ρ)/(1 − ρ)), at least 1: the factor that the noise of the readings counts with."""
    return max(1.0, chi_of(at) * float(np.sqrt((1 + (rho := persistence(at))) / (1 - rho))))


@dataclass(frozen=True)
class ChannelMisfit:
    """Of one channel over all runs of a fit. chi: rms of what is left, whitened; rho: from one cell to the next."""

    chi: float
    rho: float

    def factor(self, is_whole: bool) -> float:
        """What its noise counts with where numbers are known and a run's constants are told: by a whole run all that
        lasts of it; by a beginning, where parts stand where they were read and misfit is still small, χ alone."""
        return max(1.0, self.chi * (float(np.sqrt((1 + self.rho) / (1 - self.rho))) if is_whole else 1.0))


def stated_misfits(stated: Validity | None) -> Mapping[str, ChannelMisfit] | None:
    """As a calibrated file has them; None where it says nothing."""
    return {n: ChannelMisfit(*pair) for n, pair in stated.misfit.items()} if stated and stated.misfit else None


def channel_misfits(at: Linearised | Estimate) -> Mapping[str, ChannelMisfit]:
    """Of every channel."""
    pooled: dict[str, list[Array]] = {}
    for name, left in list_channel_residuals(at):
        pooled.setdefault(name, []).append(left)
    return {n: ChannelMisfit(_rms(np.concatenate(z)), correlate_neighbours(z)) for n, z in pooled.items()}


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def persistence(at: Linearised) -> float:
    """ρ ≥ 0: correlation of whitened residuals from one cell of a channel to the next, less what chance brings."""
    return correlate_neighbours(left for _, left in list_channel_residuals(at))


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


def list_channel_residuals(at: Linearised | Estimate) -> Iterator[tuple[str, Array]]:
    """What is left of each channel of each run."""
    first = 0
    for data, whitener in zip(at.problem.data, at.problem.whiteners, strict=True):
        for name, (rows, _) in zip(data.run.channels, whitener.blocks, strict=True):
            yield name, at.left[first + rows.start : first + rows.stop]
        first += whitener.blocks[-1][0].stop if whitener.blocks else 0
