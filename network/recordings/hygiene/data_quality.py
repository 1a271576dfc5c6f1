"""What a recording is worth before a fit: its own noise, readings that lie apart, channels that stand still.

None of this needs a model: neighbours in time tell what a sample's noise is, and which sample does not belong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from network.catalogue.declaration.declare import Array, Mask

NORMAL = 0.6745
"""Median of |x| over the standard deviation, for a normal x."""
WINDOW = 9
"""Samples about each that say what it should be."""
APART = 8.0
"""Robust deviations from its neighbours at which a reading is set aside."""
MOST_APART = 0.1
"""Of the samples of a channel: more of them are no outliers but what the sensor does."""


@dataclass(frozen=True)
class Channel:
    """One measured channel. values: SI, NaN in gaps; noise: 1σ of a sample as its neighbours tell it (0 where nothing
    moves); apart: readings set aside; quantum: step of the readings, 0 if none is seen."""

    name: str
    values: Array
    noise: float
    apart: Mask
    quantum: float

    @property
    def used(self) -> Mask:
        return np.isfinite(self.values) & ~self.apart


def look_at(name: str, values: Array, declared: float) -> Channel:
    """What a channel tells by itself; `declared`: 1σ of a sample as the machine file has it."""
    finite = np.isfinite(values)
    noise, quantum = noise_of(values[finite]), quantum_of(values[finite])
    apart = np.zeros(len(values), bool)
    apart[finite] = _apart(values[finite], max(noise, declared, quantum / 2))
    if apart.sum() > MOST_APART * finite.sum():
        apart[:] = False
    kept = values[finite & ~apart]
    return Channel(name, values, noise_of(kept), apart, quantum)


def noise_of(values: Array) -> float:
    """1σ of a sample from second differences, which a steady rise leaves at zero: Var(y₋ − 2y + y₊) = 6 σ².

    By the median, which outliers leave alone, and where readings are quantised and it is 0, by the mean of what is not
    far out.
    """
    if len(values) < 5:
        return 0.0
    second = np.abs(values[2:] - 2 * values[1:-1] + values[:-2])
    by_median = float(np.median(second)) / NORMAL / np.sqrt(6)
    inner = second[second <= np.quantile(second, 0.95)]
    by_mean = float(np.sqrt(np.mean(inner**2))) / np.sqrt(6) / 0.87 if len(inner) else 0.0
    return by_median if by_median > 0 else by_mean


def quantum_of(values: Array) -> float:
    """The step of which all differences are multiples, if readings repeat often enough to show it; else 0."""
    levels = np.unique(values)
    if len(levels) < 3 or len(levels) > len(values) / 3:
        return 0.0
    steps = np.diff(levels)
    smallest = float(np.quantile(steps, 0.1))
    off = np.abs(steps / smallest - np.round(steps / smallest))
    return smallest if np.median(off) < 0.05 else 0.0


def _apart(values: Array, noise: float) -> Mask:
    """Readings far from the median of their neighbours, measured by how those scatter (Hampel's filter)."""
    if len(values) < WINDOW:
        return np.zeros(len(values), bool)
    half = WINDOW // 2
    padded = np.concatenate([values[half:0:-1], values, values[-2 : -half - 2 : -1]])
    windows = sliding_window_view(padded, WINDOW)
    middle = np.median(windows, axis=1)
    scatter = np.median(np.abs(windows - middle[:, None]), axis=1) / NORMAL
    return np.asarray(np.abs(values - middle) > APART * np.maximum(scatter, noise))
