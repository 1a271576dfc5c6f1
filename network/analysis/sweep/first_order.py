"""What a sample of runs tells: bands, and which number brings how much of the scatter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array

LEVEL = (0.025, 0.975)
FEWEST = 200
"""Runs below which shares are mostly chance."""
EACH = 20
"""Runs in a class of the number at least; at most MOST_CLASSES classes."""
MOST_CLASSES = 40


@dataclass(frozen=True)
class Scatter:
    """Of one value over all runs: mean, 1σ and the ends of the band of 95 %."""

    mean: float
    std: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Array) -> Scatter:
        low, high = np.quantile(values, LEVEL)
        return cls(float(values.mean()), float(values.std(ddof=1)), float(low), float(high))

    def summary(self, unit_text: str) -> dict[str, Any]:
        return {"mean": self.mean, "std": self.std, "low95": self.low, "high95": self.high, "unit": unit_text}


def first_order_shares(numbers: Array, values: Array) -> Array:
    """Share of the variance of `values` (runs) that each number brings alone, Var(E[y | x])/Var(y), from (runs,
    numbers) drawn independently: variance between classes of x, less what chance brings there (ε²). Range: numbers
    that act together leave a sum below 1; standard error about √(2 classes)/runs. Source: Plischke, Borgonovo & Smith,
    European Journal of Operational Research 226 (2013) 536; Kelley, PNAS 21 (1935) 554."""
    runs = len(values)
    total = float(((values - values.mean()) ** 2).sum())
    if total == 0.0:
        return np.zeros(numbers.shape[1])
    classes = int(min(MOST_CLASSES, max(2, runs // EACH)))
    return np.array([_share(numbers[:, i], values, classes, total) for i in range(numbers.shape[1])])


def _share(number: Array, values: Array, classes: int, total: float) -> float:
    ordered = values[np.argsort(number, kind="stable")]
    within = sum(float(((part - part.mean()) ** 2).sum()) for part in np.array_split(ordered, classes))
    runs = len(values)
    return max(0.0, 1 - within / (runs - classes) / (total / (runs - 1)))
