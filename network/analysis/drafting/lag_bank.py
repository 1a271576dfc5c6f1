"""Everything that may drive a temperature, seen through lags of all lengths: y with τ dy/dt = x − y, run by run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from network.analysis.drafting.recorded_course import Course
from network.catalogue.declaration.declare import Array, Indices

TIMES = 30
"""Time constants of the grid: 1.4 between neighbours over four decades, and a parabola finds the least between them."""
LONGEST = 5.0
"""Times the longest run: a slower part cannot be told from one that only stores heat."""


@dataclass(frozen=True, eq=False)
class LagBank:
    """courses, columns: what it is made of; taus: [s]; names: of the columns; lagged: by τ, cells of all runs ×
    columns, every run begun at zero; decays: by τ, e^(−t/τ) of every run, by which its beginning is forgotten; first:
    the first cell of each run; run: of each cell."""

    courses: tuple[Course, ...]
    columns: Mapping[str, Sequence[Array]]
    taus: Array
    names: tuple[str, ...]
    lagged: tuple[Array, ...]
    decays: tuple[Array, ...]
    first: Indices
    run: Indices

    def moments(self, target: Array) -> Array:
        """τ × columns and target × the same: sums of products over the cells where the target is known, less what its
        first reading of each run tells. target: over all cells, NaN in gaps."""
        there = np.isfinite(target)[:, None]
        found = []
        for lagged, decay in zip(self.lagged, self.decays, strict=True):
            y = target - self.begins(target) * decay
            x = np.hstack([lagged, y[:, None]])
            x = np.where(there, x, 0.0)
            found.append(x.T @ x)
        return np.array(found)

    def residual(self, target: Array, k: int, weights: Mapping[str, float]) -> Array:
        """What columns leave of a target at the k-th time constant, NaN in gaps."""
        use = [self.names.index(name) for name in weights]
        told = self.lagged[k][:, use] @ np.array(list(weights.values())) if use else np.zeros(len(target))
        return np.asarray(target - self.begins(target) * self.decays[k] - told)

    def at(self, tau: float, names: Sequence[str]) -> tuple[Array, Array]:
        """Columns and decay at any time constant [s]."""
        return _lagged(self.courses, [self.columns[name] for name in names], tau)

    def begins(self, target: Array) -> Array:
        """The first reading of its run, at every cell; 0 in a run without any."""
        rows = np.split(target, self.first[1:])
        known = [row[np.isfinite(row)] for row in rows]
        return np.array([float(row[0]) if len(row) else 0.0 for row in known])[self.run]


def bank_of(courses: Sequence[Course], columns: Mapping[str, Sequence[Array]]) -> LagBank:
    """columns: by name, values over the cells of every run, without gaps."""
    longest, shortest = max(c.length for c in courses), min(c.step for c in courses)
    taus = np.geomspace(shortest, LONGEST * longest, TIMES)
    lagged, decays = zip(*(_lagged(courses, list(columns.values()), float(tau)) for tau in taus), strict=True)
    sizes = np.array([c.cells for c in courses])
    first = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    return LagBank(
        tuple(courses), columns, taus, tuple(columns), lagged, decays, first, np.repeat(np.arange(len(courses)), sizes)
    )


def _lagged(courses: Sequence[Course], columns: Sequence[Sequence[Array]], tau: float) -> tuple[Array, Array]:
    """Columns with a lag over the cells of all runs, and how their beginnings decay."""
    rows = [_lag_all(course, [column[r] for column in columns], tau) for r, course in enumerate(courses)]
    return np.vstack(rows), np.concatenate([_decay(course, tau) for course in courses])


def _lag_all(course: Course, rows: Sequence[Array], tau: float) -> Array:
    if not rows:
        return np.empty((course.cells, 0))
    return np.stack([lag(row, course.step, tau) for row in rows], axis=1)


def lag(x: Array, step: float, tau: float) -> Array:
    """Means over the cells of y with τ dy/dt = x − y, y = 0 at the start, x constant in each cell: exact."""
    keep = float(np.exp(-step / tau))
    ends = lfilter([1 - keep], [1, -keep], x)
    begins = np.concatenate([[0.0], ends[:-1]])
    return np.asarray(x + (begins - x) * (tau / step) * (1 - keep))


def _decay(course: Course, tau: float) -> Array:
    keep = np.exp(-course.step / tau)
    return np.asarray(keep ** np.arange(course.cells) * (tau / course.step) * (1 - keep))
