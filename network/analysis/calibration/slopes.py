"""Slopes of all runs by everything that is uncertain, and what follows from them alone; dear, so that fits share them.

They have an arrow's shape: parameters and offsets touch all runs, starts and jumps their own run only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from network.analysis.calibration.arrow_matrix import Folded, Part, fold_nuisances
from network.catalogue.declaration.declare import Array


@dataclass(frozen=True, eq=False)
class Slopes:
    """parts: run by run; free: parameters; shared: these and the offsets; count: these and all other nuisances;
    precisions, foldings: what was worked out for some 1σ of the priors."""

    parts: tuple[Part, ...]
    free: int
    shared: int
    count: int
    precisions: dict[bytes, Array] = field(default_factory=dict, repr=False)
    foldings: dict[bytes, Folded] = field(default_factory=dict, repr=False)

    def precision(self, spread: Array) -> Array:
        """Inverse posterior covariance of (θ, η), linearised, under priors of some 1σ."""
        key = spread.tobytes()
        if key not in self.precisions:
            self.precisions[key] = np.asarray(self.normal + np.diag(spread**-2.0))
        return self.precisions[key]

    def fold(self, spread: Array) -> Folded:
        """The same with the runs' own nuisances folded in."""
        key = spread.tobytes()
        if key not in self.foldings:
            self.foldings[key] = fold_nuisances(self.free, self.parts, spread**-2.0)
        return self.foldings[key]

    @cached_property
    def blocks(self) -> tuple[tuple[slice, slice], ...]:
        """Of every run: its rows, and its own nuisances; the other runs' slopes are zero there."""
        pairs, row, column = [], 0, self.shared
        for part in self.parts:
            own, rows = part.by_own.shape
            pairs.append((slice(row, row + rows), slice(column, column + own)))
            row, column = row + rows, column + own
        return tuple(pairs)

    @property
    def rows(self) -> int:
        return sum(part.by_own.shape[1] for part in self.parts)

    @cached_property
    def matrix(self) -> Array:
        """Whitened ∂y/∂(θ, η), (parameters + nuisances, rows)."""
        slopes = np.zeros((self.count, self.rows))
        for (rows, own), part in zip(self.blocks, self.parts, strict=True):
            slopes[: self.free, rows], slopes[own, rows] = part.by_theta, part.by_own
            slopes[self.free : self.shared, rows] = part.by_offset
        return slopes

    @cached_property
    def normal(self) -> Array:
        """SᵀS without the prior."""
        k, total = self.shared, np.zeros((self.count,) * 2)
        for (_, own), part in zip(self.blocks, self.parts, strict=True):
            total[:k, :k] += part.shared
            total[own, :k], total[:k, own], total[own, own] = part.across, part.across.T, part.by_eta[2]
        return total

    def along(self, values: Array) -> Array:
        """S applied to whitened rows: (parameters + nuisances)."""
        n, k, total = self.free, self.shared, np.zeros(self.count)
        for (rows, own), part in zip(self.blocks, self.parts, strict=True):
            total[:n] += part.by_theta @ values[rows]
            total[n:k] += part.by_offset @ values[rows]
            total[own] = part.by_own @ values[rows]
        return total

    def against(self, rows: Sequence[Array]) -> Array:
        """Whitened rows of each run times Sᵀ: (rows, parameters + nuisances)."""
        n, k, parts = self.free, self.shared, []
        for (_, own), part, values in zip(self.blocks, self.parts, rows, strict=True):
            mine = np.zeros((len(values), self.count))
            mine[:, :n], mine[:, n:k] = values @ part.by_theta.T, values @ part.by_offset.T
            mine[:, own] = values @ part.by_own.T
            parts.append(mine)
        return np.concatenate(parts)

    def apply(self, eta: Array) -> Array:
        """Whitened rows that nuisances bring."""
        total, offsets = np.empty(self.rows), self.shared - self.free
        for (rows, own), part in zip(self.blocks, self.parts, strict=True):
            mine = eta[own.start - self.free : own.stop - self.free]
            total[rows] = eta[:offsets] @ part.by_offset + mine @ part.by_own
        return total


@dataclass(frozen=True, eq=False)
class Rows:
    """A whitened residual z − y(θ) beside the slopes. mean: prior means of η."""

    slopes: Slopes
    residual: Array
    mean: Array

    @cached_property
    def at_mean(self) -> Array:
        """The residual with the nuisances at their prior means."""
        return np.asarray(self.residual - self.slopes.apply(self.mean))

    @cached_property
    def toward(self) -> Array:
        return self.slopes.along(self.at_mean)
