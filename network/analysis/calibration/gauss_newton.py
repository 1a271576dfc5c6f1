"""The most probable parameters: Gauss–Newton with Levenberg–Marquardt damping on whitened residuals and priors.

Source: Madsen, Nielsen & Tingleff, Methods for Non-linear Least Squares Problems (2004), algorithm 3.16.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import cho_factor, solve_triangular
from scipy.optimize import lsq_linear

from network.analysis.calibration.linearised import Linearised, linearise, residual_cost, residual_of, with_slopes
from network.analysis.calibration.misfit import chi_of
from network.analysis.calibration.problem import Problem, make_problem
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import centres
from network.platform.refusal import Failed

__all__ = ["Linearised", "Problem", "chi_of", "linearise", "make_problem", "minimise", "residual_cost"]

STEPS = 60
"""At most; nearly all fits end within 25, those of numbers far beyond their priors, along bent valleys, within 50."""
CLOSE, CLOSE_SHARE, CLOSE_SHARE_FAR = 1e-2, 1e-5, 1e-4
"""Decrease of J that no longer matters (J counts in squared σ), and as a share of J, also where the run is far off."""
FAR = 3.0
"""Misfit χ from which priors of θ are narrowed."""
NEAR = 0.02
"""Distance in θ (logarithms, or prior 1σ) over which slopes count as the same."""
REACH = 0.5
"""Prior σ that a number may move by in one step: slopes hold for some tens of per cent, and what leaps over several σ
lands beyond the ridge, in another minimum."""
NEAR_ETA = 0.2
"""The same of slopes by η, once they were found anew."""
SETTLED = 1.0
"""Decrease of J, in squares of the misfit, below which slopes by η found anew change nothing: a numbers moves by less
than its standard error."""
DAMPING, LEAST_DAMPING, HARDER, SOFTER, HARDEST = 1e-3, 1e-7, 8.0, 0.05, 1e9


def minimise(
    problem: Problem, theta: Array | None = None, steps: int = STEPS, tell: Callable[[float], None] | None = None
) -> Linearised:
    """The most probable θ, from a start (the priors' centres).

    While the run is far off all priors are narrowed by the misfit χ, as if the noise were that much larger, which keeps
    the numbers plausible; then those of θ are as they are, and those of η stay narrowed by what misfit is left. Slopes
    by η are those of the start until no step betters J, then those found there, until that changes nothing.
    """
    theta = centres(problem.parameters) if theta is None else theta
    low, high = (np.array([getattr(p, side) for p in problem.parameters]) for side in ("low", "high"))
    at, damping, settled = _temper_priors(linearise(problem, np.clip(theta, low, high))), DAMPING, np.inf
    for k in range(steps):
        if tell:
            tell(k / steps)
        before = at
        at, damping, gain = _improve(at, damping, low, high)
        at = _temper_priors(at)
        is_far, was_far = (x.problem.firm_theta > 1 for x in (at, before))
        if gain >= max(CLOSE, (CLOSE_SHARE_FAR if is_far else CLOSE_SHARE) * at.cost) or is_far != was_far:
            if settled < np.inf and not _lies_within(at, at.eta_made_at, NEAR_ETA):
                at = _temper_priors(_complete_slopes(at))
            continue
        done, at = at, _temper_priors(_complete_slopes(at))
        if at is done or settled - at.cost < SETTLED * max(1.0, chi_of(at)) ** 2:
            break
        settled = min(settled, at.cost)
    return _complete_slopes(_temper_priors(at, free=True))


def _temper_priors(at: Linearised, free: bool = False) -> Linearised:
    """The same point with priors narrowed by the misfit that is left; those of θ only far off."""
    chi = max(1.0, chi_of(at))
    return at.temper(chi if chi > FAR and not free else 1.0, chi)


def _improve(at: Linearised, damping: float, low: Array, high: Array) -> tuple[Linearised, float, float]:
    """One accepted step, the damping after it, and what J lost (what it would lose, where that is next to nothing)."""
    refused = False
    while damping < HARDEST:
        step = _shorten(at, _step(at, damping, low, high))
        precision, gradient = at.reduced
        expected = float(2 * step @ gradient - step @ precision @ step)
        if expected < CLOSE / 2 or float(np.abs(step).max(initial=0.0)) < 1e-9:
            return at, damping, max(expected, 0.0)
        new = _try_step(at, np.clip(at.theta + step, low, high), refused)
        if new is not None:
            return new, max(damping * SOFTER, LEAST_DAMPING), at.cost - new.cost
        if at.made_at is not None:
            at = with_slopes(at.problem, at.theta, at.predictions, at)
        else:
            refused, damping = True, max(damping * HARDER, DAMPING)
    return at, damping, 0.0


def _try_step(at: Linearised, theta: Array, refused: bool) -> Linearised | None:
    """The problem about θ, if it is better there. Slopes are found again where θ has moved far since they were, or at
    once where no step was `refused` before."""
    try:
        predictions = at.problem.model.predict(theta)
    except Failed:
        return None
    residual = residual_of(at.problem, predictions)
    if not np.isfinite(residual).all():
        return None
    new = at.beside(theta, residual, predictions)
    if not _is_near(new) and (not refused or new.cost < at.cost):
        new = with_slopes(at.problem, theta, predictions, at)
    return new if new.cost < at.cost else None


def _is_near(at: Linearised) -> bool:
    """Whether slopes that were found elsewhere are good here."""
    return _lies_within(at, at.made_at, NEAR)


def _lies_within(at: Linearised, made_at: Array | None, reach: float) -> bool:
    spreads = np.array([1.0 if p.is_log else p.spread for p in at.problem.parameters])
    return made_at is None or bool((np.abs(at.theta - made_at) < reach * spreads).all())


def _complete_slopes(at: Linearised) -> Linearised:
    """With slopes by θ that are good here, and slopes by η from here."""
    if at.eta_made_at is None and _is_near(at):
        return at
    return with_slopes(at.problem, at.theta, at.predictions)


def _shorten(at: Linearised, step: Array) -> Array:
    """The step within REACH."""
    spreads = [p.spread for p in at.problem.parameters]
    return step / max(1.0, float(np.abs(step / spreads).max(initial=0.0)) / REACH)


def _step(at: Linearised, damping: float, low: Array, high: Array) -> Array:
    """The damped step of θ within its bounds, η following."""
    precision, gradient = at.reduced
    root, _ = cho_factor(precision + damping * np.diag(np.diag(precision)), lower=True)
    toward = solve_triangular(root, gradient, lower=True)
    step = np.asarray(solve_triangular(root, toward, lower=True, trans="T"))
    down, up = low - at.theta, high - at.theta
    if ((step >= down) & (step <= up)).all():
        return step
    return np.asarray(np.clip(lsq_linear(np.tril(root).T, toward, (down, up), "bvls").x, down, up))
