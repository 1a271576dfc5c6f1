"""Autocorrelation with gaps, and how many independent samples two series are worth."""

from __future__ import annotations

import math

import numpy as np

from network.catalogue.declaration.declare import Array

SHARE = 0.25
"""Lags go up to this part of the length: further on there are too few pairs."""


def autocorrelations(values: Array, there: Array) -> tuple[Array, Array]:
    """(r, pairs) by row and lag: r_k = (Σ x_i x_{i+k} / pairs_k) / (Σ x² / pairs_0), over pairs that are both there.

    values, there: (rows, n) as `fill_gaps` gives them. Rows without any variation have r = 0 but r_0 = 1.
    """
    n = values.shape[-1]
    lags = max(int(n * SHARE), min(n - 1, 21))
    pairs = _sum_lagged_products(there, lags).round()
    if there.all():
        pairs = np.broadcast_to(n - np.arange(lags + 1.0), pairs.shape)
    mean = _sum_lagged_products(values, lags) / np.maximum(pairs, 1.0)
    scale = mean[:, :1]
    r = np.where((pairs > 0) & (scale > 0), mean / np.where(scale > 0, scale, 1.0), 0.0)
    r[:, 0] = 1.0
    return np.clip(r, -1.0, 1.0), np.asarray(pairs)


def _sum_lagged_products(rows: Array, lags: int) -> Array:
    """Σ_i x_i x_{i+k} for k = 0 … lags, by the Fourier transform."""
    length = quick_length(rows.shape[-1] + lags)
    power = np.abs(np.fft.rfft(rows, length)) ** 2
    return np.asarray(np.fft.irfft(power, length)[:, : lags + 1])


def quick_length(n: int) -> int:
    """The next length that the Fourier transform is quick at."""
    return min(m << max(math.ceil(math.log2(n / m)), 0) for m in (1, 3, 5, 9, 15))


def independent(r: Array, other: Array, n: Array) -> Array:
    """Independent samples in n of two series with autocorrelations r (rows, lags) and other (columns, lags).

    n_eff = n / (1 + 2 Σ_k (1 − k/n) r_k r'_k), at most n. Bartlett 1935; Pyper and Peterman, Can. J. Fish. Aquat. Sci.
    55 (1998) 2127. The sum ends where either series' own correlation has died out.
    """
    one, two = until_dead(r), until_dead(other)
    share = 1 - np.arange(one.shape[1]) / max(float(n.max()), 1.0)
    inflation = 1 + 2 * (one[:, 1:] * share[1:]) @ two[:, 1:].T
    return np.asarray(n / np.maximum(inflation, 1.0))


def until_dead(r: Array) -> Array:
    """r up to its first value that is not positive: beyond there are chance and trend alone."""
    alive = np.cumprod(r > 0, axis=1)
    return np.asarray(r * alive)
