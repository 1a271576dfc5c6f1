"""Levels of the speed, and how large the residuals are at each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from network.analysis.comparison.amounts import amount, level_words, to_unit
from network.analysis.comparison.lags import until_dead
from network.analysis.comparison.resample import Grid
from network.catalogue.declaration.declare import Array, Indices
from network.engine.trajectory import Trajectory
from network.platform.quantities.units import unit

MOST = 6
"""Levels besides standing still."""
STILL, CLOSE = 0.01, 0.05
"""Parts of the highest level: below the first it stands still, nearer than the second two levels are one."""
RATIO = 1.5
SHARE = 0.03
"""A level that holds for less than this part of the recording is not counted."""
SURE = 2.0
"""Standard deviations by which the logarithms of two rms differ."""


@dataclass(frozen=True, eq=False)
class Regimes:
    """Levels of one input. levels: in SI; which: index of the level at each step, −1 for none."""

    name: str
    unit: str
    levels: tuple[float, ...]
    which: Indices


@dataclass(frozen=True)
class Level:
    """rms of a channel at one level of the input: SI; n: samples, independent: what they are worth."""

    level: float
    rms: float
    n: int
    independent: float


@dataclass(frozen=True)
class ByRegime:
    """rms of one channel at each level of an input. unit, input_unit: in which they are told."""

    name: str
    unit: str
    sigma: float
    input_name: str
    input_unit: str
    levels: tuple[Level, ...]

    @property
    def _ends(self) -> tuple[Level, Level]:
        ordered = sorted(self.levels, key=lambda level: level.rms)
        return ordered[0], ordered[-1]

    @property
    def differs(self) -> bool:
        """By more than 1.5, and more than chance makes it: ln rms has variance 1/(2 n)."""
        if len(self.levels) < 2 or self._ends[0].rms <= 0:
            return False
        low, high = self._ends
        spread = np.sqrt(0.5 / low.independent + 0.5 / high.independent)
        apart = float(np.log(high.rms / low.rms))
        return bool(apart > max(np.log(RATIO), SURE * spread))

    @property
    def sentence(self) -> str:
        low, high = self._ends
        worst, best = (level_words(level.level, self.input_unit) for level in (high, low))
        return f"{self.name}: rms {amount(high.rms, self.unit)} {worst}, {amount(low.rms, self.unit)} {best}"

    @property
    def weight(self) -> float:
        return self._ends[1].rms / self.sigma

    def summary(self) -> dict[str, Any]:
        given = unit(self.input_unit)
        levels = [
            {"level": given.from_si(level.level), "rms": to_unit(level.rms, self.unit), "n": level.n}
            for level in self.levels
        ]
        return {"input": self.input_name, "unit": self.input_unit, "differs": self.differs, "levels": levels}


def regimes_of(run: Trajectory, grid: Grid) -> Regimes | None:
    """The levels of the speed, else of the held input that changes most often; None where there are not two."""
    values = {name: np.abs(grid.hold(v)) for name, v in run.inputs.items() if run.schedule.signals[name].is_held}
    changes = {name: np.count_nonzero(np.diff(v)) for name, v in values.items()}
    name = "speed" if changes.get("speed") else max(changes, key=lambda n: changes[n], default="")
    if not changes.get(name):
        return None
    levels, which = cluster(values[name])
    return Regimes(name, run.schedule.signals[name].unit, levels, which) if len(levels) > 1 else None


def cluster(values: Array) -> tuple[tuple[float, ...], Indices]:
    """(levels, index of the level of each value): standing still and at most MOST others, neighbours merged."""
    top = float(values.max())
    means, where = np.unique(np.rint(values / top / STILL), return_inverse=True)
    count = np.bincount(where).astype(np.float64)
    means = np.bincount(where, weights=values) / count
    group = np.arange(len(means))
    while len(means) > 1:
        gaps = np.where(means[:-1] <= STILL * top, top * 2, np.diff(means))
        k = int(np.argmin(gaps))
        if gaps[k] >= CLOSE * top and len(means) <= MOST + 1:
            break
        means[k] = (means[k] * count[k] + means[k + 1] * count[k + 1]) / (count[k] + count[k + 1])
        count[k] += count[k + 1]
        means, count, group = np.delete(means, k + 1), np.delete(count, k + 1), np.where(group > k, group - 1, group)
    return _long_enough(means, count, group[where.ravel()], top)


def _long_enough(means: Array, count: Array, which: Indices, top: float) -> tuple[tuple[float, ...], Indices]:
    kept = count >= SHARE * len(which)
    renumbered = np.where(kept, np.cumsum(kept) - 1, -1)
    levels = np.where(means <= STILL * top, 0.0, means)[kept]
    return tuple(float(f"{level:.9g}") for level in levels), np.asarray(renumbered[which])


def by_regime(name: str, unit_text: str, sigma: float, values: Array, r: Array, regimes: Regimes) -> ByRegime:
    """rms of one row (SI, NaN in gaps) at each level; r: its autocorrelations, which tell what a sample is worth."""
    worth = 1 / (1 + 2 * float(np.sum(until_dead(r[None])[0, 1:] ** 2)))
    levels = []
    for k, level in enumerate(regimes.levels):
        mine = values[(regimes.which == k) & np.isfinite(values)]
        if len(mine):
            rms = float(np.sqrt(np.mean(mine**2)))
            levels.append(Level(level, rms, len(mine), max(len(mine) * worth, 1.0)))
    return ByRegime(name, unit_text, sigma, regimes.name, regimes.unit, tuple(levels))
