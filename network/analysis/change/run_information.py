"""What one run says of numbers and of channels' constant errors, its own nuisances eliminated.

With whitened rows r = z − y(p), slopes A by p and B by the run's own nuisances (prior σ), all rows over the noise's
scale s, the nuisances go by a projection of the rows with their prior's below them,

    [A/s, 0], [B/s, 1/σ], [r/s, 0]  →  Q⊥ of B's span:   N = A′A′ᵀ,  g = A′r′,  J = |r′|²,

so that J(p + Δ) = J − 2 gᵀΔ + ΔᵀNΔ to first order. Source: block elimination, as in arrow_matrix.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.misfit import correlate_neighbours
from network.catalogue.declaration.declare import Array


@dataclass(frozen=True, eq=False)
class RunInformation:
    """precision: N (p, p); gradient: g (p); cost: J. p: the numbers θ, then a constant error [SI] of every channel."""

    precision: Array
    gradient: Array
    cost: float


@dataclass(frozen=True, eq=False)
class WeighedRun:
    """Rows of one run about some p, over the noise's scale. by_p (p, rows); by_own (own, rows); residual, with the
    nuisances at their prior means; spread: prior 1σ of them; channel: slices of the rows by channel."""

    by_p: Array
    by_own: Array
    residual: Array
    spread: Array
    channels: tuple[slice, ...]

    @property
    def information(self) -> RunInformation:
        below = np.zeros((len(self.by_p), len(self.spread)))
        own = np.hstack([self.by_own, np.diag(1 / self.spread)])
        Q = np.linalg.qr(own.T)[0]
        A, r = np.hstack([self.by_p, below]), np.append(self.residual, np.zeros(len(self.spread)))
        A, r = A - (A @ Q) @ Q.T, r - Q @ (Q.T @ r)
        return RunInformation(A @ A.T, A @ r, float(r @ r))

    @property
    def moved(self) -> Array:
        """How far the most probable nuisances lie from their prior means."""
        own = self.by_own @ self.by_own.T + np.diag(self.spread**-2.0)
        return np.asarray(np.linalg.solve(own, self.by_own @ self.residual))

    @property
    def left(self) -> Array:
        """Rows that are left with the nuisances at their most probable."""
        return np.asarray(self.residual - self.moved @ self.by_own)


def weigh_runs(at: Linearised, names: Sequence[str], offsets: Array, scale: float) -> list[WeighedRun]:
    """All runs of a problem without offsets of its own. names: all channels; offsets: their constant errors here;
    scale: s."""
    assert not at.problem.offsets
    spread, first = at.problem.prior[1][at.free :], at.free
    runs = []
    for i, data in enumerate(at.problem.data):
        rows, own = at.rows.slopes.blocks[i]
        part = at.rows.slopes.parts[i]
        constant = at.problem.whiteners[i](_columns_of(data, names))
        residual = at.rows.at_mean[rows] - offsets @ constant
        by_p = np.vstack([part.by_theta, constant])
        runs.append(WeighedRun(by_p / scale, part.by_own / scale, residual / scale,
                               spread[own.start - first : own.stop - first], tuple(_slices(at, i))))  # fmt: skip
    return runs


def _columns_of(data: Measured, names: Sequence[str]) -> Array:
    """One in the cells of each channel (names, cells)."""
    whose = np.repeat(data.run.channels, data.run.knots.cells)
    return np.array([whose == name for name in names], float).reshape(len(names), len(whose))


def _slices(at: Linearised, run: int) -> Iterator[slice]:
    for rows, _ in at.problem.whiteners[run].blocks:
        yield rows


def find_scale(runs: Sequence[WeighedRun], scale: float) -> tuple[float, float]:
    """What the noise of these rows, weighed by a scale, counts with, at least 1: the rms χ of what they leave, more
    where that lasts, as in misfit.py; and how many independent values tell it."""
    left = [scale * run.left for run in runs]
    whole = np.concatenate(left)
    rho = correlate_neighbours(r[rows] for run, r in zip(runs, left, strict=True) for rows in run.channels)
    lasts = (1 + rho) / (1 - rho)
    return max(1.0, float(np.sqrt(np.mean(whole**2) * lasts))), len(whole) / lasts
