"""A fit about some θ: residuals, slopes by everything that is uncertain, and what follows from these without a run.

The slopes have an arrow's shape: parameters and offsets touch all runs, starts and jumps their own run only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from network.calibration.arrow import Folded, Part, folded
from network.calibration.evidence import Measured
from network.calibration.predictor import Prediction
from network.calibration.problem import Problem
from network.calibration.projector import Projector
from network.declare import Array
from network.refusal import Failed


@dataclass(frozen=True, eq=False)
class Linearised:
    """The problem about θ. residual: whitened z − y(θ); parts: slopes, run by run.

    made_at, eta_made_at: θ at which the slopes by θ and by η were found, where that is not here.
    """

    problem: Problem
    theta: Array
    predictions: tuple[Prediction, ...]
    residual: Array
    parts: tuple[Part, ...]
    made_at: Array | None = None
    eta_made_at: Array | None = None

    @property
    def free(self) -> int:
        return len(self.theta)

    @property
    def _shared(self) -> int:
        return self.free + len(self.problem.offsets)

    @cached_property
    def blocks(self) -> tuple[tuple[slice, slice], ...]:
        """Of every run: its rows, and its own nuisances; the other runs' slopes are zero there."""
        found, row, column = [], 0, self._shared
        for part in self.parts:
            own, rows = part.by_own.shape
            found.append((slice(row, row + rows), slice(column, column + own)))
            row, column = row + rows, column + own
        return tuple(found)

    @cached_property
    def slopes(self) -> Array:
        """Whitened ∂y/∂(θ, η), (parameters + nuisances, rows)."""
        slopes = np.zeros((len(self.problem.prior[0]), len(self.residual)))
        for (rows, own), part in zip(self.blocks, self.parts, strict=True):
            slopes[: self.free, rows], slopes[own, rows] = part.by_theta, part.by_own
            slopes[self.free : self._shared, rows] = part.by_offset
        return slopes

    @cached_property
    def normal(self) -> Array:
        """SᵀS without the prior."""
        k, total = self._shared, np.zeros((len(self.problem.prior[0]),) * 2)
        for (_, own), part in zip(self.blocks, self.parts, strict=True):
            total[:k, :k] += part.shared
            total[own, :k], total[:k, own], total[own, own] = part.across, part.across.T, part.by_eta[2]
        return total

    def along(self, values: Array) -> Array:
        """S applied to whitened rows: (parameters + nuisances)."""
        n, k, total = self.free, self._shared, np.zeros(len(self.problem.prior[0]))
        for (rows, own), part in zip(self.blocks, self.parts, strict=True):
            total[:n] += part.by_theta @ values[rows]
            total[n:k] += part.by_offset @ values[rows]
            total[own] = part.by_own @ values[rows]
        return total

    def moved_by(self, eta: Array) -> Array:
        """Whitened rows that nuisances bring."""
        total, offsets = np.empty(len(self.residual)), len(self.problem.offsets)
        for (rows, own), part in zip(self.blocks, self.parts, strict=True):
            mine = eta[own.start - self.free : own.stop - self.free]
            total[rows] = eta[:offsets] @ part.by_offset + mine @ part.by_own
        return total

    def project(self, rows: Array) -> Array:
        """What of whitened rows (…, rows) parameters and nuisances cannot take up, given their priors."""
        return Projector(self.slopes, self.precision).project(rows)

    @cached_property
    def precision(self) -> Array:
        """Inverse posterior covariance of (θ, η), linearised."""
        return np.asarray(self.normal + np.diag(self.problem.prior[1] ** -2.0))

    @cached_property
    def gradient(self) -> Array:
        """−½ ∂J/∂(θ, η) at θ and η = η₀."""
        mean, spread = self.problem.prior
        total = self._toward.copy()
        total[: self.free] += (mean[: self.free] - self.theta) / spread[: self.free] ** 2
        return total

    @cached_property
    def _at_mean(self) -> Array:
        """Residual with the nuisances at their prior means."""
        return np.asarray(self.residual - self.moved_by(self.problem.prior[0][self.free :]))

    @cached_property
    def _toward(self) -> Array:
        return self.along(self._at_mean)

    @cached_property
    def folded(self) -> Folded:
        """The precision with the runs' own nuisances folded in."""
        return folded(self.free, self.parts, self.problem.prior[1] ** -2.0)

    @cached_property
    def _solved(self) -> tuple[Array, float, Array, Array]:
        k = self._shared
        return self.folded.solved(self.gradient[:k], [self.gradient[own] for _, own in self.blocks])

    @property
    def reduced(self) -> tuple[Array, Array]:
        """Precision and −½ gradient of J in θ alone, with the nuisances at their most probable all along."""
        return self._solved[2:]

    @cached_property
    def covariance(self) -> Array:
        """Posterior covariance of (θ, η), linearised."""
        return np.asarray(np.linalg.inv(self.precision))

    @cached_property
    def eta(self) -> Array:
        """Most probable nuisances at this θ."""
        return np.asarray(self.problem.prior[0][self.free :] + self._solved[0])

    @cached_property
    def left(self) -> Array:
        """Whitened residual with the nuisances at their most probable."""
        return np.asarray(self.residual - self.moved_by(self.eta))

    @cached_property
    def cost(self) -> float:
        """J at this θ, least over η."""
        mean, spread = (p[: self.free] for p in self.problem.prior)
        return float(self._at_mean @ self._at_mean - self._solved[1] + np.sum(((self.theta - mean) / spread) ** 2))

    @cached_property
    def misfit(self) -> float:
        """|left|², from the normal equations."""
        mean, spread = self.problem.prior
        at = np.concatenate([self.theta, self.eta])
        return max(self.cost - float(np.sum(((at - mean) / spread) ** 2)), 0.0)

    def beside(self, **changes: Any) -> Linearised:
        """The same slopes with another θ, residual, or problem that differs in its priors' widths only."""
        if "theta" in changes:
            own = {"made_at": self.made_at, "eta_made_at": self.eta_made_at}
            changes |= {name: self.theta if at is None else at for name, at in own.items()}
        other = replace(self, **changes)
        kept = ("normal", "_at_mean", "_toward") if "problem" in changes else ("normal", "precision", "folded")
        other.__dict__.update({name: self.__dict__[name] for name in kept if name in self.__dict__})
        return other

    @property
    def log_evidence(self) -> float:
        """Log of the probability of the recordings, parameters integrated out (Laplace), but for a constant."""
        volume = self.folded.log_determinant + 2 * float(np.log(self.problem.prior[1]).sum())
        return -0.5 * (self.cost + self.problem.log_determinant + volume)


