"""Ridge regression on lagged inputs: what a line through the data tells without any physics.

Each input is passed through first-order lags, τ dx/dt = u − x. A sum of such lags is what any linear thermal network
answers with; how heat is stored and shared is left to the regression, which is why a network has to beat it. The
time constants lie a factor of three apart, from a motor's skin (5 min) over spindle and slides (45 and 135 min) to the
bed (400 min): a lag in between is a sum of its neighbours to a few per cent, and more of them are only more alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TIME_CONSTANTS = (300.0, 900.0, 2700.0, 8100.0, 24000.0)
"""s"""
STRENGTHS = tuple(float(s) for s in 10.0 ** np.arange(-4.0, 2.6, 0.5))
"""Tried for the regularisation, as shares of the number of samples (features are scaled to a variance of one)."""


@dataclass(frozen=True, eq=False)
class Run:
    """Features (samples × features) and targets (samples × targets) of one run; NaN in a target: not counted."""

    features: Array
    targets: Array

    @property
    def counted(self) -> Run:
        kept = np.isfinite(self.features).all(axis=1) & np.isfinite(self.targets).all(axis=1)
        return Run(self.features[kept], self.targets[kept])


@dataclass(frozen=True, eq=False)
class Ridge:
    """target = at_mean + (feature − mean)/scale · weights; strength: the regularisation of each target."""

    mean: Array
    scale: Array
    weights: Array
    at_mean: Array
    strength: tuple[float, ...]

    def predict(self, features: Array) -> Array:
        return np.asarray(self.at_mean + (features - self.mean) / self.scale @ self.weights)


@dataclass(frozen=True, eq=False)
class Sums:
    """What least squares needs of some runs, centred and in units of the features' scale: features' products, their
    products with the targets, and the number of samples."""

    mean: Array
    scale: Array
    at_mean: Array
    squares: Array
    products: Array
    n: int


def lagged(
    t: Array, inputs: Array, before: Array, *, held: bool = False, time_constants: Sequence[float] = TIME_CONSTANTS
) -> Array:
    """The inputs (samples × inputs) and their lags: samples × (inputs · (1 + lags)), input by input.

    t: [s]; before: each input's value for ever before the first sample; held: it keeps its value until the next sample,
    else it runs straight. Exact for either, at any spacing of the samples.
    """
    tau = np.asarray(time_constants, dtype=np.float64)
    state = np.repeat(np.asarray(before, dtype=np.float64)[:, None], len(tau), axis=1)
    out = np.empty((len(t), inputs.shape[1], 1 + len(tau)))
    out[:, :, 0], out[0, :, 1:] = inputs, state
    for k, dt in enumerate(np.diff(t)):
        here, slope = inputs[k, :, None], np.zeros((inputs.shape[1], 1))
        if not held:
            slope = (inputs[k + 1, :, None] - here) / dt
        state = here + slope * (dt - tau) + (state - here + slope * tau) * np.exp(-dt / tau)
        out[k + 1, :, 1:] = state
    return out.reshape(len(t), -1)


def fit_ridge(runs: Sequence[Run], strengths: Sequence[float] = STRENGTHS) -> Ridge:
    """Ridge with an intercept, its strength for each target the one that tells left-out runs best.

    Each run is left out in turn; a run counts by its mean square, not by its number of samples. With a single run the
    weakest strength is taken.
    """
    counted = [run.counted for run in runs]
    misses = np.zeros((len(strengths), counted[0].targets.shape[1]))
    for k, left_out in enumerate(counted):
        others = counted[:k] + counted[k + 1 :]
        if others and len(left_out.targets):
            misses += [np.mean((r.predict(left_out.features) - left_out.targets) ** 2, axis=0)
                       for r in solved(sums(others), strengths)]  # fmt: skip
    best = np.argmin(misses, axis=0)
    fits = solved(sums(counted), strengths)
    weights = np.stack([fits[b].weights[:, k] for k, b in enumerate(best)], axis=1)
    any_fit = fits[0]
    return Ridge(any_fit.mean, any_fit.scale, weights, any_fit.at_mean, tuple(strengths[b] for b in best))


def sums(runs: Sequence[Run]) -> Sums:
    features, targets = (np.concatenate([getattr(run, name) for run in runs]) for name in ("features", "targets"))
    mean, at_mean, scale = features.mean(axis=0), targets.mean(axis=0), features.std(axis=0)
    scale[scale < 1e-9 * (1 + np.abs(mean))] = np.inf  # a feature that never moves tells nothing
    scaled = (features - mean) / scale
    return Sums(mean, scale, at_mean, scaled.T @ scaled, scaled.T @ (targets - at_mean), len(targets))


def solved(of: Sums, strengths: Sequence[float]) -> list[Ridge]:
    """One for each strength, all targets at once."""
    values, vectors = np.linalg.eigh(of.squares)
    turned = vectors.T @ of.products
    fits = []
    for strength in strengths:
        weights = vectors @ (turned / (np.maximum(values, 0) + strength * of.n)[:, None])
        fits.append(Ridge(of.mean, of.scale, weights, of.at_mean, (strength,) * weights.shape[1]))
    return fits
