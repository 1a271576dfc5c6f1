"""Pushes of one series of heat each: followed from piece to piece, with what its intervals do worked out beforehand.

Within a piece, a cell or a part of a long one, the intervals k bring Σ A₀ q₀ + A₁ q₁ into the modes at its end, and
Σ B₀ q₀ + B₁ q₁ into their mean beside what the state at its beginning gives: factors of interval and rate that all
pushes share.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.response.cells import sum_rows
from network.engine.response.recursion import recur
from network.engine.response.segments import as_modes
from network.engine.solvers.modal import Modes

MOST_INTERVALS = 8
"""In one piece (measured: 6 to 30 take the same time to a fifth)."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Of a whole run. decay, mean (pieces, n): of a state at the beginning of each piece; into (pieces, 2 r, 2 n): of
    q₀ and q₁ at its intervals in turn, what goes into the modes (A), then into their mean (B); index (pieces, r): its
    intervals, padded with the number of all; of_cells: the pieces of the cells of each stretch, and the first of every
    cell among these, None where each is one."""

    decay: Array
    mean: Array
    into: Array
    index: Indices
    of_cells: tuple[tuple[slice, Indices | None], ...]

    def bring(self, q0: Array, q1: Array) -> Array:
        """What series (intervals, pushes) bring (pieces, pushes, 2, n): into the modes, and into their means."""
        K, pushes = q0.shape
        q = np.zeros((K + 1, 2, pushes))
        q[:K, 0], q[:K, 1] = q0, q1
        heat = q.take(self.index, axis=0).reshape(len(self.index), -1, pushes)
        return (heat.transpose(0, 2, 1) @ self.into).reshape(len(heat), pushes, 2, -1)

    def average_modes(self, stretch: int, modes: Modes, brought: Array, by: Array, start: Array) -> tuple[Array, Array]:
        """Means of the modes over the cells of a stretch (cells, pushes, n), and modal states after it (pushes, n),
        from what is brought into its modes by `by` (pushes, n)."""
        mine, first = self.of_cells[stretch]
        both = as_modes(brought[mine], modes)
        push, own = both[:, :, 0] * by, both[:, :, 1] * by
        m, end = recur(as_modes(self.decay[mine], modes), push, start)
        m *= as_modes(self.mean[mine], modes)[:, None]
        own += m
        return own if first is None else sum_rows(own, first), end


def pieces_of(cells: Sequence[Indices], gain: Array, c0: Array, c1: Array, E: Array, F0: Array, F1: Array) -> Pieces:
    """Those of the cells that begin at some intervals, stretch after stretch. All others: (intervals, n)."""
    split = [split_cells(own, stop) for own, stop in zip(cells, [*(c[0] for c in cells[1:]), len(gain)], strict=True)]
    starts = np.concatenate([own for own, _ in split])
    ends = np.cumsum([len(own) for own, _ in split])
    of_cells = tuple(
        (slice(end - len(own), end), first) for end, (own, first) in zip(ends.tolist(), split, strict=True)
    )
    (K, n), counts = gain.shape, np.diff(np.append(starts, len(gain)))
    r = int(counts.max())
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
    return Pieces(later, mean, into.reshape(len(starts), 2 * r, 2 * n), index, of_cells)


def split_cells(cells: Indices, stop: int) -> tuple[Indices, Indices | None]:
    """Where pieces begin that hold no more than MOST_INTERVALS of those of the cells that begin at some intervals and
    end before `stop`, and the first piece of every cell, None where each is one."""
    pieces = -(-np.diff(np.append(cells, stop)) // MOST_INTERVALS)
    if pieces.max() == 1:
        return cells, None
    first = np.cumsum(pieces) - pieces
    return np.repeat(cells - first * MOST_INTERVALS, pieces) + np.arange(pieces.sum()) * MOST_INTERVALS, first


@cache
def compile_means() -> Callable[..., None] | None:
    """What follows series from interval to interval as machine code; None without numba."""
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
