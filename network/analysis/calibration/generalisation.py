"""What a calibrated machine leaves of the tool centre point on a run it has not seen, from the runs it was fitted to.

Of run r: θ₋ᵣ of a fit without it (left_out.py), its own constants η_r from its beginning (as those of any held-out run,
each channel weighed by its misfit), and what is then left of the rest of it,

    e_r = z_r − y(θ₋ᵣ) − Sηᵀη_r ,   left_r: the least with which |e_r| ≤ 1.96 √(left_r² + σ²/n + Sθᵀ C Sθ) for 95 %

of its readings; σ²/n is the noise of a cell's mean, and the last term, by the numbers' covariance C, stands in the band
already. A new run that is one like the others leaves more than all R of them once in R + 1: left is the
⌈0.95 (R + 1)⌉th of them, and the largest where they are fewer. A single run is left out half by half instead: a misfit
that lasts is told of a quarter by the quarters beside it.
Range: runs of another kind may leave more, and of the next run a single one tells little. Sources: conformal prediction
of groups: Dunn, Wasserman & Ramdas, J. Am. Stat. Assoc. 118 (2023) 2491; blocks of what lasts: Burman, Chow & Nolan,
Biometrika 81 (1994) 351; unverified.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from network.analysis.calibration.calibrated_patch import with_fitted_numbers, with_validity
from network.analysis.calibration.left_out import linearise_alone, refit_without
from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.misfit import channel_misfits
from network.analysis.calibration.uncertainty import LEVEL, Uncertainty
from network.analysis.comparison.run_constants import find_scored_from
from network.catalogue.declaration.declare import Array, Indices, Mask
from network.machine.machine import Machine
from network.machine.validity import Validity
from network.recordings.extrapolation import find_ranges

BLOCKS = 2
"""Parts of a single run that are left out one after the other."""
SHARE = 0.95
"""Of readings, and of runs, that a band is to hold."""
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


def estimate_left(known: Uncertainty, is_late: Callable[[], bool] = lambda: False) -> dict[str, float]:
    """1σ of what is left of each axis that a channel measured [m or rad]; 0 where noise and numbers are all. Once it is
    late, fits without a run are a step along the slopes of the whole."""
    at, pooled = known.at, dict[str, list[Unseen]]()
    sensors = at.problem.model.machine.sensors
    if not any(sensors[n].axis for d in at.problem.data for n in d.run.channels):
        return {}
    for fold in _folds(at.problem.data):
        found = _leave_out(known, fold, is_late())
        if found is None:
            continue
        left, due = found
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


def with_numbers(machine: Machine, known: Uncertainty, is_late: Callable[[], bool] = lambda: False) -> Machine:
    """A machine with what a fit tells of its numbers, and how far this holds, which takes fits that leave runs out."""
    return with_validity(with_standard_errors(machine, known), state_validity(machine, known, is_late))


def with_standard_errors(machine: Machine, known: Uncertainty) -> Machine:
    """A machine with value ± standard error, at most that of the prior, of each number that was fitted."""
    parameters = known.at.problem.parameters
    std = np.minimum(known.std, [p.spread for p in parameters])
    return with_fitted_numbers(machine, parameters, known.at.theta, std)


def state_validity(
    machine: Machine, known: Uncertainty, is_late: Callable[[], bool] = lambda: False
) -> Validity:  # fmt: skip
    """What a calibrated machine says of itself."""
    problem = known.at.problem
    C = known.correlation
    root = np.linalg.cholesky(C + ROUNDING * np.eye(len(C))) if len(C) else C
    rows = {p.path: tuple(root[i, : i + 1].tolist()) for i, p in enumerate(problem.parameters)}
    schedules = [d.recording.schedule(machine.inputs) for d in problem.data]
    misfit = {n: (m.chi, m.rho) for n, m in channel_misfits(known.at).items()}
    starts_read = any(d.recording.start is not None and d.recording.start.read for d in problem.data)
    return Validity(find_ranges(machine, schedules), estimate_left(known, is_late), rows, misfit, starts_read)


def _pool(several: Sequence[Unseen]) -> float:
    """What the fold leaves that a new run exceeds with 1 − SHARE; the most, where folds are fewer than that takes."""
    ordered = sorted(map(_left_of, several))
    rank = int(np.ceil(SHARE * (len(ordered) + 1)))
    return ordered[min(rank, len(ordered)) - 1]


def _left_of(fold: Unseen) -> float:
    """1σ beside what is due with which SHARE of the readings lie inside."""
    beyond = fold.left**2 / LEVEL**2 - fold.due
    by = np.argsort(beyond)
    inside = np.cumsum(fold.counts[by]) / fold.counts.sum()
    return float(np.sqrt(max(beyond[by][np.searchsorted(inside, SHARE)], 0.0)))


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


def _leave_out(known: Uncertainty, fold: Fold, is_brief: bool) -> tuple[Array, Array] | None:
    """Of the cells of a fold's run [SI]: what is left with the numbers of the others, and the variance that the numbers
    of all leave it; None where a run runs away."""
    theta = refit_without(known.at, fold.run, fold.removed, is_brief)
    at = None if theta is None else linearise_alone(known.at, fold.run, theta)
    if at is None:
        return None
    (part,), (whitener,) = at.rows.slopes.parts, at.problem.whiteners
    own = np.vstack([part.by_offset, part.by_own])
    mean, spread = (of[at.free :] for of in at.stated_prior)
    base = at.residual - mean @ own
    told, weights = own[:, fold.telling], _weigh_telling(known.at, fold)
    eta = np.linalg.solve((told * weights) @ told.T + np.diag(spread**-2), (told * weights) @ base[fold.telling])
    slopes = whitener.colour(known.at.rows.slopes.parts[fold.run].by_theta)
    return whitener.colour(base - eta @ own), np.einsum("ik,ij,jk->k", slopes, known.theta_covariance, slopes)


def _weigh_telling(at: Linearised, fold: Fold) -> Array:
    """How much each row counts from which the constants of a fold's run are told."""
    data, misfit = at.problem.data[fold.run], channel_misfits(at)
    channel = _channel_of_rows(data)[fold.telling]
    return np.asarray(np.array([misfit[n].factor(is_whole=False) for n in data.run.channels])[channel] ** -2.0)
