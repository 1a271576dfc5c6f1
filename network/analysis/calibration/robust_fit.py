"""From a first fit to one whose uncertainty can be believed: offsets, readings that lie apart, coloured residuals.

Each is let in only where it explains what noise leaves: a machine that lacks some physics would abuse it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from network.analysis.calibration.coloured_noise import estimate_colours
from network.analysis.calibration.gauss_newton import Linearised, Problem, minimise
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.multistart import ADEQUATE, rms
from network.analysis.calibration.noise import Noise, cell_widths, correlate_averages, whitener
from network.catalogue.declaration.declare import Array
from network.recordings.hygiene.data_quality import NORMAL

OFFSETS_FAR = 3.0
"""Prior σ beyond which offsets are no offsets any more."""
FAR_OFF = 10.0
"""rms that no offset could mend."""
HUBER, MOST_WEIGHTED = 4.0, 0.1
"""Robust deviations from which a cell counts less; if more cells than this share do, the model is wrong, not they."""
COLOURABLE = 3.0
"""rms up to which residuals may be coloured noise; beyond, something is missing."""
TINTED = 2.0
"""Coloured over white 1σ of a sensor beyond which it is the model that is wrong."""
LET_GO = 1.4
"""By how much coloured noise may raise what is left in units of white noise."""
LONG = 8.0
"""Correlation times that a run has to hold at least."""
MISFIT = 1.2
"""rms up to which residuals are what white noise leaves."""
PERSISTENT = 1.5
"""Lag-1 autocorrelation, in its own standard errors, from which a channel is looked at."""
GAIN = 5.0
"""Log-likelihood that colour has to bring a channel."""
SHARES = np.array([0.3, 0.5, 0.7, 0.85, 1.0, 1.3])
TIMES = np.array([60.0, 200.0, 600.0, 2000.0, 6000.0, 20000.0, 60000.0])
ROUNDS = 2


@dataclass(frozen=True, eq=False)
class Fit:
    """A refined fit. offsets: whether sensors' offsets took part, refused: or were not let; weighted: cells that count
    less."""

    at: Linearised
    noise: Noise
    offsets: bool
    refused: bool
    weighted: int


def fit_robustly(problem: Problem, at: Linearised) -> Fit:
    """problem: with offsets; at: the minimum without them."""
    fit = _with_offsets(problem, _with_sensor_colours(Fit(at, Noise(), False, False, 0)))
    fit = _weigh_readings(fit)
    for _ in range(ROUNDS):
        noise = estimate_noise(fit)
        if noise is None:
            break
        fit = _with_noise(fit, noise)
        fit = fit if fit.offsets else _with_offsets(problem, fit)
    return fit


def _with_sensor_colours(fit: Fit) -> Fit:
    """The fit with the sensors' own coloured noise, where that goes far to explain what is left."""
    if rms(fit.at.left) <= MISFIT:
        return fit
    found = estimate_colours(fit.at.problem.data, fit.at.predictions)
    sigma = {n: s for d in fit.at.problem.data for n, s in d.sigma.items()}
    coloured = {n: (s, tau) for n, (_, s, tau) in found.items() if 0 < s < TINTED * sigma[n]}
    trial = _with_noise(fit, Noise(coloured=coloured)) if coloured else fit
    return trial if rms(trial.at.left) <= COLOURABLE else fit


def _with_offsets(problem: Problem, fit: Fit) -> Fit:
    """The fit with offsets where it is adequate and they stay offsets, else as it was."""
    if not problem.offsets:
        return fit
    if rms(fit.at.left) > FAR_OFF:
        return replace(fit, refused=True)
    at = minimise(replace(fit.at.problem, offsets=problem.offsets), fit.at.theta)
    far = np.abs(at.eta[: len(problem.offsets)]) / [n.spread for n in problem.offsets]
    if rms(at.left) < ADEQUATE and far.max() < OFFSETS_FAR:
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
    """Cells far out for what most of them scatter count less, as by Huber; not where the bulk disagrees already."""
    for _ in range(ROUNDS):
        z = fit.at.left
        scale = max(float(np.median(np.abs(z))) / NORMAL, 1.0)
        out = np.abs(z) > HUBER * scale
        if scale > ADEQUATE or not out.any() or out.mean() > MOST_WEIGHTED:
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


# -- colour -----------------------------------------------------------------------------------------------------------
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


def estimate_noise(fit: Fit) -> Noise | None:
    """Each channel's (σ, τ) where its residuals ask for it; None where none does, or where the fit is too bad."""
    if rms(fit.at.left) > COLOURABLE:
        return None
    left = residuals_to_si(fit.at)
    names = dict.fromkeys(n for d in fit.at.problem.data for n in d.run.channels)
    found = {name: best for name in names if (best := _colour(fit.at.problem.data, left, name))}
    return Noise(coloured=found) if found and found != fit.noise.coloured else None


def _colour(data: Sequence[Measured], left: Sequence[Array], name: str) -> tuple[float, float] | None:
    """The most probable (σ, τ) of a channel's residuals, if much more probable than none."""
    pieces = [p for d, r in zip(data, left, strict=True) if (p := _piece(d, r, name)) is not None]
    if not pieces:
        return None
    if not any(_is_persistent(r / np.sqrt(v)) for r, v, *_ in pieces):
        return None
    size = rms(np.concatenate([r for r, *_ in pieces]))
    longest = max(float(t[-1] - t[0]) for _, _, t, _ in pieces)
    none = sum(_log_likelihood(r, np.diag(v)) for r, v, _, _ in pieces)
    best, at = none + GAIN, None
    for tau in TIMES[longest > LONG * TIMES]:
        shapes = [correlate_averages(t, width, tau) for _, _, t, width in pieces]
        for s in SHARES * size:
            found = sum(
                _log_likelihood(r, np.diag(v) + s * s * K) for (r, v, _, _), K in zip(pieces, shapes, strict=True)
            )
            if found > best:
                best, at = found, (float(s), float(tau))
    return at


def _piece(data: Measured, left: Array, name: str) -> tuple[Array, Array, Array, Array] | None:
    """Residuals, white variances, instants and widths of the cells of a channel in one run."""
    if name not in data.run.channels:
        return None
    i, cells = data.run.channels.index(name), data.run.knots.cells
    own = slice(i * cells, (i + 1) * cells)
    known = data.known[own]
    if not known.any():
        return None
    return left[own][known], data.variance[own][known], data.centres[known], cell_widths(data)[known]


def _is_persistent(z: Array) -> bool:
    """Whether neighbours in time are alike."""
    if len(z) < 4:
        return False
    lag = float(z[1:] @ z[:-1]) / max(float(z @ z), 1e-300)
    return bool(lag > PERSISTENT / np.sqrt(len(z)))


def _log_likelihood(r: Array, covariance: Array) -> float:
    try:
        factor = cho_factor(covariance, lower=True)
    except LinAlgError:
        return -np.inf
    return float(-0.5 * (r @ cho_solve(factor, r)) - np.log(np.diag(factor[0])).sum())
