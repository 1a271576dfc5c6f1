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
    """decay, mean (cells, n): of a state at the beginning of each cell; A, B (cells, 2 r, n): of q₀ at its intervals,
    then of q₁; index (cells, r): its intervals, padded with the number of all."""

    decay: Array
    mean: Array
    A: Array
    B: Array
    index: Indices

    def average_modes(self, q0: Array, q1: Array, by: Array, start: Array) -> tuple[Array, Array]:
        """Means of the modes (cells, pushes, n), and modal states after the last cell (pushes, n), from series
        (intervals, pushes) that go into the modes by `by` (pushes, n)."""
        padded = [np.vstack([q, np.zeros((1, q.shape[1]))])[self.index] for q in (q0, q1)]
        q = np.concatenate(padded, axis=1).transpose(0, 2, 1)
        push, own = q @ self.A, q @ self.B
        push, own = push * by, own * by
        m, end = recur(self.decay, push, start)
        own += self.mean[:, None] * m
        return own, end


def cells_of(starts: Indices, gain: Array, c0: Array, c1: Array, E: Array, F0: Array, F1: Array) -> Cells | None:
    """The cells that begin at some intervals; None where one holds too many. All others: (intervals, n)."""
    counts = np.diff(np.append(starts, len(gain)))
    r = int(counts.max())
    if r > MOST_INTERVALS:
        return None
    place = np.arange(r)
    index = np.where(place < counts[:, None], starts[:, None] + place, len(gain))
    keep = np.vstack([gain, np.ones(gain.shape[1])])[index]
    c0, c1, E, F0, F1 = (np.vstack([f, np.zeros(f.shape[1])])[index] for f in (c0, c1, E, F0, F1))
    shape = len(starts), 2 * r, gain.shape[1]
    A, B = np.empty(shape, gain.dtype), np.empty(shape, E.dtype)
    later, mean = np.ones_like(keep[:, 0]), np.zeros_like(E[:, 0])
    for j in range(r - 1, -1, -1):
        A[:, j], A[:, r + j] = c0[:, j] * later, c1[:, j] * later
        B[:, j], B[:, r + j] = F0[:, j] + c0[:, j] * mean, F1[:, j] + c1[:, j] * mean
        mean = E[:, j] + keep[:, j] * mean
        later = keep[:, j] * later
    return Cells(later, mean, A, B, index)


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
