"""A fit without some of its rows, found anew: what is linear about the fit with them tells little of how far numbers go
that the rest holds loosely."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import cholesky

from network.analysis.calibration.gauss_newton import linearise, minimise
from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.noise import Whitener
from network.analysis.calibration.problem import Problem
from network.catalogue.declaration.declare import Array, Mask
from network.engine.response.model import Model
from network.platform.refusal import Failed

STEPS = 12
"""Of a fit without some of its rows, which begins at that with all."""


def refit_without(at: Linearised, run: int, removed: Mask, is_brief: bool = False) -> Array | None:
    """θ of a fit without some rows of a run (mask over them); None where that runs away. Where relays switch, each fit
    is dear and a part of a run out of step: there, and where it is to be brief, a step along the slopes of the
    whole."""
    problem = at.problem
    if problem.model.switches or is_brief:
        return _step_without(at, run, removed)
    data, whiteners = list(problem.data), list(problem.whiteners)
    if removed.all():
        del data[run], whiteners[run]
    else:
        data[run], whiteners[run] = _thin_out(data[run], whiteners[run], ~removed)
    try:
        return minimise(_of_runs(problem, data, whiteners), at.theta, STEPS).theta
    except (Failed, np.linalg.LinAlgError):
        return None


def linearise_alone(at: Linearised, run: int, theta: Array) -> Linearised | None:
    """One run at some θ; None where that runs away."""
    try:
        return linearise(_of_runs(at.problem, [at.problem.data[run]], [at.problem.whiteners[run]]), theta)
    except (Failed, np.linalg.LinAlgError):
        return None


def _step_without(at: Linearised, run: int, removed: Mask) -> Array:
    """θ after one Gauss–Newton step without the rows. Source: Cook & Weisberg, Residuals and Influence in Regression
    (1982), ch. 2; unverified."""
    slopes = at.rows.slopes
    part, (rows, own) = slopes.parts[run], slopes.blocks[run]
    columns = np.concatenate([np.arange(slopes.shared), np.arange(own.start, own.stop)])
    gone = np.vstack([part.by_theta, part.by_offset, part.by_own])[:, removed]
    precision, gradient = at.precision.copy(), at.gradient.copy()
    precision[np.ix_(columns, columns)] -= gone @ gone.T
    gradient[columns] -= gone @ at.rows.at_mean[rows][removed]
    moved = at.theta + np.linalg.solve(precision, gradient)[: at.free]
    low, high = (np.array([getattr(p, side) for p in at.problem.parameters]) for side in ("low", "high"))
    return np.asarray(np.clip(moved, low, high))


def _of_runs(problem: Problem, data: Sequence[Measured], whiteners: Sequence[Whitener]) -> Problem:
    model = Model(problem.model.machine, problem.parameters, [d.run for d in data])
    return Problem(model, tuple(data), tuple(whiteners), problem.offsets, moves=problem.moves)


def _thin_out(data: Measured, whitener: Whitener, kept: Mask) -> tuple[Measured, Whitener]:
    """A run of which only some rows count."""
    known = data.known.copy()
    known[known] = kept
    roots = []
    for rows, root in whitener.blocks:
        own = kept[rows]
        roots.append(root[own] if root.ndim == 1 else _root(root[own] @ root[own].T))
    return replace(data, counts=np.where(known, data.counts, 0.0)), Whitener(known, tuple(roots))


def _root(covariance: Array) -> Array:
    return np.asarray(cholesky(covariance, lower=True)) if len(covariance) else covariance
