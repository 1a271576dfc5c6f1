"""Resampling: recordings and runs are compared as means over cells, each of the samples that lie in it.

Which samples lie in which interval of a run, and what share of its cell's mean each of them has.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, hstack

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.engine.response.intervals import first_from, interval_of
from network.engine.response.knots import Knots

EVEN = 1e-9
"""Relative difference of two distances that count as the same."""
FEW = 4000
"""Numbers up to which sums of rows are quicker one by one (measured)."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Some samples: interval of each (of `count`), time since its beginning [s], share of its cell's mean."""

    interval: Indices
    since: Array
    share: Array
    count: int

    def sum_decays(self, rates: Array, regime_of: Indices) -> Array:
        """Σ share · e^(−λτ) over the samples of every interval, for the rates λ of its regime (regimes, n): (count,
        n)."""
        s = self.stretches
        regime = regime_of[s.interval]
        decays = np.exp(-s.since[:, None] * rates[regime])
        decays *= s.sum_even(rates, regime)
        decays *= s.share[:, None]
        return _sum_by_interval(s.interval, decays, self.count)

    @cached_property
    def stretches(self) -> Stretches:
        """The samples as evenly spaced ones."""
        gap = np.diff(self.since)
        alone = (np.diff(self.interval) != 0) | (np.diff(self.share) != 0)
        uneven = np.abs(np.diff(gap)) > EVEN * np.abs(gap[1:])
        cut = np.append(True, alone) if len(self.since) else np.zeros(0, bool)
        cut[2:] |= uneven & ~alone[:-1]
        first = np.flatnonzero(cut)
        number = np.diff(np.append(first, len(cut)))
        spacing = np.where(number > 1, np.append(gap, 0.0)[first], 0.0) if len(first) else np.zeros(0)
        kinds, kind = np.unique(np.stack([np.round(spacing, 9), number], axis=1), axis=0, return_inverse=True)
        return Stretches(self.interval[first], self.since[first], self.share[first], kinds, kind.ravel())

    @cached_property
    def moments(self) -> Array:
        """Σ share · τ^j over the samples of every interval, j from 0 to 4: (count, 5)."""
        return _sum_by_interval(self.interval, self.share[:, None] * self.since[:, None] ** np.arange(5), self.count)

    def weights(self, steps: Array) -> tuple[Array, Array]:
        """Of the values just after and just before the edges of its interval, of lengths `steps`."""
        w = self.since / steps[self.interval]
        return (1 - w) * self.share, w * self.share


@dataclass(frozen=True, eq=False)
class Stretches:
    """Evenly spaced samples in one interval: the first's time since its beginning [s], the share of each; kinds: the
    different spacings [s] and numbers of samples, kind: which of these."""

    interval: Indices
    since: Array
    share: Array
    kinds: Array
    kind: Indices

    def sum_even(self, rates: Array, regime: Indices) -> Array:
        """Σ e^(−λ i δ), i from 0 to below the number, for the rates of the regime of each: (stretches, n)."""
        pairs, pair = np.unique(regime * len(self.kinds) + self.kind, return_inverse=True)
        r, kind = np.divmod(pairs, len(self.kinds))
        (spacing, number), own = self.kinds[kind].T[:, :, None], rates[r]
        whole, each = np.expm1(-spacing * number * own), np.expm1(-spacing * own)
        still = each == 0
        return np.asarray(np.where(still, number, whole / np.where(still, 1.0, each)).take(pair, axis=0))


def _sum_by_interval(k: Indices, values: Array, count: int) -> Array:
    """Sums of rows of the same interval, in order: (rows, ·) → (count, ·)."""
    if len(k) == count and count and k[-1] == count - 1 and k[0] == 0 and np.all(np.diff(k) == 1):
        return values
    out = np.zeros((count, values.shape[1]), values.dtype)
    if len(k):
        starts = np.flatnonzero(np.append(True, np.diff(k) > 0))
        out[k[starts]] = sum_rows(values, starts)
    return out


def sum_rows(values: Array, starts: Indices) -> Array:
    """Sums of rows from each start to before the next: (rows, …) → (starts, …); starts: from 0, each beyond the one
    before, below the number of rows. A product with a sparse matrix of ones is many times quicker than `reduceat`, but
    for few numbers."""
    if values.size < FEW:
        return np.asarray(np.add.reduceat(values, starts, axis=0))
    sums = _rows_of(starts, np.ones(len(values))) @ values.reshape(len(values), -1)
    return np.asarray(sums.reshape(len(starts), *values.shape[1:]))


def _rows_of(starts: Indices, weights: Array) -> csr_array:
    """Weights of rows in the sums from each start to before the next: (starts, rows)."""
    rows = len(weights)
    return csr_array((weights, np.arange(rows), np.append(starts, rows)), shape=(len(starts), rows))


