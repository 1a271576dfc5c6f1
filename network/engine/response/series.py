"""Pushes of one series of heat each: followed from cell to cell, with what its intervals do worked out beforehand.

Within a cell the intervals k bring Σ A₀ q₀ + A₁ q₁ into the modes at its end, and Σ B₀ q₀ + B₁ q₁ into their mean
beside what the state at its beginning gives: factors of interval and rate that all pushes share.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.response.recursion import recur

MOST_INTERVALS = 8
"""In one cell: beyond it this would be no less work."""


@dataclass(frozen=True, eq=False)
class Cells:
    """decay, mean (cells, n): of a state at the beginning of each cell; into (cells, 2 r, 2 n): of q₀ and q₁ at its
    intervals in turn, what goes into the modes (A), then into their mean (B); index (cells, r): its intervals, padded
    with the number of all."""

    decay: Array
    mean: Array
    into: Array
    index: Indices

    def average_modes(self, q0: Array, q1: Array, by: Array, start: Array) -> tuple[Array, Array]:
        """Means of the modes (cells, pushes, n), and modal states after the last cell (pushes, n), from series
        (intervals, pushes) that go into the modes by `by` (pushes, n)."""
        (K, pushes), n = q0.shape, by.shape[1]
        q = np.zeros((K + 1, 2, pushes))
        q[:K, 0], q[:K, 1] = q0, q1
        heat = q.take(self.index, axis=0).reshape(len(self.index), -1, pushes)
        both = (heat.transpose(0, 2, 1) @ self.into).reshape(len(heat), pushes, 2, n)
        push, own = both[:, :, 0] * by, both[:, :, 1] * by
        m, end = recur(self.decay, push, start)
        m *= self.mean[:, None]
        own += m
        return own, end


def cells_of(starts: Indices, gain: Array, c0: Array, c1: Array, E: Array, F0: Array, F1: Array) -> Cells | None:
    """The cells that begin at some intervals; None where one holds too many. All others: (intervals, n)."""
    (K, n), counts = gain.shape, np.diff(np.append(starts, len(gain)))
    r = int(counts.max())
    if r > MOST_INTERVALS:
        return None
    place = np.arange(r)
    index = np.where(place < counts[:, None], starts[:, None] + place, K)
    factors = np.zeros((6, K + 1, n), np.result_type(gain, E))
    for own, factor in zip(factors, (gain, c0, c1, E, F0, F1), strict=True):
        own[:K] = factor
    factors[0, K] = 1.0
    keep, c0, c1, E, F0, F1 = (own.take(index.T, axis=0) for own in factors)
    into = np.empty((len(starts), r, 2, 2, n), factors.dtype)
    later, mean = keep[r - 1], E[r - 1]
    into[:, r - 1, 0, 0], into[:, r - 1, 1, 0] = c0[r - 1], c1[r - 1]
    into[:, r - 1, 0, 1], into[:, r - 1, 1, 1] = F0[r - 1], F1[r - 1]
    for j in range(r - 2, -1, -1):
        into[:, j, 0, 0], into[:, j, 1, 0] = c0[j] * later, c1[j] * later
        into[:, j, 0, 1], into[:, j, 1, 1] = F0[j] + c0[j] * mean, F1[j] + c1[j] * mean
        mean = E[j] + keep[j] * mean
        later = keep[j] * later
    return Cells(later, mean, into.reshape(len(starts), 2 * r, 2 * n), index)


@cache
def compile_means() -> Callable[..., None] | None:
    """The same from interval to interval as machine code; None without numba."""
    try:
        from numba import njit
    except ImportError:
        return None

    @njit(cache=True, fastmath=False)  # type: ignore[untyped-decorator]
    def follow(
        cell: Indices, q0: Array, q1: Array, by: Array, gain: Array, c0: Array, c1: Array, E: Array, F0: Array,
        F1: Array, x: Array, out: Array,
    ) -> None:  # fmt: skip
        K, P = q0.shape
        n = gain.shape[1]
        for k in range(K):
            c = cell[k]
            for p in range(P):
                a, b = q0[k, p], q1[k, p]
                for i in range(n):
                    f = by[p, i]
                    out[c, p, i] += E[k, i] * x[p, i] + (F0[k, i] * a + F1[k, i] * b) * f
                    x[p, i] = gain[k, i] * x[p, i] + (c0[k, i] * a + c1[k, i] * b) * f

    return follow  # type: ignore[no-any-return]
