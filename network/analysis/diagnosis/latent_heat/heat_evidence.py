"""Heat f ~ OU(σ, ℓ) at the knots of some runs: the log evidence that it gains over no such heat, and its course.

With its answers G (whitened) and the parameters free again (M as in the screening), g = Gᵀr, H = GᵀMG and K = σ² L Lᵀ =
σ² e^(−|t − t'|/ℓ): ½ (gᵀ B g − log |I + K H|), B = (K⁻¹ + H)⁻¹ = σ² L (I + σ² Lᵀ H L)⁻¹ Lᵀ; Lᵀ H L is found once for
every ℓ. f is B g. Source: latent force models, Alvarez, Luengo & Lawrence, IEEE Trans. PAMI 35 (2013) 2693; unverified.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag, cho_solve, cholesky, solve_triangular

from network.analysis.diagnosis.latent_heat.unknown_heat import ou
from network.catalogue.declaration.declare import Array

TIMES = (600.0, 5400.0, 43200.0)
"""Correlation times tried [s]."""


@dataclass(frozen=True, eq=False)
class ExplainedHeat:
    """Log evidence gained by heat of a 1σ and a correlation time, with L Lᵀ of its knots, Lᵀ g and the root of
    I + σ² Lᵀ H L."""

    gain: float
    size: float
    ell: float
    roots: Roots
    toward: Array
    root: Array

    @property
    def course(self) -> Array:
        """Posterior mean at the knots."""
        return self.size**2 * self.roots(cho_solve((self.root, True), self.toward))

    @property
    def std(self) -> Array:
        """Posterior 1σ at the knots."""
        inner = solve_triangular(self.root, self.roots.whole.T, lower=True)
        return np.asarray(self.size * np.sqrt(np.sum(inner**2, axis=0)))


def explain_best(H: Array, g: Array, knots: Sequence[Array], sizes: Sequence[float]) -> ExplainedHeat:
    """The best of all sizes and times."""
    tried: list[ExplainedHeat] = []
    for ell in TIMES:
        roots = roots_of(knots, ell)
        inner, toward = roots.transposed(roots.transposed(H).T), roots.transposed(g)
        tried += [ExplainedHeat(gain, size, ell, roots, toward, root)
                  for size in sizes for gain, root in [gain_of(inner, toward, size)]]  # fmt: skip
    return max(tried, key=lambda each: each.gain)


def roots_of(knots: Sequence[Array], ell: float) -> Roots:
    return Roots([np.asarray(cholesky(ou(t, ell), lower=True)) for t in knots])


def gain_of(inner: Array, toward: Array, size: float) -> tuple[float, Array]:
    """Log evidence gained by heat of a 1σ, and the root R Rᵀ = I + σ² Lᵀ H L; inner: Lᵀ H L, toward: Lᵀ g."""
    root = np.asarray(cholesky(np.eye(len(inner)) + size**2 * inner, lower=True))
    felt = size * solve_triangular(root, toward, lower=True)
    return 0.5 * float(felt @ felt) - float(np.log(np.diag(root)).sum()), root


@dataclass(frozen=True, eq=False)
class Roots:
    """L of the correlation L Lᵀ of heat at the knots of all runs, which has a block for each run."""

    blocks: Sequence[Array]

    @property
    def rows(self) -> Iterator[slice]:
        return (slice(a, b) for a, b in pairwise(np.cumsum([0, *(len(block) for block in self.blocks)]).tolist()))

    @property
    def whole(self) -> Array:
        return np.asarray(block_diag(*self.blocks))

    def __call__(self, values: Array) -> Array:
        """L applied to values."""
        return np.concatenate([block @ values[own] for own, block in zip(self.rows, self.blocks, strict=True)])

    def transposed(self, values: Array) -> Array:
        """Lᵀ applied to values."""
        return np.concatenate([block.T @ values[own] for own, block in zip(self.rows, self.blocks, strict=True)])
