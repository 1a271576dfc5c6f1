"""Coloured noise of sensors, told from how residuals differ over short lags, whatever slow error the model still has.

Structure function D(l) = mean (e(t + l) − e(t))² = 2 σ_w² + 2 σ_c² (1 − e^(−l/τ)) + b l²: white noise, an
OU process of variance σ_c² and correlation time τ, and the slow drift of a model that is not right yet. Source: Rytov,
Kravtsov & Tatarskii, Principles of Statistical Radiophysics 1 (1987), on structure functions; unverified.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from scipy.optimize import nnls

from network.analysis.calibration.measured_means import Measured
from network.catalogue.declaration.declare import Array, Mask
from network.engine.response.intervals import locate_instants
from network.engine.response.model import Prediction
from network.platform.quantities.units import unit

LAGS = (1, 2, 3, 4, 6, 8, 11, 15, 20, 27, 36)
TIMES = (1.5, 2.5, 4.0, 6.5, 10.0, 16.0, 25.0)
"""Correlation times tried, in samples."""
CLIP = 0.99
LEAST_SHARE = 0.4
"""Coloured 1σ over white 1σ below which a sensor counts as white: white noise alone shows more in one of a hundred runs
of a thousand samples (simulated)."""
PAIRS = 200
"""Samples below which nothing is said."""
ALIKE, ALIKE_LAGS, ALIKE_SAMPLES = 0.22, (8, 16, 27), 3000
"""Correlation of two channels' bends over some lags from which they are no noise of their own, with so many samples."""

ALIKE_BUILT, BEYOND, FEWEST_PEERS = 0.3, 2.0, 2
"""Scatter of log σ over sensors of a kind (a prior), standard deviations of it that one may lie above the middle of the
others or above what its file says, and how many others it takes."""

LOUDEST = float(np.exp(BEYOND * ALIKE_BUILT))

Colour = tuple[float, float, float]


def residuals(data: Measured, prediction: Prediction) -> dict[str, Array]:
    """Measured less modelled at every sample that is used, NaN elsewhere, by channel [SI]."""
    edges, knots = prediction.course.problem.plan.edges, data.run.knots
    K = len(edges) - 1
    k, w = locate_instants(edges, knots.samples)
    out = {}
    for i, (name, channel) in enumerate(data.channels.items()):
        model = (1 - w) * prediction.values[i, k] + w * prediction.values[i, K + k]
        out[name] = np.where(channel.used, channel.values - model, np.nan)
    return out


def estimate_colours(
    data: Sequence[Measured], predictions: Sequence[Prediction]
) -> dict[str, tuple[float, float, float]]:
    """Channel → (white 1σ, coloured 1σ [SI], its correlation time [s]), from all runs together.

    A sensor's noise is its own: channels that sway together are moved by heat, and count as white.
    """
    by_run = [residuals(d, p) for d, p in zip(data, predictions, strict=True)]
    names = dict.fromkeys(name for r in by_run for name in r)
    interval = float(np.median(np.concatenate([np.diff(d.run.knots.samples) for d in data])))
    series = {name: [r.get(name, np.full(len(d.run.knots.samples), np.nan)) for d, r in zip(data, by_run, strict=True)]
              for name in names}  # fmt: skip
    still = [_standstill(d) for d in data]
    units = {n: column.unit for d in data for n, column in d.recording.columns.items()}
    times = _pool_times(series, units)
    whole = {name: colour(own, interval, times[name]) for name, own in series.items()}
    at_rest = {name: colour(_only(own, still), interval, times[name], 0.0) for name, own in series.items()}
    told = bound_by_standstill(whole, at_rest, units)
    moved = _find_common_moves({name: own for name, own in series.items() if told[name][1] > 0})
    told = {name: (white, 0.0, 0.0) if name in moved else (white, s, tau) for name, (white, s, tau) in told.items()}
    declared = {n: sigma for d in data for n, sigma in d.declared.items()}
    return bound_by_peers(told, units, declared)


def _pool_times(series: Mapping[str, Sequence[Array]], units: Mapping[str, str]) -> dict[str, Sequence[float]]:
    """Of each sensor the correlation time [samples] that the coloured ones of its kind have: built alike they share it,
    and one alone can hardly tell it."""
    left: dict[str, Array] = {}
    for name, own in series.items():
        if (D := _structures(own)) is not None and colour(own, 1.0)[1] > 0:
            left[units[name]] = left.get(units[name], np.zeros(len(TIMES))) + [_part(D, tau)[0] ** 2 for tau in TIMES]
    best = {kind: (TIMES[int(np.argmin(total))],) for kind, total in left.items()}
    return {name: best.get(units[name], TIMES) for name in series}


def _standstill(data: Measured) -> Mask:
    """Samples at which nothing that drives the run but temperatures is on."""
    t, signals = data.run.knots.samples, data.run.schedule.signals.values()
    driving = [s.at(t) for s in signals if not unit(s.unit).is_temperature]
    return np.all([values == 0 for values in driving], axis=0) if driving else np.zeros(len(t), bool)


