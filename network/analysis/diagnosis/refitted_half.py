"""One half of the recordings with all that is uncertain refitted to its rows alone: what a shape scores there, and how
sure that is.

S slopes of the half's rows, V covariance of the priors, P = SSᵀ + V⁻¹, M = I − SᵀP⁻¹S. With g = dᵀr and κ = dᵀMd of a
shape d (whitened), r what a full step on these rows leaves, the fit with d beside the rest leaves
r₁ = r − (g/κ) M d, and

    t = g / √(κ |r₁|² / ν),   ν = n_eff − p − 1,   n_eff = Σ n / (1 + 2 Σ ρ_l),   p = tr(I − M),

which without d is Student's with ν degrees of freedom: t² is F = (RSS₀ − RSS₁) / [RSS₁ / ν]. Sources: Davidson &
MacKinnon, Econometric Theory and Methods (2004), ch. 15; LISDD, arXiv 2606.23215 (n_eff in F); unverified.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import solve_triangular
from scipy.stats import t as student

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

    def test(self, shape: Array, sign: float) -> float:
        """p-value of a shape (all rows) that may only be there with a sign."""
        d = shape[self.rows]
        along = solve_triangular(self.root, self.slopes @ d, lower=True)
        lean = d - solve_triangular(self.root, along, lower=True, trans=1) @ self.slopes
        g, kappa = float(d @ self.left), float(d @ lean)
        rest = self.left - g / kappa * lean
        free = max(effective_samples([rest[own] for own in self.series]) - self.taken - 1, 1.0)
        return float(student.sf(sign * g / np.sqrt(kappa * float(rest @ rest) / free), free))


def _runs_of(labels: Array) -> Iterator[slice]:
    """Where one label after the other stands."""
    edges = [0, *(np.flatnonzero(np.diff(labels)) + 1).tolist(), len(labels)]
    yield from (slice(a, b) for a, b in pairwise(edges) if b > a)


def effective_samples(series: Sequence[Array]) -> float:
    """Σ n / (1 + 2 Σ ρ_l) of some series, ρ about zero, over the lags before the first that is not positive."""
    return sum(len(x) / (1 + 2 * _lasting(x)) for x in series)


def _lasting(x: Array) -> float:
    size = 2 * len(x)
    along = np.fft.irfft(np.abs(np.fft.rfft(x, size)) ** 2, size)[: len(x)]
    if not along[0] > 0:
        return 0.0
    rho = along[1:] / along[0]
    ends = np.flatnonzero(rho <= 0)
    return float(rho[: ends[0] if len(ends) else len(rho)].sum())
