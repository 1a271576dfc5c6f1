"""From a first fit to one whose uncertainty can be believed: coloured noise, sensors' offsets, readings that lie apart.

A machine that lacks some physics would abuse them: colour is bounded by what sensors of a kind share, offsets by their
priors, which count the more the farther off the machine is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg import LinAlgError

from network.analysis.calibration.coloured_noise import estimate_colours
from network.analysis.calibration.gauss_newton import Linearised, minimise
from network.analysis.calibration.measured_means import OFFSET_LIMIT, Measured, Nuisance
from network.analysis.calibration.multistart import rms
from network.analysis.calibration.noise import Noise, whitener
from network.catalogue.declaration.declare import Array
from network.platform.printing import Brief
from network.recordings.hygiene.data_quality import NORMAL

HUBER, MOST_WEIGHTED = 4.0, 0.1
"""Robust deviations from which a cell counts less; if more cells than this share do, the model is wrong, not they."""
LET_GO = 1.4
"""By how much coloured noise may raise what is left in units of white noise."""
ROUNDS = 2


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Brief):
    """A refined fit. offsets: whether sensors' offsets took part, refused: or were not let; weighted: cells that count
    less."""

    at: Linearised
    noise: Noise
    offsets: bool
    refused: bool
    weighted: int


def fit_robustly(
    offsets: tuple[Nuisance, ...], at: Linearised, is_late: Callable[[], bool] = lambda: False
) -> Fit:  # fmt: skip
    """offsets: of sensors; at: the minimum without them; is_late: whether what there is has to do."""
    fit = Fit(at, Noise(), False, False, 0)
    for refine in (_with_sensor_colours, partial(_with_offsets, offsets), _weigh_readings):
        fit = fit if is_late() else refine(fit)
    return fit


def _with_sensor_colours(fit: Fit) -> Fit:
    """The fit with the sensors' own coloured noise."""
    found = estimate_colours(fit.at.problem.data, fit.at.predictions)
    coloured = {n: (s, tau) for n, (_, s, tau) in found.items() if s > 0}
    return _with_noise(fit, Noise(coloured=coloured)) if coloured else fit


def _with_offsets(offsets: tuple[Nuisance, ...], fit: Fit) -> Fit:
    """The fit with offsets where they stay what sensors of their kind are off by, else as it was."""
    if not offsets:
        return fit
    at = minimise(replace(fit.at.problem, offsets=offsets), fit.at.theta)
    far = np.abs(at.eta[: len(offsets)]) / [n.spread for n in offsets]
    if far.max() < OFFSET_LIMIT:
        return replace(fit, at=at, offsets=True, refused=False)
    return replace(fit, refused=True)


def _refit(fit: Fit, data: Sequence[Measured], noise: Noise) -> Linearised:
    problem = replace(fit.at.problem, data=tuple(data), whiteners=tuple(whitener(d, noise) for d in data))
    return minimise(problem, fit.at.theta)


def _with_noise(fit: Fit, noise: Noise) -> Fit:
    """The fit with other noise, unless that lets the readings go."""
    try:
        trial = replace(fit, at=_refit(fit, fit.at.problem.data, noise), noise=noise)
    except LinAlgError:
        return fit
    return trial if in_white(trial.at) < LET_GO * in_white(fit.at) else fit


def _weigh_readings(fit: Fit) -> Fit:
    """Cells far out for what most of them scatter count less, as by Huber."""
    for _ in range(ROUNDS):
        z = fit.at.left
        scale = max(float(np.median(np.abs(z))) / NORMAL, 1.0)
        out = np.abs(z) > HUBER * scale
        if not out.any() or out.mean() > MOST_WEIGHTED:
            return fit
        weights = np.minimum(1.0, HUBER * scale / np.maximum(np.abs(z), 1e-12))
        data, first = [], 0
        for d in fit.at.problem.data:
            counts = d.counts.copy()
            known = np.flatnonzero(d.known)
            counts[known] *= weights[first : first + len(known)]
            data.append(replace(d, counts=counts))
            first += len(known)
        fit = replace(fit, at=_refit(fit, data, fit.noise), weighted=int(out.sum()))
    return fit


def in_white(at: Linearised) -> float:
    """rms of what is left, in units of white noise only."""
    z = [r / np.sqrt(d.variance) for r, d in zip(residuals_to_si(at), at.problem.data, strict=True)]
    whole = np.concatenate(z)
    return rms(whole[np.isfinite(whole)])


def residuals_to_si(at: Linearised) -> list[Array]:
    """Of each run: what is left of its cells in SI, NaN where there is none."""
    out, first = [], 0
    for d, w in zip(at.problem.data, at.problem.whiteners, strict=True):
        known = np.flatnonzero(d.known)
        own = at.left[first : first + len(known)]
        values = np.full(len(d.means), np.nan)
        values[known] = w.colour(own)
        out.append(values)
        first += len(known)
    return out
