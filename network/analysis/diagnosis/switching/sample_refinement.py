"""Draws polished: Gauss–Newton steps of many of them at once, over ever more of the runs.

With residuals r and slopes J of a draw (differences), M = I − Sᵀ(SSᵀ + V⁻¹)⁻¹S as in the screening and the draw's
prior N(θ₀, Σ), a step solves (JᵀMJ + Σ⁻¹ + λ diag) δ = JᵀM r − Σ⁻¹(θ − θ₀); of a long and a short one the better is
taken, if it is better. Source: separable least squares, Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413;
unverified.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.diagnosis.switching.prior_samples import Judge
from network.analysis.diagnosis.switching.share_view import View
from network.catalogue.declaration.declare import Array

DIFFERENCE = 0.01
"""Steps of the differences, in prior σ."""
DAMPED = (0.01, 1.0)
"""Shares λ of the diagonal that are added to it."""
FARTHEST = 1.0
"""Prior σ that a number is moved at most in a step."""


@dataclass(frozen=True, eq=False)
class _At:
    """Draws with their residuals, slopes (draws, numbers, rows) and misfits."""

    theta: Array
    residual: Array
    slopes: Array
    misfit: Array


def refine_samples(judge: Judge, view: View, theta: Array, steps: int) -> tuple[Array, Array]:
    """Draws (draws, numbers) after some steps, and their misfits."""
    misfit = np.full(len(theta), np.inf)
    for _ in range(steps):
        at = _at(judge, view, theta)
        others = [_clip_step(judge, theta, step) for step in _steps(judge, view, at)]
        there = np.concatenate(others)
        misfits = judge.misfits(view, there, judge.residuals(view, there)).reshape(len(others), -1)
        tried, misfits = np.stack([theta, *others]), np.vstack([at.misfit, misfits])
        best, draws = np.argmin(misfits, axis=0), np.arange(len(theta))
        theta, misfit = tried[best, draws], misfits[best, draws]
    return theta, misfit


def _at(judge: Judge, view: View, theta: Array) -> _At:
    width = DIFFERENCE * judge.space.prior[1]
    around = [theta, *(theta + moved for moved in np.diag(width))]
    residual, *moved = np.split(judge.residuals(view, np.concatenate(around)), len(around))
    slopes = np.stack([(residual - other) / h for other, h in zip(moved, width, strict=True)], axis=1)
    return _At(theta, residual, slopes, judge.misfits(view, theta, residual))


def _steps(judge: Judge, view: View, at: _At, dampings: Sequence[float] = DAMPED) -> list[Array]:
    """(draws, numbers) for every damping; none where a draw or its neighbours cannot be run."""
    centre, spread, _, _ = judge.space.prior
    others = view.projector
    adjusted, _ = view.take_up(at.residual)
    left = at.residual - adjusted @ others.slopes
    right = (at.slopes @ left[:, :, None])[:, :, 0] - (at.theta - centre) / spread**2
    beside = np.linalg.solve(others.root, (at.slopes @ others.slopes.T).transpose(0, 2, 1))
    H = at.slopes @ at.slopes.transpose(0, 2, 1) - beside.transpose(0, 2, 1) @ beside
    runs = np.asarray(np.isfinite(H).all(axis=(1, 2)) & np.isfinite(right).all(axis=1))
    one = np.eye(len(spread))
    H, right = np.where(runs[:, None, None], H, one), np.where(runs[:, None], right, 0.0)
    damped = (H + np.diag(spread**-2.0) + share * one * H for share in dampings)
    return [np.asarray(np.linalg.solve(each, right[:, :, None])[:, :, 0]) for each in damped]


def _clip_step(judge: Judge, theta: Array, step: Array) -> Array:
    _, spread, low, high = judge.space.prior
    return np.asarray(np.clip(theta + np.clip(step, -FARTHEST * spread, FARTHEST * spread), low, high))
