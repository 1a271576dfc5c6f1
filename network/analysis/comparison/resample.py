"""Samples on even steps, as spectra and lags need them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array, Indices

MOST = 65536
"""Steps of a grid; longer recordings are averaged onto this many."""
EVEN = 0.01
"""Steps of time that differ by less than this part are even."""


@dataclass(frozen=True, eq=False)
class Grid:
    """t: middles of the steps [s], n of them; index: the step that each sample falls into, is_identity: one each."""

    t: Array
    index: Indices
    is_identity: bool

    @classmethod
    def of(cls, t: Array) -> Grid:
        steps = np.diff(t)
        step = max(float(np.median(steps)), float(t[-1] - t[0]) / (MOST - 1)) if len(t) > 1 else 1.0
        is_even = len(t) <= MOST and (not len(steps) or float(np.ptp(steps)) <= EVEN * step)
        index = np.arange(len(t)) if is_even else np.floor((t - t[0]) / step + 0.5).astype(np.intp)
        return cls(float(t[0]) + step * np.arange(index[-1] + 1), index, is_even)

    @property
    def n(self) -> int:
        return len(self.t)

    @property
    def step(self) -> float:
        """[s]"""
        return float(self.t[1] - self.t[0]) if self.n > 1 else 1.0

    def put(self, values: Array) -> Array:
        """Means of the finite samples in each step, NaN where there is none."""
        if self.is_identity:
            return values
        return mean_in_cells(values, self.index, self.n)

    def hold(self, values: Array) -> Array:
        """The first value in each step, before an empty step the one before: for inputs, which have no gaps."""
        if self.is_identity:
            return values
        latest = np.searchsorted(self.index, np.arange(self.n), side="right") - 1
        return values[latest]


def mean_in_cells(values: Array, index: Indices, cells: int) -> Array:
    """Means of the finite samples in each cell, NaN where there is none. index: of the cell of each sample."""
    there = np.isfinite(values)
    count = np.bincount(index[there], minlength=cells)
    total = np.bincount(index[there], weights=values[there], minlength=cells)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))


def reading_step(values: Array) -> float:
    """The least difference between two readings: the step they are rounded to, next to nothing where they are not."""
    apart = np.diff(np.unique(values[np.isfinite(values)]))
    return float(apart[apart > 1e-9 * apart.sum()].min(initial=np.inf)) if len(apart) else 0.0


def fill_gaps(rows: Array) -> tuple[Array, Array]:
    """(values less their mean with 0 in gaps, 1 where there is a value else 0), row by row."""
    there = np.isfinite(rows)
    count = np.maximum(there.sum(axis=-1, keepdims=True), 1)
    values = np.where(there, rows, 0.0)
    centred = np.where(there, values - values.sum(axis=-1, keepdims=True) / count, 0.0)
    return centred, there.astype(np.float64)
