"""A temperature as the lagged sum of what drives it, by least squares; what is worth a place in it, by evidence.

T with τ dT/dt = Σ w_q (T_q − T) + Σ g_u u, Σ w = 1, w ≥ 0: a part of heat capacity C with conductances G_q = w_q C/τ to
surroundings and other parts and heats g_u u C/τ. In deviations from a constant of the run it is the sum of its drivers
through one lag, and of its first reading times e^(−t/τ).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from network.analysis.comparison.lags import autocorrelations, until_dead
from network.analysis.drafting.lag_bank import LagBank
from network.catalogue.declaration.declare import Array, Indices

RIDGE = 1e-11
"""Of the squares of a column: what keeps columns apart that rounding cannot."""
BOUND = 1e6
"""How many times as heavy as the readings it weighs that conductances add up to the whole."""


@dataclass(frozen=True, eq=False)
class LagFit:
    """tau: [s]; weights: w of temperatures and g of inputs; square: mean square that is left; numbers: how many were
    fitted; residual: over all cells, NaN in gaps; independent: readings that are worth one each."""

    tau: float
    weights: Mapping[str, float]
    square: float
    numbers: int
    residual: Array
    independent: float

    @property
    def rms(self) -> float:
        return float(np.sqrt(self.square))

    def gain_over(self, other: LagFit) -> float:
        """Nats by which it is the more probable, BIC: n/2 ln(square ratio) less ln(n)/2 for every further number, n its
        independent readings. Above zero it is worth its numbers."""
        n = max(self.independent, 1.0)
        ratio = max(other.square, 1e-300) / max(self.square, 1e-300)
        return float(n * np.log(ratio) - (self.numbers - other.numbers) * np.log(n)) / 2


@dataclass(frozen=True, eq=False)
class Fitting:
    """One temperature and its moments with all columns. conducts: columns that are temperatures; signed: inputs that
    may cool as well as heat; floor: least mean square that readings can leave."""

    bank: LagBank
    target: Array
    moments: Array
    conducts: Collection[str]
    signed: Collection[str]
    floor: float

    def fit(self, drivers: Sequence[str]) -> LagFit:
        """The best time constant and weights of these drivers."""
        use = [self.bank.names.index(name) for name in drivers]
        known = max(int(np.isfinite(self.target).sum()), 1)
        found = [self._at(k, use, drivers) for k in range(len(self.bank.taus))]
        squares = np.array([square for square, _ in found])
        k = int(np.argmin(squares))
        weights = {name: float(w) for name, w in zip(drivers, found[k][1], strict=True) if w != 0}
        residual = self.bank.residual(self.target, k, weights)
        left = max(float(np.nansum(residual**2)) / known, self.floor)
        numbers = 1 + sum(name not in self.conducts for name in drivers)
        numbers += max(sum(name in self.conducts for name in drivers) - 1, 0)
        return LagFit(self._between(squares, k), weights, left, numbers, residual, count_independent(residual, self.bank.run))

    def _at(self, k: int, use: Sequence[int], drivers: Sequence[str]) -> tuple[float, Array]:
        """(sum of squares left, weights) at the k-th time constant: non-negative least squares from the moments."""
        G, b, yy = self.moments[k][np.ix_(use, use)], self.moments[k][use, -1], self.moments[k][-1, -1]
        flow = np.array([name in self.conducts for name in drivers], float)
        heavy = BOUND * max(float(np.trace(G)), yy, 1e-300) * bool(flow.any())
        A = G + heavy * np.outer(flow, flow) + np.diag(RIDGE * np.diag(G) + 1e-300)
        c = b + heavy * flow
        free = [i for i, name in enumerate(drivers) if name in self.signed]
        flip = np.hstack([np.eye(len(use)), -np.eye(len(use))[:, free]])
        scale = 1 / np.sqrt(np.maximum(np.diag(A), 1e-300))
        values, vectors = np.linalg.eigh(A * np.outer(scale, scale))
        root = np.sqrt(np.maximum(values, 1e-14 * values.max()))
        w, _ = nnls((root[:, None] * vectors.T) @ np.diag(1 / scale) @ flip, (vectors.T @ (scale * c)) / root)
        weights = flip @ w
        return float(yy - 2 * weights @ b + weights @ G @ weights), np.asarray(weights)

    def _between(self, squares: Array, k: int) -> float:
        """The least of the parabola through the logarithms about the best of the grid."""
        taus = self.bank.taus
        if not 0 < k < len(taus) - 1:
            return float(taus[k])
        a, b, c = np.log(np.maximum(squares[k - 1 : k + 2], 1e-300))
        bend = a - 2 * b + c
        shift = (a - c) / (2 * bend) if bend > 0 else 0.0
        return float(taus[k] * (taus[k + 1] / taus[k]) ** np.clip(shift, -0.5, 0.5))

    def select(self, always: Sequence[str], candidates: Sequence[str]) -> LagFit:
        """Forward selection: candidates join `always` as long as the best of them is worth its numbers."""
        chosen, best = list(always), self.fit(always)
        left = [name for name in candidates if name not in chosen]
        while left:
            tried = [self.fit([*chosen, name]) for name in left]
            j = int(np.argmax([one.gain_over(best) if left[k] in one.weights else -np.inf
                               for k, one in enumerate(tried)]))  # fmt: skip
            if tried[j].gain_over(best) <= 0 or left[j] not in tried[j].weights:
                break
            best = tried[j]
            chosen.append(left.pop(j))
        return best


def count_independent(residual: Array, run: Indices) -> float:
    """n/(1 + 2 Σ ρ) of every run, added up; residual: over the cells of all runs, NaN in gaps, run: of each cell."""
    total = 0.0
    for one in np.unique(run):
        row = residual[run == one][None]
        there = np.isfinite(row).astype(float)
        if there.sum() > 3 and float(np.nansum(row**2)) > 0:
            r, _ = autocorrelations(np.where(there > 0, row, 0.0), there)
            total += float(there.sum() / (1 + 2 * until_dead(r)[0, 1:].sum()))
    return max(total, 1.0)
