"""The most probable parameters: Gauss–Newton with Levenberg–Marquardt damping on whitened residuals and priors.

Minimised is J(θ, η) = |L⁻¹(z − y(θ) − N η)|² + |(θ − θ₀)/σ_θ|² + |(η − η₀)/σ_η|²: z means of measured cells, y the
model, L Lᵀ the noise, η what else is uncertain and acts linearly (start of every part, instants of jumps, sensor
offsets). Source: Madsen, Nielsen & Tingleff, Methods for Non-linear Least Squares Problems (2004), algorithm 3.16.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from network.calibration.evidence import OFFSET, Measured, Nuisance
from network.calibration.noise import Noise, Whitener, slack_covariance, whitener
from network.calibration.parameters import Parameter, centres
from network.calibration.predictor import Model, Prediction
from network.calibration.threads import on_one_thread
from network.declare import Array
from network.machine import Machine
from network.refusal import Failed

STEPS = 25
CLOSE, CLOSE_SHARE = 1e-2, 1e-5
"""Decrease of J that no longer matters (J counts in squared σ), and as a share of J."""
FAR = 3.0
"""Misfit χ from which a fit begins with narrowed priors."""
NEAR = 0.02
"""Distance in θ (logarithms, or prior 1σ) over which slopes count as the same."""
DAMPING, LEAST_DAMPING, HARDER, SOFTER, HARDEST = 1e-3, 1e-7, 8.0, 0.05, 1e9


@dataclass(frozen=True, eq=False)
class Problem:
    """A model with what it is compared to. offsets: of channels, common to all runs; firm_theta, firm_eta: factors by
    which the priors of θ and η are narrowed, so that a model that does not fit yet is not mended by its nuisances."""

    model: Model
    data: tuple[Measured, ...]
    whiteners: tuple[Whitener, ...]
    offsets: tuple[Nuisance, ...]
    firm_theta: float = 1.0
    firm_eta: float = 1.0

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.model.parameters

    @cached_property
    def nuisances(self) -> tuple[Nuisance, ...]:
        """Offsets, then of every run its starts and its jumps."""
        return (*self.offsets, *(n for d in self.data for n in (*d.starts, *d.edges)))

    @cached_property
    def prior(self) -> tuple[Array, Array]:
        """Prior means and 1σ of (θ, η)."""
        own = [(p.centre, p.spread / self.firm_theta) for p in self.parameters]
        parts = [*own, *((n.mean, n.spread / self.firm_eta) for n in self.nuisances)]
        mean, spread = np.array(parts).reshape(-1, 2).T
        return mean, spread

    @property
    def samples(self) -> int:
        return sum(len(w.known) if w.known.dtype != bool else int(w.known.sum()) for w in self.whiteners)

    @property
    def log_determinant(self) -> float:
        return sum(w.log_determinant for w in self.whiteners)


def make_problem(
    machine: Machine, parameters: Sequence[Parameter], data: Sequence[Measured], noise: Noise | None = None,
    at: Sequence[Prediction] | None = None,
) -> Problem:  # fmt: skip
    """The problem of some runs; with slack in the noise, `at` are predictions that carry its heat to the channels."""
    noise = noise or Noise()
    model = Model(machine, parameters, [d.run for d in data])
    whiteners = []
    for i, d in enumerate(data):
        slack = slack_covariance(at[i], d, noise) if at is not None and any(noise.slack.values()) else None
        whiteners.append(whitener(d, noise, slack))
    return Problem(model, tuple(data), tuple(whiteners), tuple(_offsets(machine, data)))


def _offsets(machine: Machine, data: Sequence[Measured]) -> list[Nuisance]:
    names = [n for n in machine.sensors if any(n in d.run.channels for d in data)]
    return [Nuisance(n, 0.0, OFFSET[machine.sensors[n].unit]) for n in names]


@dataclass(frozen=True, eq=False)
class Linearised:
    """The problem about θ. residual: whitened z − y(θ); slopes: whitened ∂y/∂(θ, η), (parameters + nuisances, rows).

    made_at, eta_made_at: θ at which the slopes by θ and by η were found, where that is not here.
    """

    problem: Problem
    theta: Array
    predictions: tuple[Prediction, ...]
    residual: Array
    slopes: Array
    made_at: Array | None = None
    eta_made_at: Array | None = None

    @property
    def free(self) -> int:
        return len(self.theta)

    @cached_property
    def blocks(self) -> tuple[tuple[slice, slice], ...]:
        """Of every run: its rows, and its own nuisances; the other runs' slopes are zero there."""
        found, row, column = [], 0, self.free + len(self.problem.offsets)
        for data, whiten in zip(self.problem.data, self.problem.whiteners, strict=True):
            rows, own = whiten.count, len(data.starts) + len(data.edges)
            found.append((slice(row, row + rows), slice(column, column + own)))
            row, column = row + rows, column + own
        return tuple(found)

    @cached_property
    def normal(self) -> Array:
        """SᵀS without the prior."""
        shared, total = self.free + len(self.problem.offsets), np.zeros((len(self.slopes), len(self.slopes)))
        for rows, own in self.blocks:
            common, mine = self.slopes[:shared, rows], self.slopes[own, rows]
            total[:shared, :shared] += common @ common.T
            total[:shared, own] = common @ mine.T
            total[own, :shared] = total[:shared, own].T
            total[own, own] = mine @ mine.T
        return total

    def renewed(self, normal: Array) -> Array:
        """SᵀS from that of a point with the same slopes by η."""
        n, total = self.free, normal.copy()
        for i, row in enumerate(self.slopes[:n]):
            total[i] = self.along(row)
        total[:, :n] = total[:n].T
        return total

    def along(self, values: Array) -> Array:
        """S applied to whitened rows: (parameters + nuisances)."""
        shared, total = self.free + len(self.problem.offsets), np.zeros(len(self.slopes))
        for rows, own in self.blocks:
            total[:shared] += self.slopes[:shared, rows] @ values[rows]
            total[own] = self.slopes[own, rows] @ values[rows]
        return total

    def moved_by(self, eta: Array) -> Array:
        """Whitened rows that nuisances bring."""
        shared, total = self.free + len(self.problem.offsets), np.empty(len(self.residual))
        for rows, own in self.blocks:
            mine = slice(own.start - self.free, own.stop - self.free)
            total[rows] = eta[: shared - self.free] @ self.slopes[self.free : shared, rows]
            total[rows] += eta[mine] @ self.slopes[own, rows]
        return total

    @cached_property
    def precision(self) -> Array:
        """Inverse posterior covariance of (θ, η), linearised."""
        return np.asarray(self.normal + np.diag(self.problem.prior[1] ** -2.0))

    @cached_property
    def gradient(self) -> Array:
        """−½ ∂J/∂(θ, η) at θ and η = η₀."""
        mean, spread = self.problem.prior
        own = np.zeros(len(mean))
        own[: self.free] = (mean[: self.free] - self.theta) / spread[: self.free] ** 2
        return np.asarray(self.along(self._at_mean) + own)

    @cached_property
    def _at_mean(self) -> Array:
        """Residual with the nuisances at their prior means."""
        return np.asarray(self.residual - self.moved_by(self.problem.prior[0][self.free :]))

    @cached_property
    def _inner(self) -> tuple[Array, bool]:
        """Factor of the nuisances' own precision."""
        return cho_factor(self.precision[self.free :, self.free :], check_finite=False)  # type: ignore[no-any-return]

    @cached_property
    def reduced(self) -> tuple[Array, Array]:
        """Precision and −½ gradient of J in θ alone, with the nuisances at their most probable all along."""
        n = self.free
        if len(self.gradient) == n:
            return self.precision, self.gradient
        across = self.precision[n:, :n]
        solved = cho_solve(self._inner, np.column_stack([across, self.gradient[n:]]), check_finite=False)
        return self.precision[:n, :n] - across.T @ solved[:, :n], self.gradient[:n] - across.T @ solved[:, n]

    @cached_property
    def covariance(self) -> Array:
        """Posterior covariance of (θ, η), linearised."""
        return np.asarray(np.linalg.inv(self.precision))

    @cached_property
    def eta(self) -> Array:
        """Most probable nuisances at this θ."""
        mean, _ = self.problem.prior
        if len(mean) == self.free:
            return np.empty(0)
        ahead = self.along(self._at_mean)[self.free :]
        return np.asarray(mean[self.free :] + cho_solve(self._inner, ahead, check_finite=False))

    @cached_property
    def left(self) -> Array:
        """Whitened residual with the nuisances at their most probable."""
        return np.asarray(self.residual - self.moved_by(self.eta))

    @cached_property
    def cost(self) -> float:
        """J at this θ, least over η."""
        mean, spread = self.problem.prior
        at = np.concatenate([self.theta, self.eta])
        return float(self.left @ self.left + np.sum(((at - mean) / spread) ** 2))

    def beside(self, **changes: Any) -> Linearised:
        """The same slopes with another θ, residual, or problem that differs in its priors only."""
        if "theta" in changes:
            own = {"made_at": self.made_at, "eta_made_at": self.eta_made_at}
            changes |= {name: self.theta if at is None else at for name, at in own.items()}
        other = replace(self, **changes)
        kept = ("normal",) if "problem" in changes else ("normal", "precision", "_inner")
        other.__dict__.update({name: self.__dict__[name] for name in kept if name in self.__dict__})
        return other

    @property
    def log_evidence(self) -> float:
        """Log of the probability of the recordings, parameters integrated out (Laplace), but for a constant."""
        _, spread = self.problem.prior
        _, volume = np.linalg.slogdet(self.precision * np.outer(spread, spread))
        return -0.5 * (self.cost + self.problem.log_determinant + float(volume))


