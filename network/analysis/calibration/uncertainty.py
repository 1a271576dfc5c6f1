"""How well each number is known: standard errors, 95 % intervals from profiles, correlations, bands of the TCP.

A fit that leaves more than noise has its readings' weight reduced by the misfit: C = (SᵀS/s² + V⁻¹)⁻¹, s the rms of
what is left, larger where that lasts (misfit.py). Profile likelihood: Pawitan, In All Likelihood (2001), ch. 3;
unverified.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, linearise
from network.analysis.calibration.misfit import lasting_misfit
from network.analysis.calibration.multistart import at_bound
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import centres
from network.platform.printing import Brief
from network.platform.refusal import Failed

FAR, LEVEL = 2.0, 1.959964
"""Standard errors at which a profile is looked at, and of the 95 % interval."""
LOOSE, FEW, MOST_PROFILED = 0.1, 8, 12
"""Standard error of the logarithm, and number of numbers, that ask for true points of the profile; most of them."""
PRIOR_ONLY = 0.9
CLOSELY = 0.97


@dataclass(frozen=True, eq=False, repr=False)
class Uncertainty(Brief):
    """Of a minimum. misfit: factor the readings' noise counts with; covariance: of (θ, η); sides: 1σ of θ downwards
    and upwards (parameters, 2), equal where the profile was taken for a parabola."""

    at: Linearised
    misfit: float
    covariance: Array
    sides: Array

    @property
    def std(self) -> Array:
        """1σ of θ."""
        return np.asarray(np.sqrt(np.diag(self.theta_covariance)), float)

    @property
    def theta_covariance(self) -> Array:
        n = self.at.free
        return self.covariance[:n, :n]

    @cached_property
    def correlation(self) -> Array:
        std = self.std
        return np.asarray(self.theta_covariance / np.outer(std, std))

    @property
    def prior_only(self) -> tuple[int, ...]:
        """Numbers that the readings say nothing about, and that stayed near their priors."""
        spread = np.array([p.spread for p in self.at.problem.parameters])
        stayed = np.abs(self.at.theta - centres(self.at.problem.parameters)) < spread
        return tuple(int(j) for j in np.flatnonzero(stayed & (self.std > PRIOR_ONLY * spread)))

    @property
    def at_bound(self) -> tuple[int, ...]:
        return tuple(at_bound(self.at.problem.parameters, self.at.theta))

    def interval(self, j: int) -> tuple[float, float]:
        """95 % of θ_j, within its bounds."""
        p, x = self.at.problem.parameters[j], float(self.at.theta[j])
        down, up = LEVEL * self.sides[j]
        return max(x - down, p.low), min(x + up, p.high)

    def pairs(self, above: float) -> Iterator[tuple[int, int, float]]:
        """Pairs more closely tied than that, the closest first; what only its prior knows is left out."""
        C = self.correlation
        n = len(C)
        rows = [(i, j, float(C[i, j])) for i in range(n) for j in range(i + 1, n) if abs(C[i, j]) > above]
        without = self.prior_only
        yield from sorted((r for r in rows if not {r[0], r[1]} & {*without}), key=lambda r: -abs(r[2]))


def uncertainty(at: Linearised) -> Uncertainty:
    """Standard errors of a minimum, profiles where they may be skew."""
    found = uncertainty_by_curvature(at)
    sides = np.array(found.sides, float)
    for j in profile_interval(found):
        sides[j] = _sides(found, j)
    return replace(found, sides=sides)


def uncertainty_by_curvature(at: Linearised) -> Uncertainty:
    """The same without profiles."""
    misfit = lasting_misfit(at)
    C = covariance(at, misfit)
    std = np.sqrt(np.diag(C)[: at.free])
    return Uncertainty(at, misfit, C, np.asarray(np.array([std, std]).T, np.float64))


def covariance(at: Linearised, misfit: float) -> Array:
    """(SᵀS/s² + V⁻¹)⁻¹ of (θ, η), s the misfit."""
    return np.asarray(np.linalg.inv(_precision(at, misfit)), np.float64)


def _precision(at: Linearised, misfit: float) -> Array:
    return at.normal / misfit**2 + np.diag(at.stated_prior[1] ** -2.0)


def profile_interval(known: Uncertainty) -> list[int]:
    """Numbers whose profile is looked at: all if they are few, else the loosest, and none that only its prior knows."""
    parameters = known.at.problem.parameters
    loose = [j for j, p in enumerate(parameters) if j not in known.prior_only and j not in known.at_bound
             and (len(parameters) <= FEW or known.std[j] > LOOSE * (1.0 if p.is_log else p.spread))]  # fmt: skip
    return sorted(loose, key=lambda j: -known.std[j] / parameters[j].spread)[:MOST_PROFILED]


def _sides(known: Uncertainty, j: int) -> tuple[float, float]:
    """1σ downwards and upwards: where a parabola through the true profile at 2σ rises by one."""
    std = float(known.std[j])
    return _side(known, j, -FAR * std), _side(known, j, FAR * std)


def _side(known: Uncertainty, j: int, move: float) -> float:
    rise = profile(known, j, move)
    std = float(known.std[j])
    return std if not np.isfinite(rise) or rise <= 0.25 else float(np.clip(abs(move) / np.sqrt(rise), std / 3, 3 * std))


def profile(known: Uncertainty, j: int, move: float) -> float:
    """What the least J, in units of the misfit, rises by if θ_j moves and all others follow."""
    at = known.at
    low, high = (np.array([getattr(q, side) for q in at.problem.parameters]) for side in ("low", "high"))
    along = known.covariance[: at.free, j] / known.covariance[j, j]
    theta = np.clip(at.theta + move * along, low, high)
    try:
        there = linearise(at.problem, theta)
        gain = _gain(there, known.misfit, j)
    except Failed:
        return float("inf")
    return scale_cost(there, known.misfit) - gain - scale_cost(at, known.misfit)


def scale_cost(at: Linearised, misfit: float) -> float:
    """J with the readings' part in units of the misfit."""
    mean, spread = at.stated_prior
    here = np.concatenate([at.theta, at.eta])
    return float(at.left @ at.left) / misfit**2 + float(np.sum(((here - mean) / spread) ** 2))


def _gain(at: Linearised, misfit: float, j: int) -> float:
    """What one Gauss–Newton step of all but θ_j still lowers J by, in units of the misfit."""
    mean, spread = at.stated_prior
    here = np.concatenate([at.theta, at.eta])
    gradient = at.slopes @ at.left / misfit**2 + (mean - here) / spread**2
    precision = _precision(at, misfit)
    others = np.delete(np.arange(len(mean)), j)
    g = gradient[others]
    return max(float(g @ np.linalg.solve(precision[np.ix_(others, others)], g)), 0.0)
