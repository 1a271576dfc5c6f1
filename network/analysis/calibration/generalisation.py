"""What a calibrated machine leaves of the tool centre point on a run it has not seen, from the runs it was fitted to.

Of run r: θ₋ᵣ from the normal equations without its rows, its own constants η_r from its beginning (as those of any
held-out run, each channel weighed by its misfit), and what is then left of the rest of it,

    e_r = z_r − y(θ̂) − Sθᵀ(θ₋ᵣ − θ̂) − Sηᵀη_r ,   left² = mean over readings of e² − σ²/n − Sθᵀ C Sθ ,

linearised about θ̂; σ²/n is the noise of a cell's mean, and the last term, by the numbers' covariance C, stands in the
band already. A single run is left out quarter by quarter instead. Since e comes of ν = Σ n (1 − ρ)/(1 + ρ) independent
values only, and one for each part left out at least, left is widened by Student's t over the normal quantile.
Range: left is a mean over the runs that there were; runs of another kind may leave more. Sources: leave-one-out from
normal equations: Cook & Weisberg, Residuals and Influence in Regression (1982), ch. 2; blocks of what lasts: Burman,
Chow & Nolan, Biometrika 81 (1994) 351; ν: Bayley & Hammersley (misfit.py); unverified.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import ndtri, stdtrit

from network.analysis.calibration.calibrated_patch import with_fitted_numbers, with_validity
from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.misfit import channel_misfits, correlate_neighbours
from network.analysis.calibration.uncertainty import Uncertainty
from network.analysis.comparison.run_constants import find_scored_from
from network.catalogue.declaration.declare import Array, Indices, Mask
from network.machine.machine import Machine
from network.machine.validity import Validity
from network.recordings.extrapolation import find_ranges

BLOCKS = 4
"""Parts of a single run that are left out one after the other."""
HALF = 0.975
ROUNDING = 1e-10
"""Added to a correlation, which is a product of rounded ones, before its root is taken."""


@dataclass(frozen=True, eq=False)
class Fold:
    """Rows of one run (masks over them): removed from the normal equations, telling its constants, scored."""

    run: int
    removed: Mask
    telling: Mask
    scored: Mask


@dataclass(frozen=True, eq=False)
class Unseen:
    """Of one channel in one fold, SI. left: of cells' means; counts: readings in each; due: variance by noise and by
    what is uncertain about the numbers."""

    left: Array
    counts: Array
    due: Array


def estimate_left(known: Uncertainty) -> dict[str, float]:
    """1σ of what is left of each axis that a channel measured [m or rad]; 0 where noise and numbers are all."""
    at, pooled = known.at, dict[str, list[Unseen]]()
    sensors = at.problem.model.machine.sensors
    if not any(sensors[n].axis for d in at.problem.data for n in d.run.channels):
        return {}
    for fold in _folds(at.problem.data):
        left, due = _leave_out(known, fold)
        data = at.problem.data[fold.run]
        channel = _channel_of_rows(data)
        for i, name in enumerate(data.run.channels):
            rows = fold.scored & (channel == i)
            axis = sensors[name].axis
            if axis is not None and rows.any():
                noise = data.declared[name] ** 2 / np.maximum(data.counts[data.known][rows], 1e-9)
                counts = data.counts[data.known][rows]
                pooled.setdefault(axis, []).append(Unseen(left[rows], counts, due[rows] + noise))
    return {axis: _pool(several) for axis, several in pooled.items()}


def with_numbers(machine: Machine, known: Uncertainty) -> Machine:
    """A machine with what a fit tells of its numbers: value ± standard error, at most that of the prior, and how far
    this holds."""
    parameters = known.at.problem.parameters
    std = np.minimum(known.std, [p.spread for p in parameters])
    return with_validity(with_fitted_numbers(machine, parameters, known.at.theta, std), state_validity(machine, known))


def state_validity(machine: Machine, known: Uncertainty) -> Validity:
    """What a calibrated machine says of itself."""
    problem = known.at.problem
    C = known.correlation
    root = np.linalg.cholesky(C + ROUNDING * np.eye(len(C))) if len(C) else C
    rows = {p.path: tuple(root[i, : i + 1].tolist()) for i, p in enumerate(problem.parameters)}
    schedules = [d.recording.schedule(machine.inputs) for d in problem.data]
    misfit = {n: (m.chi, m.rho) for n, m in channel_misfits(known.at).items()}
    return Validity(find_ranges(machine, schedules), estimate_left(known), rows, misfit)


def _pool(several: Sequence[Unseen]) -> float:
    counts = np.concatenate([u.counts for u in several])
    excess = np.concatenate([u.left**2 - u.due for u in several])
    mean = float(counts @ excess / counts.sum())
    return float(np.sqrt(max(mean, 0.0)) * stdtrit(_count_independent(several), HALF) / ndtri(HALF))


def _count_independent(several: Sequence[Unseen]) -> float:
    """ν of all folds together."""
    rho = correlate_neighbours(u.left for u in several)
    return max(sum(len(u.left) for u in several) * (1 - rho) / (1 + rho), float(len(several)))


def _channel_of_rows(data: Measured) -> Indices:
    return np.asarray(np.repeat(np.arange(len(data.run.channels)), data.run.knots.cells)[data.known])


def _folds(data: Sequence[Measured]) -> Iterator[Fold]:
    for r, d in enumerate(data):
        centres = np.tile(d.centres, len(d.run.channels))[d.known]
        begun = find_scored_from(d.recording)
        later = np.asarray(centres >= begun)
        if len(data) > 1:
            yield Fold(r, np.ones(len(later), bool), ~later, later)
            continue
        ends = np.linspace(begun, float(d.recording.t[-1]) + 1.0, BLOCKS + 1)
        for low, high in pairwise(ends):
            block = np.asarray((centres >= low) & (centres < high))
            yield Fold(r, block, ~later, block)


def _leave_out(known: Uncertainty, fold: Fold) -> tuple[Array, Array]:
    """Of the cells of a fold's run [SI]: what is left with the numbers of the others, and the variance that the numbers
    of all leave it."""
    at = known.at
    part, whitener = at.rows.slopes.parts[fold.run], at.problem.whiteners[fold.run]
    at_mean = at.rows.at_mean[at.rows.slopes.blocks[fold.run][0]]
    base = at_mean - _numbers_without(at, fold, at_mean) @ part.by_theta
    own = np.vstack([part.by_offset, part.by_own])
    spread = at.stated_prior[1][_columns(at, fold.run)[at.free :]]
    told, weights = own[:, fold.telling], _weigh_telling(at, fold)
    eta = np.linalg.solve((told * weights) @ told.T + np.diag(spread**-2), (told * weights) @ base[fold.telling])
    slopes = whitener.colour(part.by_theta)
    return whitener.colour(base - eta @ own), np.einsum("ik,ij,jk->k", slopes, known.theta_covariance, slopes)


def _weigh_telling(at: Linearised, fold: Fold) -> Array:
    """How much each row counts from which the constants of a fold's run are told."""
    data, misfit = at.problem.data[fold.run], channel_misfits(at)
    channel = _channel_of_rows(data)[fold.telling]
    return np.asarray(np.array([misfit[n].factor(is_whole=False) for n in data.run.channels])[channel] ** -2.0)


def _numbers_without(at: Linearised, fold: Fold, at_mean: Array) -> Array:
    """How far θ moves where the rows of a fold are not there."""
    part, columns = at.rows.slopes.parts[fold.run], _columns(at, fold.run)
    gone = np.vstack([part.by_theta, part.by_offset, part.by_own])[:, fold.removed]
    precision, gradient = at.precision.copy(), at.gradient.copy()
    precision[np.ix_(columns, columns)] -= gone @ gone.T
    gradient[columns] -= gone @ at_mean[fold.removed]
    moved = np.linalg.solve(precision, gradient)[: at.free]
    bounds = [(p.low - x, p.high - x) for p, x in zip(at.problem.parameters, at.theta, strict=True)]
    low, high = np.array(bounds).reshape(-1, 2).T
    return np.asarray(np.clip(moved, low, high))


def _columns(at: Linearised, run: int) -> Indices:
    """Of θ, the offsets and the own nuisances of a run among all."""
    slopes = at.rows.slopes
    own = slopes.blocks[run][1]
    return np.concatenate([np.arange(slopes.shared), np.arange(own.start, own.stop)])
