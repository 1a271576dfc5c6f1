"""What is left of a difference when parameters and nuisances are refitted to it: M = I − Sᵀ(SSᵀ + V⁻¹)⁻¹S.

S: whitened slopes of the rows, V: covariance of the priors; M r = (I + SᵀVS)⁻¹ r.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array


@dataclass(frozen=True, eq=False)
class Projector:
    """slopes: S (parameters and nuisances, rows); precision: SSᵀ + V⁻¹."""

    slopes: Array
    precision: Array

    def project(self, rows: Array) -> Array:
        """M r of one or many (…, rows)."""
        return np.asarray(rows - np.linalg.solve(self.precision, self.slopes @ rows.T).T @ self.slopes)

    def misfit(self, rows: Array) -> float:
        """rᵀ M r."""
        g = self.slopes @ rows
        return float(rows @ rows - g @ np.linalg.solve(self.precision, g))

    def adjust(self, rows: Array, gradient: Array) -> tuple[Array, Array]:
        """The refit to rows (…, rows) where the priors pull with a `gradient`: by how much parameters and nuisances
        move, and by how much the misfit falls."""
        half = np.linalg.solve(self.root, (rows @ self.slopes.T + gradient).T)
        return np.linalg.solve(self.root.T, half).T, np.einsum("j...,j...->...", half, half)

    @cached_property
    def root(self) -> Array:
        """Lower Cholesky factor of the precision."""
        return np.asarray(np.linalg.cholesky(self.precision))
