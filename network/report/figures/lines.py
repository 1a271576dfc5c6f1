"""Lines over time: thinned so that spikes stay visible, steps as steps, gaps as gaps, one time axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from network.catalogue.declaration.declare import Array, Indices
from network.recordings.inputs import Signal
from network.report.figures.canvas import FAINT, FONT, size_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_POINTS = 4000
BREAK = 10.0
"""A step of time this many times the usual one is a gap."""


def decimate(t: Array, values: Array, most: int = MOST_POINTS) -> Indices:
    """Indices of at most `most` samples that draw the same line: the lowest, the highest and the first gap of every
    stretch of time, and the ends."""
    if len(t) <= most:
        return np.arange(len(t))
    buckets = max((most - 2) // (3 if np.isnan(values).any() else 2), 1)
    position = np.clip((t - t[0]) / (t[-1] - t[0]) * buckets, 0, buckets - 1).astype(np.intp)
    first = np.flatnonzero(np.diff(position, prepend=-1))
    bucket = np.repeat(np.arange(len(first)), np.diff(first, append=len(t)))
    low, high = np.where(np.isnan(values), np.inf, values), np.where(np.isnan(values), -np.inf, values)
    lowest = _first_in(bucket, low == np.minimum.reduceat(low, first)[bucket])
    highest = _first_in(bucket, high == np.maximum.reduceat(high, first)[bucket])
    gaps = _first_in(bucket, np.isnan(values))
    return np.unique(np.concatenate([[0, len(t) - 1], lowest, highest, gaps]))


def _first_in(bucket: Indices, true: NDArray[np.bool_]) -> Indices:
    """The first index of every bucket where it is true."""
    where = np.flatnonzero(true)
    return where[np.unique(bucket[where], return_index=True)[1]]


def thin(t: Array, values: Array, most: int = MOST_POINTS) -> tuple[Array, Array]:
    """At most `most` points of a line that look the same."""
    index = decimate(t, values, most)
    return t[index], values[index]


def decimate_together(t: Array, rows: Sequence[Array], most: int = MOST_POINTS) -> Indices:
    """Indices for several lines that share their times."""
    if len(t) <= most:
        return np.arange(len(t))
    return np.unique(np.concatenate([decimate(t, row, most // len(rows)) for row in rows]))


def outline(signal: Signal, t: Array) -> tuple[Array, Array]:
    """An input from t[0] to t[-1] as a line, jumps upright; points inside a level stretch left out."""
    inside = signal.t[(signal.t > t[0]) & (signal.t < t[-1])]
    edges = np.concatenate([t[:1], inside, t[-1:]])
    after, before = signal.span(edges[:-1], edges[1:])
    times = np.column_stack([edges[:-1], edges[1:]]).ravel()
    values = np.column_stack([after, before]).ravel()
    level = np.zeros(len(values), bool)
    level[1:-1] = (values[1:-1] == values[:-2]) & (values[1:-1] == values[2:])
    return thin(times[~level], values[~level])


def with_gaps(t: Array, values: Array) -> tuple[Array, Array]:
    """The same with a NaN wherever the samples pause much longer than usual."""
    steps = np.diff(t)
    if len(steps) < 3:
        return t, values
    at = np.flatnonzero(steps > BREAK * np.median(steps)) + 1
    return np.insert(t, at, (t[at - 1] + t[at]) / 2), np.insert(values, at, np.nan)


def alone(values: Array) -> NDArray[np.bool_]:
    """Which samples have gaps on both sides: a line would not show them."""
    there = np.isfinite(values)
    padded = np.concatenate([[False], there, [False]])
    return np.asarray(there & ~padded[:-2] & ~padded[2:])


def clock(t: Array) -> tuple[str, float]:
    """The unit of the time axis and its length in seconds."""
    span = float(t[-1] - t[0])
    return ("s", 1.0) if span < 180 else ("min", 60.0) if span < 3.2 * 3600 else ("h", 3600.0)


def set_clock(panels: Sequence[Axes], t: Array, last: Sequence[Axes] = (), unit_of: Array | None = None) -> None:
    """One time axis for all panels; numbers and unit only below the last ones, the others get the grid alone.
    unit_of: times whose unit is taken, where not their own."""
    name, length = clock(t if unit_of is None else unit_of)
    start, end = float(t[0]) / length, float(t[-1]) / length
    for axes in panels:
        ticks = time_ticks(start, end, name, int(size_of(axes)[0] * 1.7))
        axes.set_xlim(start, max(end, start + 1e-9))
        axes.vlines(ticks, 0, 1, transform=axes.get_xaxis_transform(), color=FAINT, linewidth=0.4, zorder=0.4)
        if axes in (last or panels[-1:]):
            axes.set_xticks(ticks)
            axes.set_xlabel(f"time [{name}]", fontsize=FONT, labelpad=2)
        else:
            axes.xaxis.set_visible(False)


def time_ticks(start: float, end: float, name: str, most: int = 12) -> Array:
    """At most so many round times: 10, 15, 30 min; 6, 12, 24 h."""
    steps = {"h": (0.25, 0.5, 1, 2, 3, 6, 12, 24, 48, 72, 120, 240), "min": (1, 2, 5, 10, 15, 20, 30, 60)}
    rough = max(end - start, 1e-9) / most
    decade = 10.0 ** np.floor(np.log10(rough))
    fine = [s for s in steps.get(name, ()) if s >= rough] or [s * decade for s in (1, 2, 5, 10) if s * decade >= rough]
    return np.arange(np.ceil(start / fine[0] - 1e-9), np.floor(end / fine[0] + 1e-9) + 1) * fine[0]
