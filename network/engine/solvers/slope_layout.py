"""How the Jacobian of a network is laid out so that it is filled and factored fast: dense, in a band, or sparse.

A tree or a chain of lumps is a narrow band after a permutation (reverse Cuthill–McKee), which factors in O(N).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs, dgetrf, dgetrs

from network.catalogue.declaration.declare import Array, Indices

FEW = 60
"""Unknowns up to which a full matrix is fastest."""
NARROW = 40
"""Bandwidth up to which a band is faster than a sparse factor."""
Solve = Callable[[Array], Array]


class Layout(ABC):
    """Places for the slopes ∂f_i/∂x_j of n unknowns. count: of all places; column: that each place belongs to."""

    count: int
    column: Indices

    @abstractmethod
    def places(self, rows: Indices, columns: Indices) -> Indices:
        """Where the slopes of rows by columns stand."""

    @abstractmethod
    def factorise(self, diagonal: Array, slopes: Array) -> Solve:
        """What solves (diagonal − J) x = b."""


class Dense(Layout):
    def __init__(self, n: int) -> None:
        self.n, self.count, self.column = n, n * n, np.repeat(np.arange(n), n)

    def places(self, rows: Indices, columns: Indices) -> Indices:
        return columns * self.n + rows

    def factorise(self, diagonal: Array, slopes: Array) -> Solve:
        matrix = np.negative(slopes)
        matrix[:: self.n + 1] += diagonal
        factor, pivots, _ = dgetrf(matrix.reshape(self.n, self.n, order="F"), overwrite_a=1)
        return lambda b: np.asarray(dgetrs(factor, pivots, b)[0])


class Banded(Layout):
    """order: the unknowns in their order along the band; width: diagonals on either side."""

    def __init__(self, order: Indices, width: int) -> None:
        n, self.order, self.width, self.height = len(order), order, width, 3 * width + 1
        self.rank = np.empty(n, int)
        self.rank[order] = np.arange(n)
        self.n, self.count, self.column = n, n * self.height, np.repeat(order, self.height)

    def places(self, rows: Indices, columns: Indices) -> Indices:
        i, j = self.rank[rows], self.rank[columns]
        return np.asarray(j * self.height + 2 * self.width + i - j)

    def factorise(self, diagonal: Array, slopes: Array) -> Solve:
        band = np.negative(slopes)
        band[2 * self.width :: self.height] += diagonal[self.order]
        shaped = band.reshape(self.height, self.n, order="F")
        factor, pivots, _ = dgbtrf(shaped, self.width, self.width, overwrite_ab=1)

        def solve(b: Array) -> Array:
            x = np.empty(self.n)
            x[self.order] = dgbtrs(factor, self.width, self.width, b[self.order], pivots)[0]
            return x

        return solve


class Sparse(Layout):
    """indptr, indices: of the pattern by columns, the diagonal in it."""

    def __init__(self, n: int, rows: Indices, columns: Indices) -> None:
        own = np.arange(n)
        keys = np.unique(np.concatenate([columns, own]) * n + np.concatenate([rows, own]))
        self.n, self.keys, self.count, self.column = n, keys, len(keys), keys // n
        self.indices, self.indptr = keys % n, np.searchsorted(keys // n, np.arange(n + 1))
        self.diagonal = self.places(own, own)

    def places(self, rows: Indices, columns: Indices) -> Indices:
        return np.searchsorted(self.keys, columns * self.n + rows)

    def factorise(self, diagonal: Array, slopes: Array) -> Solve:
        from scipy.sparse import csc_matrix
        from scipy.sparse.linalg import splu

        data = np.negative(slopes)
        data[self.diagonal] += diagonal
        return splu(csc_matrix((data, self.indices, self.indptr), (self.n, self.n)), "MMD_AT_PLUS_A").solve  # type: ignore[no-any-return]


def lay_out(n: int, rows: Indices, columns: Indices) -> Layout:
    """The layout for n unknowns whose slopes stand in some rows and columns."""
    if n <= FEW:
        return Dense(n)
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    pattern = csr_matrix((np.ones(2 * len(rows)), (np.append(rows, columns), np.append(columns, rows))), (n, n))
    band = Banded(np.asarray(reverse_cuthill_mckee(pattern, symmetric_mode=True), int), 0)
    width = int(np.abs(band.rank[rows] - band.rank[columns]).max(initial=0))
    return Banded(band.order, width) if width <= NARROW else Sparse(n, rows, columns)