@on_one_thread
def linearise(problem: Problem, theta: Array) -> Linearised:
    """The problem about θ. Raises Failed where a run runs away."""
    return _with_slopes(problem, theta, problem.model.predict(theta))


def _with_slopes(
    problem: Problem, theta: Array, predictions: tuple[Prediction, ...], near: Linearised | None = None
) -> Linearised:
    """The problem about θ from its predictions; the slopes by η are those of `near`, if it is given."""
    pushes = [d.pushes(p.course) for d, p in zip(problem.data, predictions, strict=True)] if near is None else None
    means = problem.model.mean_slopes(theta, predictions, pushes)
    residual = np.concatenate(list(_residuals(problem, predictions)))
    slopes = np.zeros((len(problem.prior[0]), len(residual)))
    made_at = None if near is None else near.theta if near.eta_made_at is None else near.eta_made_at
    at = Linearised(problem, theta, predictions, residual, slopes, None, made_at)
    shared = at.free + len(problem.offsets)
    for i, (rows, own) in enumerate(at.blocks):
        whitened = problem.whiteners[i](means[i])
        slopes[: at.free, rows] = whitened[: at.free]
        if near is None:
            slopes[own, rows] = whitened[at.free :]
            slopes[at.free : shared, rows] = problem.whiteners[i](_offset_columns(problem, problem.data[i]))
        else:
            slopes[own, rows], slopes[at.free : shared, rows] = near.slopes[own, rows], near.slopes[at.free : shared, rows]
    if near is not None:
        at.__dict__["normal"] = at.renewed(near.normal)
    return at


