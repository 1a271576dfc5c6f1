"""Whether an entry of p may have another value now than then: its difference, and its standard error.

Of the fit without it, one Gauss–Newton step with d_j free gives d_j ± √(H⁻¹)_jj. Its variance by what runs contribute,
Σ n/(n − 1) Σ (a_r − ā)² over the runs of each set, a_r the part of d_j that run r brings, counts instead where it is
larger: a machine that lacks some physics wants other numbers on every run, and that is no change. A constant error is
tested against what sensors of its kind are off by. Source: variance by clusters, Liang & Zeger, Biometrika 73 (1986)
13 (unverified).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from network.analysis.change.paired_fit import PairedFit
from network.catalogue.declaration.declare import Array, Mask

TOLD = 0.5
"""Of the prior variance of a number: where less of it is taken away by both sets, they do not tell whether it moved."""


@dataclass(frozen=True)
class Difference:
    """entry: of p; value: d [logarithms, or SI], std: its 1σ, of a constant error with that of its kind."""

    entry: int
    value: float
    std: float

    @property
    def sigma(self) -> float:
        return abs(self.value) / self.std


def test_entries(at: PairedFit, candidates: tuple[int, ...]) -> list[Difference]:
    """Differences of all candidates, each alone beside what is split already, the gravest first."""
    return sorted((measure_difference(at, j) for j in candidates), key=lambda each: -each.sigma)


def measure_difference(at: PairedFit, entry: int) -> Difference:
    """The difference of one entry, beside what is split already (itself, perhaps)."""
    sets, size, n = at.sets, len(at.p), len(at.sets.parameters)
    spread = sets.spread_of_difference((*at.split, entry))
    free = spread > 0
    H, gradient = at.system(spread)
    step = np.asarray(np.linalg.solve(H, gradient), float)
    place = size + int(free[:entry].sum())
    row = np.asarray(np.linalg.solve(H, np.eye(len(H))[place]), float)
    variance = max(float(row[place]), _between_runs(at, row, step, free))
    usual = float(sets.usual_offset[entry - n]) if entry >= n else 0.0
    return Difference(entry, float(at.d[entry] + step[place]), float(np.sqrt(variance + usual**2)))


def _between_runs(at: PairedFit, row: Array, step: Array, free: Mask) -> float:
    """Variance of a difference by what its runs bring; 0 where a set has but one."""
    size, total = len(at.p), 0.0
    for now, runs in enumerate(at.information):
        if len(runs) < 2:
            return 0.0
        move = step[:size].copy()
        along = row[:size].copy()
        if now:
            move[free] += step[size:]
            along[free] += row[size:]
        brought = np.array([along @ (run.gradient - run.precision @ move) for run in runs])
        total += len(runs) / (len(runs) - 1) * float(np.sum((brought - brought.mean()) ** 2))
    return total


def list_testable(at: PairedFit) -> Iterator[int]:
    """Entries whose difference the sets tell at all: a number that both leave to its prior may be anything."""
    n = len(at.sets.parameters)
    for j in range(len(at.p)):
        if j >= n or measure_difference(at, j).std < TOLD * at.sets.loose * at.sets.prior[1][j]:
            yield j
