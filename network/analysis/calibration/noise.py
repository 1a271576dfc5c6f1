"""The noise a residual may have without accusing anybody, Σ = white + coloured.

Coloured: each sensor's own Ornstein-Uhlenbeck (OU) process, variance s², correlation e^(−|t − t'|/τ).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.ornstein_uhlenbeck import correlate_cell_means
from network.catalogue.declaration.declare import Array, Indices

REMEMBERED = 64
"""Roots of coloured covariances."""


@dataclass(frozen=True)
class Noise:
    """coloured: channel → (1σ in SI, correlation time [s])."""

    coloured: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Whitener:
    """L⁻¹ with L Lᵀ = Σ over the cells that hold samples. roots: of the blocks of Σ one after the other, each L, or 1σ
    where a block is diagonal."""

    known: Array
    roots: tuple[Array, ...]

    @cached_property
    def blocks(self) -> tuple[tuple[slice, Array], ...]:
        """Each root with its rows."""
        ends = np.cumsum([0, *(len(root) for root in self.roots)]).tolist()
        return tuple((slice(a, b), root) for a, b, root in zip(ends[:-1], ends[1:], self.roots, strict=True))

    @property
    def log_determinant(self) -> float:
        """log |Σ|."""
        return 2 * sum(float(np.log(root if root.ndim == 1 else np.diag(root)).sum()) for root in self.roots)

    def __call__(self, values: Array) -> Array:
        """L⁻¹ applied to values over all cells (…, cells): (…, known cells)."""
        return self.again(values if self._all_known else values[..., self.known])

    @cached_property
    def _all_known(self) -> bool:
        return bool(np.all(self.known)) and self.known.dtype == bool

    def again(self, own: Array) -> Array:
        """L⁻¹ applied to values over the cells that hold samples (…, known cells)."""
        out = np.empty(own.shape)
        for rows, root in self.blocks:
            out[..., rows] = own[..., rows] / root if root.ndim == 1 else _solve_lower(root, own[..., rows])
        return out

    def of_channel(self, i: int, values: Array) -> tuple[slice, Array]:
        """L⁻¹ applied to values over all cells of one channel (…, cells of a channel): its rows, and what is there."""
        cells = len(self.known) // len(self.roots)
        (rows, root), own = self.blocks[i], values[..., self.known[i * cells : (i + 1) * cells]]
        return rows, own / root if root.ndim == 1 else _solve_lower(root, own)

    def colour(self, values: Array) -> Array:
        """L applied to whitened values (…, known cells)."""
        out = np.empty(values.shape)
        for rows, root in self.blocks:
            out[..., rows] = values[..., rows] * root if root.ndim == 1 else values[..., rows] @ root.T
        return out


def _solve_lower(root: Array, values: Array) -> Array:
    flat = values.reshape(-1, values.shape[-1])
    return np.asarray(solve_triangular(root, flat.T, lower=True, check_finite=False).T.reshape(values.shape))


def whitener(data: Measured, noise: Noise) -> Whitener:
    """The whitening of one run."""
    variance = data.variance
    return Whitener(data.known, tuple(_root_of(data, variance, noise, i) for i in range(len(data.run.channels))))


def _root_of(data: Measured, whole: Array, noise: Noise, i: int) -> Array:
    """The root of one channel's covariance; whole: white variances of all channels."""
    cells, name = data.run.knots.cells, data.run.channels[i]
    rows = slice(i * cells, (i + 1) * cells)
    variance, (s, tau) = whole[rows][data.known[rows]], noise.coloured.get(name, (0.0, 1.0))
    if not s:
        return np.asarray(np.sqrt(variance))
    t, cell = _samples(data, name)
    known = data.known[rows]
    return _factor(s, tau, t.tobytes(), cell.tobytes(), known.tobytes(), variance.tobytes())


@lru_cache(maxsize=REMEMBERED)
def _factor(s: float, tau: float, t: bytes, cell: bytes, known: bytes, variance: bytes) -> Array:
    """The same from what it depends on, which many fits of one case share."""
    of = np.frombuffer(known, bool)
    shape = correlate_cell_means(np.frombuffer(t), np.frombuffer(cell, int), len(of), tau)
    return np.asarray(cholesky(np.diag(np.frombuffer(variance)) + s * s * shape[np.ix_(of, of)], lower=True))


def _samples(data: Measured, name: str) -> tuple[Array, Indices]:
    """Instants of the samples of a channel, and their cells."""
    knots, present = data.run.knots, data.run.present[name]
    return knots.samples[present], knots.cell_of[present]
