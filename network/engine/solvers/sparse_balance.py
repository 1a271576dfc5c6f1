"""The conductances of a large network of links alone, as a sparse matrix, and what solves with it shifted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.network import Network

NARROW = 48
"""Bandwidth up to which a banded factor is faster than a sparse one."""
Solve = Callable[[Array], Array]


def sparse_matrix(network: Network, u: Inputs) -> Any:
    """K [W/K] of a network whose flows are links that read nothing: heat into the lumps = K T, sparse N×N."""
    N, rows, columns, values = network.size, [], [], []
    for flows in network.flows:
        by_a, by_b = (flows.w * slope for slope in flows.slopes(np.zeros(N), u))
        rows += [flows.b, flows.b, flows.a, flows.a]
        columns += [flows.a, flows.b, flows.a, flows.b]
        values += [by_a, by_b, -by_a, -by_b]
    if not values:
        return csr_matrix((N, N))
    return csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (N, N))


class ShiftedMatrix:
    """A symmetric positive matrix A to which a multiple of 1 is added: banded after a permutation, or sparse."""

    def __init__(self, A: Any) -> None:
        self.order = np.asarray(reverse_cuthill_mckee(csr_matrix(A), symmetric_mode=True))
        self.A = csr_matrix(A)[self.order][:, self.order]
        found = coo_matrix(self.A)
        self.width = int(np.abs(found.row - found.col).max(initial=0))
        self.band = self._as_band(found) if self.width <= NARROW else None

    def _as_band(self, found: Any) -> Array:
        below = found.row >= found.col
        band = np.zeros((self.width + 1, found.shape[0]), order="F")
        band[(found.row - found.col)[below], found.col[below]] = found.data[below]
        return band

    def factorise(self, shift: float) -> Solve | None:
        """What solves (A + shift) x = b, in the order of the permutation; None where it is not positive."""
        if self.band is None:
            options = {"SymmetricMode": True}
            by = splu((self.A + diags(np.full(self.A.shape[0], shift))).tocsc(), "MMD_AT_PLUS_A", 0.0, options=options)
            return lambda b: np.asarray(by.solve(b))
        shifted = self.band.copy(order="F")
        shifted[0] += shift
        factor, info = dpbtrf(shifted, lower=1, overwrite_ab=1)
        return (lambda b: np.asarray(dpbtrs(factor, b, lower=1)[0])) if info == 0 else None
