"""How far a told displacement is off: on a grid of two minutes, day by day, and over days.

A day counts by its mean square, however long it ran. `absolute` is what a compensation leaves; `mean_out` is what is
left of it once the mean of the run is known, so the shape alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from bench.cnc_lathe_runs import DISPLACEMENTS, Day

from network.catalogue.declaration.declare import Array, Indices

SPACING = 120.0
"""s"""
Tell = Callable[[Day], Array]
"""From a day to x and z [m] at its samples, samples × 2."""


@dataclass(frozen=True, eq=False)
class Miss:
    """One day's rms, or that of several: absolute and with the mean taken out, x and z [µm]."""

    day: str
    climate: str
    absolute: Array
    mean_out: Array


def grid(t: Array, spacing: float = SPACING) -> Indices:
    """Of every point of the grid, which begins with the run, the last sample before it or on it."""
    points = np.arange(t[0], t[-1] + 1e-6, spacing)
    return np.asarray(np.searchsorted(t, points + 1e-6, side="right") - 1)


def miss(day: Day, told: Array) -> Miss:
    """told: x and z [m] at the day's samples."""
    at = grid(day.recording.t)
    measured, counted = day.values(*DISPLACEMENTS)[at], day.counted[at]
    left = np.where(counted, (measured - told[at]) * 1e6, np.nan)
    return Miss(day.name, day.climate, rms(left), rms(left - np.nanmean(left, axis=0)))


def rms(values: Array) -> Array:
    """Of each column, without NaN."""
    return np.asarray(np.sqrt(np.nanmean(values**2, axis=0)))


def over_days(misses: Sequence[Miss]) -> Miss:
    absolute, mean_out = (np.stack([getattr(m, name) for m in misses]) for name in ("absolute", "mean_out"))
    return Miss("all", "all", rms(absolute), rms(mean_out))


@dataclass(frozen=True, eq=False)
class Fold:
    """What is left out, and what is learned from. name: the day's or the climate's."""

    name: str
    left_out: tuple[Day, ...]
    training: tuple[Day, ...]


AT_ONCE = 6
"""Calibrations that tell all days `by sixth`: every sixth day is left out at once, so each sees most climates."""


def folds(days: Sequence[Day], by: str) -> list[Fold]:
    """by: `day`, `sixth` (every sixth day at once) or `climate`, each left out once."""
    named = {day.name: _left_out_with(k, day, by) for k, day in enumerate(days)}
    made = []
    for name in dict.fromkeys(named.values()):
        left_out = tuple(day for day in days if named[day.name] == name)
        made.append(Fold(name, left_out, tuple(day for day in days if named[day.name] != name)))
    return made


def _left_out_with(k: int, day: Day, by: str) -> str:
    """The name of those days that the k-th is left out with."""
    return {"day": day.name, "climate": day.climate, "sixth": f"sixth {k % AT_ONCE + 1}"}[by]


def spread(days: Sequence[Day], most: int | None) -> tuple[Day, ...]:
    """At most so many of them: the first, the last, and those at even steps between."""
    if most is None or len(days) <= most:
        return tuple(days)
    return tuple(days[int(k)] for k in np.linspace(0, len(days) - 1, most).round())


def score(learn: Callable[[Fold], Tell], over: Iterable[Fold]) -> list[Miss]:
    """Each left-out day as `learn` tells it from the others."""
    found = []
    for fold in over:
        tell = learn(fold)
        found += [miss(day, tell(day)) for day in fold.left_out]
    return found
