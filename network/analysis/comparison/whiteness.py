"""Are residuals white noise: a portmanteau over the lags, and the cumulative periodogram."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from network.analysis.comparison.amounts import amount
from network.catalogue.declaration.declare import Array
from network.platform.quantities.text_table import span

if TYPE_CHECKING:
    from network.analysis.comparison.channel_residual import ChannelResidual

LAGS = 20
LEVEL = 0.05
"""White noise is called something else this often; each of the two tests takes half."""
FEWEST = 24
USUAL, OFFSET = 1.3, 0.5
"""Noise larger or smaller by this factor, or shifted by this many σ, is not what was declared."""
WHITE = "residuals look like white noise"


@dataclass(frozen=True)
class Whiteness:
    """Two tests on one channel. q: Ljung-Box statistic over `lags` lags, p: its probability under white noise;
    distance: largest distance of the cumulative periodogram from a straight line, p_distance: its probability;
    lasting: time in which the autocorrelation falls to 1/e [s]; offset, scatter: mean and deviation from it, sigma:
    declared noise, SI; unit: of the channel."""

    name: str
    unit: str
    sigma: float
    offset: float
    scatter: float
    q: float
    lags: int
    p: float
    distance: float
    p_distance: float
    lasting: float

    @property
    def is_white(self) -> bool:
        return min(self.p, self.p_distance) > LEVEL / 2

    @property
    def sentence(self) -> str:
        if self.is_white:
            return f"{self.name}: {WHITE}{self.but}"
        return f"{self.name}: residuals are not white noise, they stay correlated for about {span(self.lasting)}"

    @property
    def but(self) -> str:
        """Where the noise is not what was declared."""
        declared = 1 / USUAL < self.scatter / self.sigma < USUAL
        size = "" if declared else f" of {amount(self.scatter, self.unit)} instead of {amount(self.sigma, self.unit)}"
        sign = "−" if self.offset < 0 else "+"
        about = f" around {sign}{amount(self.offset, self.unit)}" if abs(self.offset) > OFFSET * self.sigma else ""
        return size + about

    def summary(self) -> dict[str, Any]:
        return {
            "white": self.is_white, "ljung_box": {"q": self.q, "lags": self.lags, "p": self.p},
            "cumulative_periodogram": {"distance": self.distance, "p": self.p_distance},
            "lasting_seconds": self.lasting,
        }  # fmt: skip


def whiteness(channel: ChannelResidual, values: Array, r: Array, pairs: Array, step: float) -> Whiteness | None:
    """Tests of a row of `fill_gaps` in σ with its autocorrelations; None where there is too little to test."""
    from scipy.special import gammaincc

    if pairs[0] < FEWEST or not values.any():
        return None
    lags = int(min(LAGS, pairs[0] / 5))
    q = ljung_box(r[: lags + 1], pairs[: lags + 1])
    distance = cumulative_distance(values)
    p_distance = kolmogorov(distance, (len(values) - 1) // 2, float(pairs[0]) / len(values))
    mean, scatter = float(np.nanmean(channel.residual)), float(np.nanstd(channel.residual))
    about = channel.name, channel.unit, channel.sigma, mean, scatter
    return Whiteness(*about, q, lags, float(gammaincc(lags / 2, q / 2)), distance, p_distance, lasting(r) * step)


def ljung_box(r: Array, pairs: Array) -> float:
    """Q = (n + 2)/n Σ_k pairs_k r_k², χ² with as many degrees of freedom as lags under white noise.

    r_k: mean over the pairs that are there, so that without gaps this is n (n + 2) Σ ρ_k²/(n − k) of Ljung and Box,
    Biometrika 65 (1978) 297; with gaps: Stoffer and Toloi, Stat. Probab. Lett. 13 (1992) 391.
    """
    n = float(pairs[0])
    return float((n + 2) / n * np.sum(pairs[1:] * r[1:] ** 2))


def cumulative_distance(values: Array) -> float:
    """Largest distance of the cumulative periodogram from the straight line of white noise. Bartlett 1955."""
    power = np.abs(np.fft.rfft(values)[1 : (len(values) + 1) // 2]) ** 2
    rising = np.cumsum(power) / power.sum()
    even = np.arange(1, len(power) + 1) / len(power)
    return float(np.max(np.abs(rising - even)))


def kolmogorov(distance: float, count: int, share: float = 1.0) -> float:
    """Probability of a larger distance by chance with so many frequencies, of which gaps leave a share independent.

    p = 2 Σ_j (−1)^(j−1) exp(−2 j² λ²), λ = D (√m + 0.12 + 0.11/√m): Stephens, J. R. Stat. Soc. B 32 (1970) 115.
    """
    root = np.sqrt(max(count * share - 1, 1.0))
    j = np.arange(1, 101)
    terms = 2 * (-1.0) ** (j - 1) * np.exp(-2 * (j * distance * (root + 0.12 + 0.11 / root)) ** 2)
    return float(np.clip(terms.sum(), 0.0, 1.0)) if distance * root > 0.2 else 1.0


def lasting(r: Array) -> float:
    """Steps until the autocorrelation has fallen to 1/e of that at one step."""
    below = np.flatnonzero(r[1:] < max(float(r[1]), 0.0) / np.e)
    return float(below[0] + 1) if len(below) else float(len(r))
