"""A temperature as the lagged sum of what drives it, by least squares; what is worth a place in it, by evidence.

T with τ dT/dt = Σ w_q (T_q − T) + Σ g_u u, Σ w = 1, w ≥ 0: a part of heat capacity C with conductances G_q = w_q C/τ to
surroundings and other parts and heats g_u u C/τ. In deviations from a constant of the run it is the sum of its drivers
through one lag, and of its first reading times e^(−t/τ).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import exp

import numpy as np
from scipy.optimize import brentq, minimize, minimize_scalar, nnls
from scipy.special import expit, logit

from network.analysis.comparison.lags import autocorrelations, until_dead
from network.analysis.drafting.lag_bank import LagBank
from network.catalogue.declaration.declare import Array, Indices

RIDGE = 1e-11
"""Of the squares of a column: what keeps columns apart that rounding cannot."""
APART = 0.1
"""By which share two lags differ at the least: nearer ones are told as one."""
COARSE, SHARES, EVALUATIONS = 4, (0.2, 0.5, 0.8), 120
"""Where two lags are begun: every so many of the time constants of the grid, shares of the shorter; and how often the
best of them is bettered."""
BOUND = 1e6
"""How many times as heavy as the readings it weighs that conductances add up to the whole."""


@dataclass(frozen=True)
class TwoLags:
    """A part with another behind it that has no sensor and loses no heat but to it: in place of one lag the share `a`
    of one and 1 − a of a longer [s]. With G all that the part loses heat by and τ_z = a τ₂ + (1 − a) τ₁, its transfer
    function (1 + τ_z s)/((1 + τ₁ s)(1 + τ₂ s)) has C₁ = G τ₁ τ₂/τ_z, C₂ = G (τ_z − τ₁)(τ₂ − τ_z)/τ_z, and C₂/τ_z
    between the two. Where τ_z = 0, a = −τ₁/(τ₂ − τ₁), one lag stands behind the other: a sensor of lag τ₁ on a part
    of τ₂.
    """

    short: float
    long: float
    share: float

    @property
    def terms(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Share and time constant of each."""
        return (self.share, self.short), (1 - self.share, self.long)

    @property
    def is_late(self) -> bool:
        """Whether one lag stands behind the other."""
        return self.share < 0

    @property
    def zero(self) -> float:
        return self.share * self.long + (1 - self.share) * self.short

    @property
    def own(self) -> float:
        """C₁/G [s]."""
        return self.short * self.long / self.zero

    @property
    def behind(self) -> float:
        """C₂/G [s]."""
        return (self.zero - self.short) * (self.long - self.zero) / self.zero

    @property
    def most(self) -> float:
        """When 63 % of a step is reached [s]."""

        def left(t: float) -> float:
            return self.share * exp(-t / self.short) + (1 - self.share) * exp(-t / self.long) - exp(-1)

        return float(brentq(left, self.short / 2, 3 * self.long))


