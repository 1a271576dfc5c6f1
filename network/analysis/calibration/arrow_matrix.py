"""Normal equations in the shape of an arrow: what all runs share, and what each has of its own, folded in run by run.

With D_r the precision of a run's own nuisances, E_r across and A of the shared ones, the own ones are eliminated by
L_r L_rᵀ = D_r, W_r = L_r⁻¹ E_r: A ← A − Σ W_rᵀ W_r. Source: Golub & Van Loan, Matrix Computations, 4th ed., sec. 4.5
(block elimination).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtrs

from network.catalogue.declaration.declare import Array


@dataclass(frozen=True, eq=False)
class OwnPart:
    """Whitened slopes of one run over its rows by η: by the offsets, and by its own nuisances."""

    by_offset: Array
    by_own: Array

    @cached_property
    def products(self) -> tuple[Array, Array, Array]:
        """Of offsets and own nuisances: among the first, across, among the second."""
        return self.by_offset @ self.by_offset.T, self.by_offset @ self.by_own.T, self.by_own @ self.by_own.T


@dataclass(frozen=True, eq=False)
class Part:
    """Whitened slopes of one run over its rows: by θ, and by η."""

    by_theta: Array
    eta: OwnPart

    @property
    def by_offset(self) -> Array:
        return self.eta.by_offset

    @property
    def by_own(self) -> Array:
        return self.eta.by_own

    @property
    def by_eta(self) -> tuple[Array, Array, Array]:
        return self.eta.products

    @cached_property
    def of_theta(self) -> tuple[Array, Array, Array]:
        """Products of the slopes by θ: among themselves, with offsets, with own nuisances."""
        return self.by_theta @ self.by_theta.T, self.by_theta @ self.by_offset.T, self.by_theta @ self.by_own.T

    @cached_property
    def shared(self) -> Array:
        """Products among θ and offsets."""
        among, across, _ = self.of_theta
        return np.block([[among, across], [across.T, self.by_eta[0]]])

    @cached_property
    def across(self) -> Array:
        """Products of own nuisances with θ and offsets (own, shared)."""
        return np.hstack([self.of_theta[2].T, self.by_eta[1].T])


@dataclass(frozen=True, eq=False)
class Folded:
    """roots L_r and ways W_r of the runs; shared: what is left of the precision of θ and offsets."""

    free: int
    roots: tuple[Array, ...]
    ways: tuple[Array, ...]
    shared: Array

    @cached_property
    def log_determinant(self) -> float:
        """Of the whole precision."""
        own = sum(2 * float(np.log(np.diag(root)).sum()) for root in self.roots)
        return own + float(np.linalg.slogdet(self.shared)[1])

    @cached_property
    def _offsets(self) -> Array:
        return _root(self.shared[self.free :, self.free :])

    def solve(self, ahead: Array, own: Sequence[Array]) -> tuple[Array, float, Array, Array]:
        """Most probable nuisances at a fixed θ (offsets, then run by run), by how much they lower J, and the precision
        and −½ gradient of J in θ with the nuisances following; ahead, own: −½ gradient by θ and offsets, by own."""
        n = self.free
        felt = [_forward(root, g) for root, g in zip(self.roots, own, strict=True)]
        left = ahead - sum((way.T @ u for way, u in zip(self.ways, felt, strict=True)), np.zeros(len(ahead)))
        half = _forward(self._offsets, np.column_stack([self.shared[n:, :n], left[n:]]))
        offsets = _backward(self._offsets, half[:, n])
        runs = zip(self.roots, self.ways, felt, strict=True)
        following = [_backward(root, u - way[:, n:] @ offsets) for root, way, u in runs]
        lower = sum(float(u @ u) for u in felt) + float(half[:, n] @ half[:, n])
        precision, gradient = self.shared[:n, :n] - half[:, :n].T @ half[:, :n], left[:n] - half[:, :n].T @ half[:, n]
        return np.concatenate([offsets, *following]), lower, precision, gradient


def _root(matrix: Array) -> Array:
    """L with L Lᵀ = matrix. By LAPACK itself: these are small and many, and scipy's own ways in take longer than they.
    Raises LinAlgError where it is not positive."""
    if not len(matrix):
        return matrix
    root, info = dpotrf(matrix, lower=1)
    if info:
        raise np.linalg.LinAlgError(f"the precision is not positive in row {info}")
    return np.asarray(root)


def _forward(root: Array, right: Array) -> Array:
    return np.asarray(dtrtrs(root, right, lower=1)[0]) if len(root) else right


def _backward(root: Array, right: Array) -> Array:
    return np.asarray(dtrtrs(root, right, lower=1, trans=1)[0]) if len(root) else right


def fold_nuisances(free: int, parts: Sequence[Part], weights: Array) -> Folded:
    """The precision with priors of weights 1/σ² on θ, offsets, and the runs' own nuisances in turn."""
    k = free + len(parts[0].by_offset) if parts else free
    shared, roots, ways, first = np.diag(weights[:k]), [], [], k
    for part in parts:
        last = first + len(part.by_own)
        root = _root(part.by_eta[2] + np.diag(weights[first:last]))
        way = _forward(root, part.across)
        shared = shared + part.shared - way.T @ way
        roots.append(root)
        ways.append(way)
        first = last
    return Folded(free, tuple(roots), tuple(ways), shared)