def _offset_columns(problem: Problem, data: Measured) -> Array:
    names = np.repeat(data.run.channels, data.run.knots.cells)
    return np.array([names == n.name for n in problem.offsets], float).reshape(len(problem.offsets), len(names))


def _residuals(problem: Problem, predictions: Sequence[Prediction]) -> Iterator[Array]:
    for data, whiten, prediction in zip(problem.data, problem.whiteners, predictions, strict=True):
        yield whiten(data.means - prediction.cells)


def _offset_columns(problem: Problem, data: Measured) -> Array:
    names = np.repeat(data.run.channels, data.run.knots.cells)
    return np.array([names == n.name for n in problem.offsets], float).reshape(len(problem.offsets), len(names))


def residual_cost(about: Linearised, theta: Array) -> float:
    """J at another θ, with the nuisances' columns taken from nearby; infinite where a run breaks down."""
    problem = about.problem
    try:
        predictions = problem.model.predict(theta)
    except Failed:
        return np.inf
    r = np.concatenate(list(_residuals(problem, predictions)))
    return about.beside(theta=theta, residual=r).cost if np.isfinite(r).all() else np.inf


@on_one_thread
def minimise(
    problem: Problem, theta: Array | None = None, steps: int = STEPS, tell: Callable[[float], None] | None = None
) -> Linearised:
    """The most probable θ, from a start (the priors' centres).

    First with all priors narrowed by the misfit χ, which keeps the numbers plausible while the run is far off; then
    with those of θ as they are; those of η stay narrowed by what misfit is left.
    """
    theta = centres(problem.parameters) if theta is None else theta
    low, high = (np.array([getattr(p, side) for p in problem.parameters]) for side in ("low", "high"))
    at, damping = _tempered(linearise(problem, np.clip(theta, low, high)), True), DAMPING
    far = chi_of(at) > FAR
    for k in range(steps):
        if tell:
            tell(k / steps)
        at, damping, gain = _improved(at, damping, low, high)
        done = gain < max(CLOSE, CLOSE_SHARE * at.cost)
        far = far and not done and k < steps // 3
        at = _tempered(at, far)
        if done and not far and at.problem.firm_theta == 1.0 and (gain < CLOSE or k > 2):
            break
    return _completed(at)


