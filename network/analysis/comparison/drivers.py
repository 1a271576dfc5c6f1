"""What residuals go along with: inputs, unused columns, and the residuals of other channels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.analysis.comparison.candidate_drivers import Candidate
from network.catalogue.declaration.declare import Array
from network.platform.quantities.number_format import write_minus

LEVEL = 0.01
"""A channel without any driver is given one less often than this, all candidates counted."""
SURE = 1e-4
"""The same for drivers told by changes: of 3600 pairs of an input in steps and a residual that drifts by itself, with
time constants from a minute to for ever and noise upon it, that test calls 79 below 0.01, where it should 36, and 2
below this."""
LEAST = 0.3
"""A correlation below this explains less than a tenth and is not told."""
FEWEST = 5.0
"""Fewer independent samples than this prove nothing."""


@dataclass(frozen=True)
class Driver:
    """r: correlation of one channel's residual with a candidate; independent: samples the two are worth, p: its
    probability by chance, all candidates counted; rms_in_noise: of the channel, about its mean; by_changes: whether it
    was found by what the residual does next (lagged_drivers), independent then being the blocks that were tested."""

    name: str
    of: str
    form: str
    lag: float
    is_input: bool
    r: float
    independent: float
    p: float
    rms_in_noise: float
    words: str
    by_changes: bool = False

    @property
    def sentence(self) -> str:
        verb = "follows" if self.r > 0 else "runs against"
        told = _format_correlation(self.r, self.independent)
        if self.by_changes:
            told = write_minus(f"(r = {self.r:.2f}, and it turns when that changes)")
        return f"{self.name} {verb} {self.words} {told}"

    @property
    def weight(self) -> float:
        return abs(self.r) * self.rms_in_noise

    def summary(self) -> dict[str, Any]:
        return {
            "name": self.of, "form": self.form, "lag_seconds": self.lag, "is_input": self.is_input, "r": self.r,
            "independent": self.independent, "p": self.p, "test": "changes" if self.by_changes else "correlation",
        }  # fmt: skip


@dataclass(frozen=True)
class Companion:
    """Correlation with the residual of another channel."""

    name: str
    other: str
    r: float
    independent: float
    p: float
    rms_in_noise: float

    @property
    def sentence(self) -> str:
        way = "together" if self.r > 0 else "in opposite directions"
        return f"{self.name} and {self.other} are off {way} {_format_correlation(self.r, self.independent)}"

    @property
    def weight(self) -> float:
        return abs(self.r) * self.rms_in_noise

    def summary(self) -> dict[str, Any]:
        return {"channel": self.other, "r": self.r, "independent": self.independent, "p": self.p}


def _format_correlation(r: float, independent: float) -> str:
    return write_minus(f"(r = {r:.2f}, {independent:.0f} independent samples)")


def correlation(x: Array, x_there: Array, z: Array, z_there: Array) -> tuple[Array, Array]:
    """(r, pairs) of every row of x with every row of z over the samples both have; rows with 0 in gaps."""
    joint = x @ z.T
    scale = np.sqrt((x**2 @ z_there.T) * (x_there @ (z**2).T))
    return np.clip(joint / np.where(scale > 0, scale, np.inf), -1.0, 1.0), np.asarray(x_there @ z_there.T)


def probability(r: Array, independent: Array) -> Array:
    """Two-sided, of a larger |r| by chance: t = r √((n − 2)/(1 − r²)) with n − 2 degrees of freedom."""
    from scipy.special import stdtr

    free = np.maximum(independent - 2, 1e-9)
    t = np.abs(r) * np.sqrt(free / np.maximum(1 - r**2, 1e-12))
    return np.where(independent > FEWEST, 2 * stdtr(free, -t), 1.0)


def drivers(
    name: str, candidates: Sequence[Candidate], r: Array, independent: Array, rms_in_noise: float
) -> tuple[Driver, ...]:
    """The significant ones, each in its best form, strongest first. r, independent: by candidate."""
    chance = np.minimum(probability(r, independent) * max(len(candidates), 1), 1.0)
    best: dict[str, Driver] = {}
    for k in np.argsort(-np.abs(r)):
        c = candidates[k]
        if chance[k] < LEVEL and abs(r[k]) > LEAST and c.name not in best:
            worth = float(r[k]), float(independent[k]), float(chance[k])
            best[c.name] = Driver(name, c.name, c.form, c.lag, c.is_input, *worth, rms_in_noise, c.words)
    return tuple(best.values())


def companions(
    names: Sequence[str], k: int, r: Array, independent: Array, rms_in_noise: float
) -> tuple[Companion, ...]:
    """The other channels whose residuals go along with the k-th, strongest first."""
    chance = np.minimum(probability(r, independent) * max(len(names) - 1, 1), 1.0)
    return tuple(
        Companion(names[k], names[j], float(r[j]), float(independent[j]), float(chance[j]), rms_in_noise)
        for j in np.argsort(-np.abs(r))
        if j != k and chance[j] < LEVEL and abs(r[j]) > LEAST
    )