@dataclass(frozen=True, eq=False)
class Averages:
    """starts: first interval of each cell; left, right: weights of the values just after and just before the edges of
    every interval where these are joined by straight lines, for each different set of samples (sets, K); set_of: that
    of each channel."""

    starts: Indices
    left: Array
    right: Array
    set_of: Indices
    samples: tuple[Samples, ...]

    @property
    def cells(self) -> int:
        return len(self.starts)

    def of(self, values: Array, channels: Sequence[int] | None = None) -> Array:
        """Means (…, channels, cells) of what runs straight between values at both ends of the intervals (…, 2 K);
        channels: which the values are of, by default all."""
        sets = self.set_of if channels is None else self.set_of[[*channels]]
        out = np.empty((*values.shape[:-1], self.cells))
        for i, matrix in enumerate(self._matrices):
            mine = slice(None) if len(self._matrices) == 1 else np.flatnonzero(sets == i)
            of = values[..., mine, :]
            out[..., mine, :] = (matrix @ of.reshape(-1, of.shape[-1]).T).T.reshape(*of.shape[:-1], self.cells)
        return out

    @cached_property
    def _matrices(self) -> tuple[csr_array, ...]:
        """Weights of the values of each set (cells, 2 K)."""
        sides = zip(self.left, self.right, strict=True)
        return tuple(csr_array(hstack([_rows_of(self.starts, w) for w in both])) for both in sides)

    def groups(self) -> Iterator[tuple[int, Indices | slice]]:
        """Each set of samples, and the channels that have it."""
        if len(self.samples) == 1:
            return iter([(0, slice(None))])
        return ((i, np.flatnonzero(self.set_of == i)) for i in range(len(self.samples)))

    def find_touched(self, first: int, last: int) -> tuple[slice, Indices]:
        """The cells that intervals first to last (excluded) touch, and where they begin among these."""
        if (first, last) not in self._touched:
            begin = int(np.searchsorted(self.starts, first, side="right")) - 1
            end = int(np.searchsorted(self.starts, last))
            self._touched[first, last] = slice(begin, end), np.maximum(self.starts[begin:end] - first, 0)
        return self._touched[first, last]

    @cached_property
    def _touched(self) -> dict[tuple[int, int], tuple[slice, Indices]]:
        return {}

    def split(self, cuts: Sequence[int]) -> tuple[Indices, Indices]:
        """Where cells or pieces begin among the intervals from the first cut to the last, and the cell of each."""
        inside = self.starts[(self.starts > cuts[0]) & (self.starts < cuts[-1])]
        starts = np.union1d(inside, cuts[:-1]).astype(int)
        return np.searchsorted(self.starts, starts, side="right") - 1, starts - cuts[0]


def averages(knots: Knots, edges: Array, present: Sequence[Mask]) -> Averages:
    """The means of channels whose samples are `present`, for intervals between edges; a cell without any is zero."""
    keys = [p.tobytes() for p in present]
    different = list(dict.fromkeys(keys))
    sets = tuple(_samples(knots, edges, present[keys.index(key)]) for key in different)
    left, right = (np.array(side) for side in zip(*(_straight(s, np.diff(edges)) for s in sets), strict=True))
    ends = knots.t[knots.cell_ends[:-1]]
    starts = np.concatenate([[0], first_from(edges[:-1], ends)])
    return Averages(starts, left, right, np.array([different.index(key) for key in keys]), sets)


def _samples(knots: Knots, edges: Array, present: Mask) -> Samples:
    x, cell = knots.samples[present], knots.cell_of[present]
    k = interval_of(edges, x)
    share = 1 / np.maximum(np.bincount(cell, minlength=knots.cells), 1)[cell]
    return Samples(k, np.clip(x - edges[k], 0.0, np.diff(edges)[k]), share, len(edges) - 1)


def _straight(samples: Samples, steps: Array) -> tuple[Array, Array]:
    count = len(steps)
    left, right = (np.bincount(samples.interval, own, count).astype(float) for own in samples.weights(steps))
    return left, right


def cell_matrix(knots: Knots, edges: Array, present: Mask) -> Array:
    """The same of one channel for intervals that may cross cells, as a matrix (cells, 2 K); rows of cells without any
    sample are zero."""
    samples, cell, K = _samples(knots, edges, present), knots.cell_of[present], len(edges) - 1
    matrix = np.zeros((knots.cells, 2 * K))
    for first, own in zip((0, K), samples.weights(np.diff(edges)), strict=True):
        np.add.at(matrix, (cell, first + samples.interval), own)
    return matrix
