"""The figures of a drift: its range over a time, and when it has become stable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from network.catalogue.declaration.declare import Array

HOUR = 3600.0
GRID = 60.0
"""s: spacing on which a drift is looked at for stability."""
SETTLED = 0.15
"""Share of the largest distortion of the first 60 min below which the change of the last 60 min counts as stable."""
ORIGIN = "told of ISO 230-3:2007, 6.2; unverified, for the text of the standard was not at hand"
"""Of SETTLED: neither edition's text is freely to be had, and what is says nothing of it."""
READING = 300.0
"""s: measured values are lines through so long, so that the noise of single samples does not count as drift."""


def find_range(t: Array, values: Array, begin: float, end: float) -> float:
    """Largest less smallest value between two instants; NaN where none was read."""
    inside = values[(t >= begin) & (t <= end) & np.isfinite(values)]
    return float(np.ptp(inside)) if len(inside) else float("nan")


def combine(drifts: Sequence[float]) -> float | None:
    """√(Σ drift²) of several axes, as makers of measuring sets tell it (Lion Precision, SpindleCheck manual
    M017-7500, thermal stability); None with fewer than two."""
    return float(np.sqrt(np.sum(np.square(drifts)))) if len(drifts) > 1 else None


def find_stability(t: Array, values: Array, begin: float, end: float, share: float = SETTLED) -> float | None:
    """How long after `begin` [s] the change over the last 60 min stays below `share` of the largest distortion of the
    first 60 min, until `end`; None where it never does, and where there is less than two hours to tell it from."""
    finite = np.isfinite(values)
    if end - begin < 2 * HOUR or finite.sum() < 2:
        return None
    grid = np.arange(begin, end + GRID / 2, GRID)
    course = np.interp(grid, t[finite], values[finite])
    lag = round(HOUR / GRID)
    windows = np.lib.stride_tricks.sliding_window_view(course, lag + 1)
    limit = share * float(np.abs(course[: lag + 1] - course[0]).max())
    restless = np.flatnonzero(np.ptp(windows, axis=1) >= limit)
    first = int(restless[-1]) + 1 if len(restless) else 0
    return float((first + lag) * GRID) if first < len(windows) else None


def smooth_readings(t: Array, values: Array) -> tuple[Array, Array]:
    """Every minute the straight line through what was read within READING about it (four intervals where readings are
    rarer): (t, values). A line and not a mean, so that the ends of a drift are not cut off; what lies further from its
    readings than an end does is left out."""
    finite = np.isfinite(values)
    t, values = t[finite], values[finite]
    if len(t) < 2:
        return t, values
    half = max(READING, 4 * float(np.median(np.diff(t)))) / 2
    grid = np.append(np.arange(t[0], t[-1], GRID), t[-1])
    first, last = np.searchsorted(t, grid - half, side="left"), np.searchsorted(t, grid + half, side="right")
    lines = np.array([_line_at(at, t[a:b], values[a:b], half) for at, a, b in zip(grid, first, last, strict=True)])
    return grid[np.isfinite(lines)], lines[np.isfinite(lines)]


def _line_at(at: float, t: Array, values: Array, half: float) -> float:
    if len(t) < 2 or abs(at - t.mean()) > half * (0.5 + 1 / len(t)):
        return float("nan")
    spread = t - t.mean()
    return float(values.mean() + (at - t.mean()) * (spread @ values) / (spread @ spread))
