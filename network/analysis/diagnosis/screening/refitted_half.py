"""Some rows of a linear problem with all that is uncertain refitted to them alone: what a shape scores there.

S slopes of the rows, V covariance of the priors, P = SSᵀ + V⁻¹, M = I − SᵀP⁻¹S. A shape d (whitened) scores g = dᵀr,
κ = dᵀMd, r what a full step on these rows leaves; with d beside the rest r − (g/κ) M d is left. The refit takes
p = tr(I − M) degrees of freedom. Readings whose noise lasts count as n_eff = Σ n / (1 + 2 Σ ρ_l) ones. Source: score
test with nuisance parameters, Davidson & MacKinnon, Econometric Theory and Methods (2004), ch. 15; unverified.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import solve_triangular

from network.catalogue.declaration.declare import Array, Mask


@dataclass(frozen=True, eq=False)
class RefittedHalf:
    """rows: which of all; slopes: S (unknowns, n); root: L Lᵀ = P; left: r (n); weights: diagonal of V⁻¹; series: the
    rows of each channel of each run among these."""

    rows: Mask
    slopes: Array
    root: Array
    left: Array
    weights: Array
    series: tuple[slice, ...]

    @classmethod
    def of(cls, rows: Mask, slopes: Array, left: Array, strain: Array, spread: Array, series: Array) -> RefittedHalf:
        """slopes, left: of all rows, about some numbers x; strain: (x₀ − x)/σ of the priors; spread: their σ; series:
        label of the channel and run of each row. What no row of the half tells is left out."""
        own = slopes[:, rows]
        is_told = np.any(own != 0.0, axis=1)
        own, weights = own[is_told], spread[is_told] ** -2.0
        root = np.asarray(np.linalg.cholesky(own @ own.T + np.diag(weights)))
        pull = own @ left[rows] + (strain / spread)[is_told]
        step = solve_triangular(root, solve_triangular(root, pull, lower=True), lower=True, trans=1)
        return cls(rows, own, root, left[rows] - step @ own, weights, tuple(_runs_of(series[rows])))

    @cached_property
    def taken(self) -> float:
        """p: degrees of freedom that the refit takes, with what was known before."""
        inverse = solve_triangular(self.root, np.eye(len(self.root)), lower=True)
        return float(len(self.root) - np.sum(inverse**2 * self.weights))

    def score(self, shapes: Array) -> tuple[Array, Array]:
        """g and κ of shapes over all rows (shapes, all rows)."""
        own = shapes[:, self.rows]
        along = solve_triangular(self.root, self.slopes @ own.T, lower=True)
        return own @ self.left, np.einsum("ij,ij->i", own, own) - np.einsum("ji,ji->i", along, along)

    def rest(self, shape: Array) -> Array:
        """What is left of the rows with a shape (all rows) beside the rest, r − (g/κ) M d."""
        d = shape[self.rows]
        along = solve_triangular(self.root, self.slopes @ d, lower=True)
        lean = d - solve_triangular(self.root, along, lower=True, trans=1) @ self.slopes
        return np.asarray(self.left - float(d @ self.left) / float(d @ lean) * lean)


def _runs_of(labels: Array) -> Iterator[slice]:
    """Where one label after the other stands."""
    edges = [0, *(np.flatnonzero(np.diff(labels)) + 1).tolist(), len(labels)]
    yield from (slice(a, b) for a, b in pairwise(edges) if b > a)


def effective_samples(series: Sequence[Array]) -> float:
    """Σ n / (1 + 2 Σ ρ_l) of some series, ρ about zero, over the lags before the first that is not positive."""
    return sum(len(x) / (1 + 2 * _lasting(x)) for x in series)


def _lasting(x: Array) -> float:
    if not np.any(x):
        return 0.0
    size = 2 * len(x)
    along = np.fft.irfft(np.abs(np.fft.rfft(x, size)) ** 2, size)[: len(x)]
    rho = along[1:] / along[0]
    ends = np.flatnonzero(rho <= 0)
    return float(rho[: ends[0] if len(ends) else len(rho)].sum())
