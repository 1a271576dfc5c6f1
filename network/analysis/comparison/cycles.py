"""How long single swings last at each level of an input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.analysis.comparison.amounts import level_words
from network.analysis.comparison.speed_levels import Regimes
from network.catalogue.declaration.declare import Array
from network.platform.quantities.text_table import span
from network.platform.quantities.units import unit

AROUND = 2.0
"""Swings between period/AROUND and period·AROUND are counted."""
CLEAR = 4.0
"""The power around the period is at least this often that of drift and noise, or single swings mean nothing."""
FEWEST = 4
RATIO, SURE = 1.2, 3.0
"""Periods differ when they differ by this factor and by so many standard errors."""
SMALL = 0.5
"""Swings below this part of the usual height are noise."""


@dataclass(frozen=True)
class Cycles:
    """level: of the input, SI; period: mean of `count` swings [s]; error: standard error of it [s]."""

    level: float
    input_unit: str
    period: float
    count: int
    error: float

    def summary(self) -> dict[str, Any]:
        return {"level": unit(self.input_unit).from_si(self.level), "seconds": self.period, "cycles": self.count}


def cycles_sentence(found: Sequence[Cycles]) -> str:
    return ", ".join(f"{span(cycles.period)} {level_words(cycles.level, cycles.input_unit)}" for cycles in found)


def cycles_by_regime(values: Array, step: float, period: float, regimes: Regimes) -> tuple[Cycles, ...]:
    """Mean length of the swings that lie wholly within one level; empty unless two levels differ for sure."""
    starts, lengths = _swings(_around(values, step, period))
    if not len(starts):
        return ()
    inside = np.rint([starts, starts + lengths]).astype(np.intp)
    first, last = regimes.which[inside[0]], regimes.which[np.minimum(inside[1], len(values) - 1)]
    found = [_cycles(lengths[(first == k) & (last == k)] * step, regimes, k) for k in range(len(regimes.levels))]
    told = [cycles for cycles in found if cycles is not None]
    return tuple(told) if _differ(told) else ()


def _cycles(lengths: Array, regimes: Regimes, k: int) -> Cycles | None:
    if len(lengths) < FEWEST:
        return None
    error = float(lengths.std(ddof=1)) / np.sqrt(len(lengths))
    return Cycles(regimes.levels[k], regimes.unit, float(lengths.mean()), len(lengths), error)


def _differ(told: Sequence[Cycles]) -> bool:
    if len(told) < 2:
        return False
    short, long = min(told, key=lambda c: c.period), max(told, key=lambda c: c.period)
    apart = long.period - short.period
    return long.period > RATIO * short.period and apart > SURE * float(np.hypot(short.error, long.error))


def _around(values: Array, step: float, period: float) -> Array:
    """What swings about as fast as the period."""
    frequency = np.fft.rfftfreq(len(values), step) * period
    passed = (frequency > 1 / AROUND) & (frequency < AROUND)
    return np.asarray(np.fft.irfft(np.fft.rfft(values) * passed, len(values)))


def _swings(values: Array) -> tuple[Array, Array]:
    """(start, length) in steps of the swings between upward crossings of zero, the low ones left out."""
    up = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    if len(up) < 2:
        return np.empty(0), np.empty(0)
    at = up + values[up] / (values[up] - values[up + 1])
    height = np.maximum.reduceat(np.abs(values), up)[:-1]
    high = height > SMALL * np.median(height)
    return at[:-1][high], np.diff(at)[high]