def _only(series: Sequence[Array], where: Sequence[Mask]) -> list[Array]:
    return [np.where(kept, e, np.nan) for e, kept in zip(series, where, strict=True)]


def bound_by_standstill(
    whole: Mapping[str, Colour], still: Mapping[str, Colour], units: Mapping[str, str]
) -> dict[str, Colour]:
    """What is told by whole runs, the colour of a kind as at standstill where there is enough of that and it is less by
    more than the scatter of what is built alike: what comes with the drives is heat or vibration."""
    shares: dict[str, list[float]] = {}
    for name, (_, s, _) in whole.items():
        if s > 0 and still[name][0] > 0:
            shares.setdefault(units[name], []).append(still[name][1] / s)
    less = {kind: float(np.median(of)) for kind, of in shares.items()}
    quiet = {name: less.get(units[name], 1.0) for name in whole}
    return {name: (white, s * quiet[name], tau) if LOUDEST * quiet[name] < 1 else (white, s, tau)
            for name, (white, s, tau) in whole.items()}  # fmt: skip


def bound_by_peers(
    told: Mapping[str, Colour], units: Mapping[str, str], declared: Mapping[str, float]
) -> dict[str, Colour]:
    """No sensor's colour beyond what others of its kind have or, where these are few, its file says or its white noise
    shows: sensors of a kind are built alike, so that the logarithms of their 1σ scatter by ALIKE_BUILT; what exceeds it
    is no noise."""
    out = dict(told)
    for name, (white, s, tau) in told.items():
        peers = [told[n][1] for n in told if n != name and units.get(n) == units.get(name)]
        own = max(declared.get(name, np.inf), white)
        most = float(np.median(peers)) if len(peers) >= FEWEST_PEERS else own
        out[name] = (white, min(s, LOUDEST * most), tau) if min(s, most) > 0 else (white, 0.0, 0.0)
    return out


def _find_common_moves(series: Mapping[str, Sequence[Array]]) -> set[str]:
    """Channels whose bends Δ²e over some lag go with those of another, by the sign: sin(π/2 · mean sign·sign)."""
    moved: set[str] = set()
    for lag in ALIKE_LAGS:
        bends = {n: np.concatenate([_bends(e, lag) for e in own]) for n, own in series.items()}
        for a, b in combinations(bends, 2):
            both = bends[a] * bends[b]
            both = np.sign(both[np.isfinite(both)])
            if len(both) > PAIRS:
                least = ALIKE * max(1.0, np.sqrt(ALIKE_SAMPLES / len(both)))
                moved |= {a, b} if abs(np.sin(np.pi / 2 * both.mean())) > least else set()
    return moved


def _bends(e: Array, lag: int) -> Array:
    """e(t + 2l) − 2 e(t + l) + e(t) about its median: nothing of a steady drift is left in it."""
    bend = e[2 * lag :] - 2 * e[lag:-lag] + e[: -2 * lag]
    return np.asarray(bend - np.nanmedian(bend)) if np.isfinite(bend).any() else bend


def colour(
    series: Sequence[Array], interval: float, times: Sequence[float] = TIMES, least: float = LEAST_SHARE
) -> Colour:
    """(white 1σ, coloured 1σ, correlation time) of some evenly spaced residuals of one sensor; times: those tried
    [samples]; least: share of the white 1σ from which a sensor counts as coloured."""
    if (D := _structures(series)) is None:
        return 0.0, 0.0, 0.0
    _, white, tinted, tau = min(_part(D, tau) for tau in times)
    if tinted <= least**2 * max(white, 1e-300):
        return float(np.sqrt(white)), 0.0, 0.0
    return float(np.sqrt(white)), float(np.sqrt(tinted)), tau * interval


def _part(D: Array, tau: float) -> tuple[float, float, float, float]:
    """What white noise, coloured noise of a correlation time [samples] and a drift leave of a structure function, the
    variances of the first two, and the time."""
    lags = np.array(LAGS, float)
    basis = np.stack([np.full(len(lags), 2.0), 2 * (1 - np.exp(-lags / tau)), lags**2], axis=1)
    weight = 1 / (D * np.sqrt(lags))
    found, left = nnls(basis * weight[:, None], D * weight)
    return float(left), float(found[0]), float(found[1]), tau


def _structures(series: Sequence[Array]) -> Array | None:
    """Over all lags; None where too little is there to say."""
    D = np.array([_structure(series, lag) for lag in LAGS])
    enough = sum(np.isfinite(e).sum() for e in series) >= PAIRS and np.isfinite(D).all() and D[0] > 0
    return D if enough else None


def _structure(series: Sequence[Array], lag: int) -> float:
    """Mean squared difference over a lag; the largest hundredth (jumps, outliers) is left out."""
    squared = np.concatenate([np.empty(0), *((e[lag:] - e[:-lag]) ** 2 for e in series if len(e) > lag)])
    squared = np.sort(squared[np.isfinite(squared)])
    return float(squared[: max(1, int(CLIP * len(squared)))].mean()) / 0.93 if len(squared) else np.nan
