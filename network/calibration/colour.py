"""Coloured noise of sensors, told from how residuals differ over short lags, whatever slow error the model still has.

Structure function D(l) = mean (e(t + l) − e(t))² = 2 σ_w² + 2 σ_c² (1 − e^(−l/τ)) + b l²: white noise, an
OU process of variance σ_c² and correlation time τ, and the slow drift of a model that is not right yet. Source: Rytov,
Kravtsov & Tatarskii, Principles of Statistical Radiophysics 1 (1987), on structure functions; unverified.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from network.calibration.evidence import Measured
from network.calibration.predictor import Prediction
from network.declare import Array

LAGS = (1, 2, 3, 4, 6, 8, 11, 15, 20, 27, 36)
TIMES = (1.5, 2.5, 4.0, 6.5, 10.0, 16.0, 25.0)
"""Correlation times tried, in samples."""
CLIP = 0.99
LEAST_SHARE = 0.5
"""Coloured 1σ over white 1σ below which a sensor counts as white."""
PAIRS = 200
"""Samples below which nothing is said."""


def residuals(data: Measured, prediction: Prediction) -> dict[str, Array]:
    """Measured less modelled at every sample that is used, NaN elsewhere, by channel [SI]."""
    edges, knots = prediction.course.problem.plan.edges, data.run.knots
    K = len(edges) - 1
    k = np.clip(np.searchsorted(edges - 1e-6, knots.samples, side="right") - 1, 0, K - 1)
    w = np.clip((knots.samples - edges[k]) / (edges[k + 1] - edges[k]), 0.0, 1.0)
    out = {}
    for i, (name, channel) in enumerate(data.channels.items()):
        model = (1 - w) * prediction.values[i, k] + w * prediction.values[i, K + k]
        out[name] = np.where(channel.used, channel.values - model, np.nan)
    return out


def colours(data: Sequence[Measured], predictions: Sequence[Prediction]) -> dict[str, tuple[float, float, float]]:
    """Channel → (white 1σ, coloured 1σ [SI], its correlation time [s]), from all runs together."""
    by_run = [residuals(d, p) for d, p in zip(data, predictions, strict=True)]
    names = dict.fromkeys(name for r in by_run for name in r)
    interval = float(np.median(np.concatenate([np.diff(d.run.knots.samples) for d in data])))
    return {name: colour([r[name] for r in by_run if name in r], interval) for name in names}


def colour(series: Sequence[Array], interval: float) -> tuple[float, float, float]:
    """(white 1σ, coloured 1σ, correlation time) of some evenly spaced residuals of one sensor."""
    D = np.array([_structure(series, lag) for lag in LAGS])
    if sum(np.isfinite(e).sum() for e in series) < PAIRS or not np.isfinite(D).all() or D[0] <= 0:
        return 0.0, 0.0, 0.0
    lags, weight = np.array(LAGS, float), 1 / (D * np.sqrt(np.array(LAGS, float)))
    best = (np.inf, np.zeros(3), 0.0)
    for tau in TIMES:
        basis = np.stack([np.full(len(lags), 2.0), 2 * (1 - np.exp(-lags / tau)), lags**2], axis=1)
        found, left = nnls(basis * weight[:, None], D * weight)
        best = min(best, (float(left), found, tau), key=lambda trial: trial[0])
    _, (white, tinted, _), tau = best
    if tinted < LEAST_SHARE**2 * max(white, 1e-300):
        return float(np.sqrt(white)), 0.0, 0.0
    return float(np.sqrt(white)), float(np.sqrt(tinted)), tau * interval


def _structure(series: Sequence[Array], lag: int) -> float:
    """Mean squared difference over a lag; the largest hundredth (jumps, outliers) is left out."""
    squared = np.concatenate([(e[lag:] - e[:-lag]) ** 2 for e in series if len(e) > lag])
    squared = np.sort(squared[np.isfinite(squared)])
    return float(squared[: max(1, int(CLIP * len(squared)))].mean()) / 0.93 if len(squared) else np.nan