def linearise(problem: Problem, theta: Array) -> Linearised:
    """The problem about θ. Raises Failed where a run runs away."""
    return with_slopes(problem, theta, problem.model.predict(theta))


def with_slopes(
    problem: Problem, theta: Array, predictions: tuple[Prediction, ...], near: Linearised | None = None
) -> Linearised:
    """The problem about θ from its predictions; the slopes by η are those of `near`, if it is given."""
    pushes = [d.pushes(p.course) for d, p in zip(problem.data, predictions, strict=True)] if near is None else None
    means = problem.model.mean_slopes(theta, predictions, pushes)
    parts, n = [], len(theta)
    for i, (whiten, slopes) in enumerate(zip(problem.whiteners, means, strict=True)):
        whitened = whiten(slopes)
        if near is None:
            offsets = whiten(_offset_columns(problem, problem.data[i]))
            parts.append(Part(whitened[:n], offsets, whitened[n:]))
        else:
            parts.append(_renewed(near.parts[i], whitened))
    made_at = None if near is None else near.theta if near.eta_made_at is None else near.eta_made_at
    return Linearised(problem, theta, predictions, residual_of(problem, predictions), tuple(parts), None, made_at)


def _renewed(part: Part, by_theta: Array) -> Part:
    """The part with other slopes by θ; what was worked out of those by η comes along."""
    new = replace(part, by_theta=by_theta)
    new.__dict__["by_eta"] = part.by_eta
    return new


def _offset_columns(problem: Problem, data: Measured) -> Array:
    names = np.repeat(data.run.channels, data.run.knots.cells)
    return np.array([names == n.name for n in problem.offsets], float).reshape(len(problem.offsets), len(names))


def residual_of(problem: Problem, predictions: Sequence[Prediction]) -> Array:
    """Whitened z − y of all runs."""
    runs = zip(problem.data, problem.whiteners, predictions, strict=True)
    return np.concatenate([whiten(data.means - prediction.cells) for data, whiten, prediction in runs])


def residual_cost(about: Linearised, theta: Array) -> float:
    """J at another θ, with the nuisances' columns taken from nearby; infinite where a run breaks down."""
    try:
        r = residual_of(about.problem, about.problem.model.predict(theta))
    except Failed:
        return np.inf
    return about.beside(theta=theta, residual=r).cost if np.isfinite(r).all() else np.inf