def chi_of(at: Linearised) -> float:
    """Rms of the whitened residual: 1 where the model is right and the noise as stated."""
    return float(np.sqrt(np.mean(at.left**2))) if len(at.left) else 0.0


def _tempered(at: Linearised, far: bool) -> Linearised:
    """The same point with priors narrowed by the misfit that is left."""
    chi = max(1.0, chi_of(at))
    return at.beside(problem=replace(at.problem, firm_theta=chi if far else 1.0, firm_eta=chi))


def _improved(at: Linearised, damping: float, low: Array, high: Array) -> tuple[Linearised, float, float]:
    """One accepted step, the damping after it, and what J lost (what it would lose, where that is next to nothing)."""
    refused = False
    while damping < HARDEST:
        step = np.clip(at.theta + _step(at, damping, low, high), low, high) - at.theta
        precision, gradient = at.reduced
        expected = float(2 * step @ gradient - step @ precision @ step)
        if expected < CLOSE / 2 or float(np.abs(step).max(initial=0.0)) < 1e-9:
            return at, damping, max(expected, 0.0)
        new = _tried(at, at.theta + step, refused)
        if new is not None:
            return new, max(damping * SOFTER, LEAST_DAMPING), at.cost - new.cost
        if at.made_at is not None:
            at = _with_slopes(at.problem, at.theta, at.predictions, at)
        else:
            refused, damping = True, max(damping * HARDER, DAMPING)
    return at, damping, 0.0


def _tried(at: Linearised, theta: Array, refused: bool) -> Linearised | None:
    """The problem about θ, if it is better there. Slopes are found again where θ has moved far since they were, or at
    once where no step was `refused` before."""
    try:
        predictions = at.problem.model.predict(theta)
    except Failed:
        return None
    residual = np.concatenate(list(_residuals(at.problem, predictions)))
    if not np.isfinite(residual).all():
        return None
    new = at.beside(theta=theta, residual=residual, predictions=predictions)
    if not _is_near(new) and (not refused or new.cost < at.cost):
        new = _with_slopes(at.problem, theta, predictions, at)
    return new if new.cost < at.cost else None


def _is_near(at: Linearised) -> bool:
    """Whether slopes that were found elsewhere are good here."""
    spreads = np.array([1.0 if p.is_log else p.spread for p in at.problem.parameters])
    return at.made_at is None or bool((np.abs(at.theta - at.made_at) < NEAR * spreads).all())


def _completed(at: Linearised) -> Linearised:
    """With slopes by θ that are good here, and slopes by η from here."""
    if at.eta_made_at is None and _is_near(at):
        return at
    return _with_slopes(at.problem, at.theta, at.predictions)


def _step(at: Linearised, damping: float, low: Array, high: Array) -> Array:
    """The damped step of θ, η following; parameters at a bound that they push against stay."""
    precision, gradient = at.reduced
    precision = precision + damping * np.diag(np.diag(precision))
    stuck = np.zeros(at.free, bool)
    for _ in range(3):
        moves = np.flatnonzero(~stuck)
        step = np.zeros(at.free)
        step[moves] = cho_solve(cho_factor(precision[np.ix_(moves, moves)]), gradient[moves])
        out = ((at.theta <= low) & (step < 0)) | ((at.theta >= high) & (step > 0))
        if not out.any():
            break
        stuck |= out
    return step