@dataclass(frozen=True, eq=False)
class LagFit:
    """tau: [s], 63 % of a step where there are two lags; weights: w of temperatures, g of inputs; square: mean square
    that is left; numbers: how many were fitted; residual: over all cells, NaN in gaps; independent: readings that are
    worth one each; lags: of two, None for one."""

    tau: float
    weights: Mapping[str, float]
    square: float
    numbers: int
    residual: Array
    independent: float
    lags: TwoLags | None = None

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
        found = [self._solve(m[np.ix_([*use, -1], [*use, -1])], drivers) for m in self.moments]
        squares = np.array([square for square, _ in found])
        k = int(np.argmin(squares))
        weights = _by_name(drivers, found[k][1])
        residual = self.bank.residual(self.target, k, weights)
        return self._told(self._between(squares, k), weights, residual, self._numbers(drivers))

    def refine(self, fit: LagFit) -> LagFit:
        """The same drivers at the best of all time constants, not only of those of the grid."""
        drivers = [name for name in self.bank.names if name in fit.weights]
        step = float(self.bank.taus[1] / self.bank.taus[0])
        ends = float(np.log(fit.tau / step)), float(np.log(fit.tau * step))
        best = minimize_scalar(lambda x: self._exact([(1.0, exp(x))], drivers)[0], bounds=ends, method="bounded")
        tau = exp(float(best.x))
        _, w, residual = self._exact([(1.0, tau)], drivers)
        return self._told(tau, _by_name(drivers, w), residual, fit.numbers)

    def _exact(self, lags: Sequence[tuple[float, float]], drivers: Sequence[str]) -> tuple[float, Array, Array]:
        """(sum of squares left, weights, residual) of a sum of lags, each with its share and time constant."""
        parts = [(share, *self.bank.at(tau, drivers)) for share, tau in lags]
        x = np.sum([share * columns for share, columns, _ in parts], axis=0)
        decay = np.sum([share * decay for share, _, decay in parts], axis=0)
        y, there = self.target - self.bank.begins(self.target) * decay, np.isfinite(self.target)
        both = np.column_stack([x, y])[there]
        square, w = self._solve(both.T @ both, drivers)
        return square, w, y - x @ w

    def fit_two(self, drivers: Sequence[str], only_late: bool) -> LagFit:
        """The same with two lags; only_late: one behind the other."""
        ends = combinations(self.bank.taus[::COARSE].tolist(), 2)
        shares = () if only_late else SHARES
        tried = [one for a, b in ends for one in (_late(a, b), *(TwoLags(a, b, share) for share in shares))]
        begin = min(tried, key=lambda one: self._exact(one.terms, drivers)[0])
        lags = self._nearest(begin, drivers)
        _, w, residual = self._exact(lags.terms, drivers)
        more = 1 if lags.is_late else 2
        told = self._told(lags.most, _by_name(drivers, w), residual, self._numbers(drivers) + more)
        return replace(told, lags=lags)

    def _nearest(self, begin: TwoLags, drivers: Sequence[str]) -> TwoLags:
        """The best of all two lags, of one kind, about those of the grid."""

        least, most = float(self.bank.taus[0]), float(self.bank.taus[-1])

        def read(x: Array) -> TwoLags:
            """Within the grid, the longer lag a tenth longer at least."""
            short = exp(np.clip(x[0], np.log(least), np.log(most / (1 + APART))))
            long = min(short * (1 + max(exp(min(x[1], 50.0)), APART)), most)
            return _late(short, long) if begin.is_late else TwoLags(short, long, expit(x[2]))

        x = [
            np.log(begin.short),
            np.log(begin.long / begin.short - 1),
            *([] if begin.is_late else [logit(begin.share)]),
        ]
        best = minimize(lambda x: self._exact(read(x).terms, drivers)[0], x, method="Nelder-Mead",
                        options={"maxfev": EVALUATIONS, "xatol": 0.01, "fatol": 0.0})  # fmt: skip
        return read(best.x)

    def _told(self, tau: float, weights: Mapping[str, float], residual: Array, numbers: int) -> LagFit:
        known = max(int(np.isfinite(self.target).sum()), 1)
        left = max(float(np.nansum(residual**2)) / known, self.floor)
        return LagFit(tau, weights, left, numbers, residual, count_independent(residual, self.bank.run))

    def _numbers(self, drivers: Sequence[str]) -> int:
        """A time constant, a gain for every input, and shares that add up to 1."""
        conduct = sum(name in self.conducts for name in drivers)
        return 1 + len(drivers) - conduct + max(conduct - 1, 0)

    def _solve(self, moments: Array, drivers: Sequence[str]) -> tuple[float, Array]:
        """(sum of squares left, weights): non-negative least squares from moments of drivers and target."""
        G, b, yy = moments[:-1, :-1], moments[:-1, -1], float(moments[-1, -1])
        flow = np.array([name in self.conducts for name in drivers], float)
        heavy = BOUND * max(float(np.trace(G)), yy, 1e-300) * bool(flow.any())
        A = G + heavy * np.outer(flow, flow) + np.diag(RIDGE * np.diag(G) + 1e-300)
        c = b + heavy * flow
        free = [i for i, name in enumerate(drivers) if name in self.signed]
        flip = np.hstack([np.eye(len(drivers)), -np.eye(len(drivers))[:, free]])
        scale = 1 / np.sqrt(np.maximum(np.diag(A), 1e-300))
        values, vectors = np.linalg.eigh(A * np.outer(scale, scale))
        root = np.sqrt(np.maximum(values, 1e-14 * values.max()))
        w, _ = nnls((root[:, None] * vectors.T) @ np.diag(1 / scale) @ flip, (vectors.T @ (scale * c)) / root)
        weights = np.asarray(flip @ w)
        return float(yy - 2 * weights @ b + weights @ G @ weights), weights

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


def _late(short: float, long: float) -> TwoLags:
    """One lag behind the other."""
    return TwoLags(short, long, -short / (long - short))


def _by_name(drivers: Sequence[str], weights: Array) -> dict[str, float]:
    return {name: float(w) for name, w in zip(drivers, weights, strict=True) if w != 0}


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
