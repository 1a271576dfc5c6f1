"""Drivers that a slow part follows late: whether an input tells what a residual does next, beside its own past.

A part that warms behind its driver lasts for hours, so a recording holds few independent stretches of it and a plain
correlation proves little, however close. Its changes hold more: of block means e_k is regressed on e_(k−1) … e_(k−3), a
line in time, and on the driver's u_k, u_(k−1); an F test says whether these two help. C. W. J. Granger, Econometrica 37
(1969) 424. A residual that drifts by itself, with any time constant, is explained by its own past.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.comparison.candidate_drivers import Candidate, lag_series
from network.analysis.comparison.resample import Grid
from network.catalogue.declaration.declare import Array

BLOCKS = 144
"""Blocks of a recording at most: 5 min of 12 h, in which noise is averaged and a slow part still moves."""
FEWEST = 40
"""Blocks from which it is tested."""
PAST, OWN = 3, 2
"""Blocks of its own past, which cover noise on top of a drift, and of the driver that a residual is regressed on."""
SMOOTH = 0.01
"""Share of a driver's variance that its own past must leave."""
TRIED = 32
"""Time constants between three steps and the whole length, of which that with the closest correlation is told."""


@dataclass(frozen=True)
class Lagging:
    """A driver that tells what comes. lag: time constant [s] with which the residual follows it best; r: correlation
    then; p: probability by chance; blocks: that were tested."""

    lag: float
    r: float
    p: float
    blocks: int


def find_lagging(values: Array, there: Array, driver: Candidate, grid: Grid, level: float) -> Lagging | None:
    """Of one residual (0 in gaps) and a driver as it is; None where chance does as much more often than `level`."""
    size = max(-(-grid.n // BLOCKS), 1)
    row = np.where(there > 0, values, np.nan)
    e, u = (block_means(series, size) for series in (row, driver.values))
    if is_smooth(u):
        return None
    p, way, blocks = granger(e, u)
    return Lagging(*_closest_lag(row, driver.values, grid, way), p, blocks) if p < level else None


def is_smooth(u: Array) -> bool:
    """Whether a driver goes on as it went, like a room over a day: with what else drifts it is easily mistaken."""
    k = np.arange(PAST, len(u))
    past = [u[k - i] for i in range(1, PAST + 1)]
    rows = np.stack([u[k], np.ones(len(k)), np.linspace(-1, 1, len(k)), *past], axis=1)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if len(rows) < FEWEST:
        return True
    return _regress(rows[:, 0], rows[:, 1:])[1] <= SMOOTH * float(np.sum((rows[:, 0] - rows[:, 0].mean()) ** 2))


def block_means(values: Array, size: int) -> Array:
    """Means of so many neighbours, NaN where one is missing; a rest at the end is left out."""
    whole = len(values) // size * size
    return np.asarray(values[:whole].reshape(-1, size).mean(axis=1))


def granger(e: Array, u: Array) -> tuple[float, float, int]:
    """(probability that the driver helps by chance as much as it does, which way it drives, rows that were there)."""
    from scipy.special import fdtrc

    k = np.arange(PAST, len(e))
    own = [e[k - i] for i in range(1, PAST + 1)]
    driven = [u[k - i] for i in range(OWN)]
    rows = np.stack([e[k], np.ones(len(k)), np.linspace(-1, 1, len(k)), *own, *driven], axis=1)
    rows = rows[np.isfinite(rows).all(axis=1)]
    free = len(rows) - (rows.shape[1] - 1)
    if len(rows) < FEWEST or float(np.ptp(rows[:, -1])) == 0:
        return 1.0, 0.0, 0
    weights, with_it = _regress(rows[:, 0], rows[:, 1:])
    without = _regress(rows[:, 0], rows[:, 1:-OWN])[1]
    gain = max(without - with_it, 0.0) / OWN
    p = float(fdtrc(OWN, free, gain / max(with_it / free, 1e-300)))
    return p, float(np.sign(weights[-OWN:].sum())), len(rows)


def _regress(y: Array, X: Array) -> tuple[Array, float]:
    """Weights, and the Σ of squares that they leave."""
    scale = np.maximum(np.abs(X).max(axis=0), 1e-300)
    weights = np.linalg.lstsq(X / scale, y, rcond=1e-10)[0] / scale
    return weights, float(np.sum((y - X @ weights) ** 2))


def _closest_lag(row: Array, driver: Array, grid: Grid, way: float) -> tuple[float, float]:
    """(time constant, correlation of that sign) with which the residual follows best; 0 is at once."""
    seen = np.isfinite(row) & np.isfinite(driver)
    steps = np.arange(grid.n)
    whole = np.interp(steps, steps[np.isfinite(driver)], driver[np.isfinite(driver)])
    longest = grid.n * grid.step
    lags = [float(x) for x in np.geomspace(min(3 * grid.step, longest), longest, TRIED)]
    series: Sequence[Array] = [whole, *lag_series(whole, grid.step, lags)]
    r = [_correlation(row[seen], each[seen]) for each in series]
    best = int(np.argmax(way * np.array(r)))
    return ([0.0, *lags][best], r[best])


def _correlation(a: Array, b: Array) -> float:
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / scale if scale > 0 else 0.0
