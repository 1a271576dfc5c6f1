"""The spectrum that slow drift and noise would have without any period: AR(1) plus white noise."""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array, Indices

CORNERS, SHARES = 28, 30
CLIPPED = 3.0
"""A group counts at most this often its background: a peak must not raise what it is measured against."""
BESIDE = 3


def background(power: Array, n: int) -> Array:
    """B_k for k = 1 … K of a periodogram of n samples: w + a (1−ρ²)/(1 + ρ² − 2ρ cos 2πk/n), by Whittle's likelihood.

    Σ_j n_j (ln B_j + P_j/B_j) is least over a grid of ρ and a/w, the scale in closed form; P_j are single frequencies
    at the low end and medians of neighbours further up. Whittle, Ark. Mat. 2 (1953) 423; peaks judged against a red
    background with medians: Mann and Lees, Climatic Change 33 (1996) 409.
    """
    first, sizes = _groups(len(power))
    grouped = _typical(power, first, sizes)
    corners = np.geomspace(0.5 / n, 0.3, CORNERS)
    shares = np.concatenate([[0.0], np.geomspace(1e-5, 1.0, SHARES)])
    middle = (first + (sizes + 1) / 2) / n
    red = np.stack([_red(middle, corner) for corner in corners])
    shapes = (shares[:, None, None] + (1 - shares)[:, None, None] * red).reshape(-1, len(first))
    best, scale = _fit(_smooth_by_medians(grouped), sizes, shapes)
    best, scale = _fit(np.minimum(grouped, CLIPPED * scale * shapes[best]), sizes, shapes)
    share, corner = shares[best // CORNERS], corners[best % CORNERS]
    return np.asarray(scale * (share + (1 - share) * _red(np.arange(1, len(power) + 1) / n, corner)))


def _red(frequency: Array, corner: float) -> Array:
    """Spectrum of AR(1) of variance 1; frequency in cycles per sample, ρ = exp(−2π corner)."""
    rho = np.exp(-2 * np.pi * corner)
    return np.asarray((1 - rho**2) / ((1 - rho) ** 2 + 4 * rho * np.sin(np.pi * frequency) ** 2))


def _groups(count: int) -> tuple[Indices, Indices]:
    """(first, size) of groups of frequencies: single up to the eighth, then wider by a fifth each."""
    edges = list(range(min(8, count)))
    while edges[-1] + max(1, edges[-1] // 5) < count:
        edges.append(edges[-1] + max(1, edges[-1] // 5))
    first = np.array(edges, dtype=np.intp)
    return first, np.diff(first, append=count)


def _typical(power: Array, first: Indices, sizes: Indices) -> Array:
    """Means of groups, from five members on by the median, which a peak does not move (ln 2 of an exponential's mean,
    a little more for few)."""
    groups = [power[a : a + size] for a, size in zip(first, sizes, strict=True)]
    return np.array([np.median(g) / (np.log(2) + 0.5 / len(g)) if len(g) >= 5 else g.mean() for g in groups])


def _smooth_by_medians(grouped: Array) -> Array:
    """Medians over a few groups on either side: a first guess that no peak raises."""
    padded = np.pad(grouped, BESIDE, constant_values=np.nan)
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * BESIDE + 1)
    return np.asarray(np.nanmedian(around, axis=1))


def _fit(grouped: Array, sizes: Indices, shapes: Array) -> tuple[int, float]:
    """(row of shapes, scale) of the greatest likelihood."""
    scales = (grouped / shapes) @ sizes / sizes.sum()
    cost = np.log(shapes) @ sizes + sizes.sum() * np.log(np.maximum(scales, 1e-300))
    best = int(np.argmin(cost))
    return best, float(scales[best])
