"""Exact solution of an affine network in its modes.

Each regime is diagonalised once: A = V (−Λ) V⁻¹, symmetric after scaling with √C where nothing flows one way. A mode
with rate λ and forcing p + r τ moves as x(τ) = e^(−λτ) x₀ + τ φ₁(−λτ) p + τ² φ₂(−λτ) r, so the only error is rounding.
Source of the φ functions: Hochbruck & Ostermann, Acta Numerica 19 (2010) 209, eq. 2.10.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.declare import Array
from network.solvers.linear import LinearProblem, LinearSolution, Regime
from network.solvers.plan import Plan

WORST_CONDITION = 1e6
"""Of the eigenvectors: beyond it the rounding would exceed 1e-9 K and the exponential path takes over."""
FEW_SAMPLES = 6
"""Output samples for each interval below which all intervals are done at once rather than one by one."""
SLOW = 1e-3
CHUNK = 2_000_000


@dataclass(frozen=True)
class Modes:
    """x = V m, m = W x; decay rates λ [1/s]."""

    rates: Array
    V: Array
    W: Array
    condition: float

    @cached_property
    def is_real(self) -> bool:
        return not np.iscomplexobj(self.rates)


def modes_of(regime: Regime, scale: Array) -> Modes:
    """The modes of one regime."""
    B = scale[:, None] * regime.A / scale
    if regime.is_symmetric:
        values, U = np.linalg.eigh((B + B.T) / 2)
        return Modes(np.maximum(-values, 0.0), U / scale[:, None], U.T * scale, 1.0)
    values, U = np.linalg.eig(B)
    condition = float(np.linalg.cond(U))
    inverse = np.linalg.inv(U) if condition < 1e12 else np.zeros_like(U)
    return Modes(-values, U / scale[:, None], inverse * scale, condition)


def phi(z: Array) -> tuple[Array, Array, Array]:
    """φ₁, φ₂, φ₃ at z: (eᶻ − 1)/z, (φ₁ − 1)/z, (φ₂ − ½)/z, by series where these cancel."""
    small = np.abs(z) < 0.5
    safe = np.where(small, 1.0, z)
    one = np.where(z == 0, 1.0, np.expm1(z) / np.where(z == 0, 1.0, z))
    two, three = (one - 1) / safe, ((one - 1) / safe - 0.5) / safe
    if small.any():
        series = [np.zeros_like(z[small]), np.zeros_like(z[small])]
        for k in range(15, -1, -1):
            series = [s * z[small] / (k + n + 1) + 1.0 for n, s in zip((2, 3), series, strict=True)]
        two[small], three[small] = series[0] / 2, series[1] / 6
    return one, two, three


def solve(problem: LinearProblem, each_interval: bool = False) -> LinearSolution | None:
    """The solution, or None where the modes are too badly conditioned (equal cells in a stream, for instance)."""
    modes = [modes_of(regime, problem.scale) for regime in problem.regimes]
    if max(m.condition for m in modes) > WORST_CONDITION:
        return None
    run = _Run(problem, modes, each_interval)
    few = len(problem.plan.t) < FEW_SAMPLES * len(problem.plan.steps)
    run.march()
    y = run.sample_at_once() if few else run.sample_by_interval()
    y[:, : len(problem.readouts.offset)] += problem.readouts.offset
    size = float(np.abs(problem.x0).max(initial=1.0))
    error = 4 * np.finfo(float).eps * max(m.condition for m in modes) * size * np.sqrt(len(problem.plan.steps))
    return LinearSolution(y, run.x_end, run.x_integral, each_interval, float(error))


class _Run:
    """One run: states at all edges first (march), then the readings in between (sample)."""

    def __init__(self, problem: LinearProblem, modes: list[Modes], each_interval: bool) -> None:
        self.problem, self.modes, self.each_interval = problem, modes, each_interval
        steps = len(problem.plan.steps)
        kind = float if all(m.is_real for m in modes) else complex
        self.m = np.empty((steps, problem.order), kind)
        self.p, self.r = np.empty_like(self.m), np.empty_like(self.m)
        rows = steps if each_interval else len(problem.regimes)
        self.x_integral = np.zeros((rows, problem.order))

    def march(self) -> None:
        """Modal states at the left edge of every interval, and the integrals."""
        plan, x = self.problem.plan, self.problem.x0
        for first, last, regime in self._stretches():
            modes, h = self.modes[regime], plan.steps[first:last, None]
            here = slice(first, last)
            self.p[here] = self.problem.f0[here] @ modes.W.T
            self.r[here] = (self.problem.f1[here] - self.problem.f0[here]) @ modes.W.T / h
            one, two, three = phi(-modes.rates * h)
            gain = np.exp(-modes.rates * h)
            push = h * one * self.p[here] + h * h * two * self.r[here]
            self.m[here], end = scan(gain, push, modes.W @ x)
            self._integrate(here, regime, h * one * self.m[here] + h**2 * two * self.p[here] + h**3 * three * self.r[here])
            x = np.real(modes.V @ end)
        self.x_end = x

    def _integrate(self, here: slice, regime: int, integral: Array) -> None:
        V = self.modes[regime].V
        if self.each_interval:
            self.x_integral[here] = np.real(integral @ V.T)
        else:
            self.x_integral[regime] += np.real(V @ integral.sum(axis=0))

    def _stretches(self) -> Iterator[tuple[int, int, int]]:
        """Runs of intervals in one regime: first, last (excluded), regime."""
        regime_of = self.problem.regime_of
        cuts = np.flatnonzero(np.diff(regime_of)) + 1
        for first, last in zip([0, *cuts], [*cuts, len(regime_of)], strict=True):
            yield int(first), int(last), int(regime_of[first])

    def sample_at_once(self) -> Array:
        """Readings at every instant from its own interval's state: for inputs that change at nearly every sample."""
        plan, problem = self.problem.plan, self.problem
        y = np.empty((len(plan.t), len(problem.readouts.keys) + problem.readouts.states))
        interval = plan.interval_of
        for r, regime in enumerate(problem.regimes):
            rows = problem.outputs(regime) @ self.modes[r].V
            mine = np.flatnonzero(problem.regime_of[interval] == r)
            for at in np.array_split(mine, max(1, len(mine) * problem.order // CHUNK)):
                y[at] = np.real(self._states(r, interval[at], plan.t[at]) @ rows.T)
                self._add_direct(y, regime, interval[at], at)
        return y

    def _states(self, r: int, k: Array, t: Array) -> Array:
        tau = (t - self.problem.plan.edges[k])[:, None]
        if not tau.any():
            return self.m[k]
        z = -self.modes[r].rates * tau
        one, two, _ = phi(z)
        return np.exp(z) * self.m[k] + tau * one * self.p[k] + tau * tau * two * self.r[k]

    def _add_direct(self, y: Array, regime: Regime, k: Array, at: Array) -> None:
        plan = self.problem.plan
        seen = self.problem.direct(regime, k, (plan.t[at] - plan.edges[k]) / plan.steps[k])
        if seen is not None:
            y[at] += seen

    def sample_by_interval(self) -> Array:
        """Readings interval by interval from one table of decays for each regime, where output is evenly spaced."""
        plan, problem = self.problem.plan, self.problem
        y = np.empty((len(plan.t), len(problem.readouts.keys) + problem.readouts.states))
        bounds = plan.bounds
        for r, regime in enumerate(problem.regimes):
            mine = np.flatnonzero((problem.regime_of == r) & (np.diff(bounds) > 0))
            if len(mine):
                table = _Table(problem.outputs(regime), self.modes[r], plan, mine)
                table.fill(y, self.m[mine], self.p[mine], self.r[mine])
            if problem.has_direct(regime):
                at = np.flatnonzero(problem.regime_of[plan.interval_of] == r)
                self._add_direct(y, regime, plan.interval_of[at], at)
        return y


class _Table:
    """Readings of one regime over time since an edge: decays on the grid once, then one product for each interval.

    Fast modes in closed form, e^(−λτ)(m − s) + s + τ r/λ with s = p/λ − r/λ²; slow ones (λτ ≪ 1), where that would
    cancel, by φ functions.
    """

    def __init__(self, outputs: Array, modes: Modes, plan: Plan, intervals: Array) -> None:
        self.rates, self.rows, self.t = modes.rates, outputs @ modes.V, plan.t
        self.first, self.last = plan.bounds[intervals], plan.bounds[intervals + 1]
        self.since = plan.t[self.first] - plan.edges[intervals]
        self.slow = np.abs(self.rates) * float(plan.t[-1] - plan.t[0]) < SLOW
        longest = int((self.last - self.first).max())
        self.grid = powers(self.rates, plan.spacing, longest) if plan.spacing else None

    def fill(self, y: Array, m: Array, p: Array, r: Array) -> None:
        rate = np.where(self.slow, 1.0, self.rates)
        drift = np.where(self.slow, 0.0, r / rate)
        settled = np.where(self.slow, 0.0, (p - drift) / rate)
        start = np.exp(-np.outer(self.since, self.rates)) * np.where(self.slow, 0.0, m - settled)
        level, climb = np.real(settled @ self.rows.T), np.real(drift @ self.rows.T)
        for i, (first, last) in enumerate(zip(self.first.tolist(), self.last.tolist(), strict=True)):
            here = y[first:last]
            np.copyto(here, np.real(self._decays(first, last) @ (self.rows * start[i]).T))
            here += level[i]
            if climb[i].any():
                here += self._tau(i)[:, None] * climb[i]
            if self.slow.any():
                here += self._slow_readings(self._tau(i)[:, None], m[i], p[i], r[i])

    def _tau(self, i: int) -> Array:
        at = self.t[self.first[i] : self.last[i]]
        return np.asarray(at - at[0] + self.since[i])

    def _decays(self, first: int, last: int) -> Array:
        """e^(−λ τ) since the first sample of an interval."""
        if self.grid is not None:
            return self.grid[: last - first]
        return np.exp(-np.outer(self.t[first:last] - self.t[first], self.rates))

    def _slow_readings(self, tau: Array, m: Array, p: Array, r: Array) -> Array:
        slow = self.slow
        z = -self.rates[slow] * tau
        one, two, _ = phi(z)
        states = np.exp(z) * m[slow] + tau * one * p[slow] + tau * tau * two * r[slow]
        return np.real(states @ self.rows[:, slow].T)


def powers(rates: Array, spacing: float, count: int) -> Array:
    """e^(−λ k Δ) for k < count, as products of two short tables."""
    block = max(1, int(np.sqrt(count)))
    fine = np.exp(-np.outer(np.arange(block) * spacing, rates))
    coarse = np.exp(-np.outer(np.arange(-(-count // block)) * (block * spacing), rates))
    return (coarse[:, None, :] * fine).reshape(-1, len(rates))[:count]


def scan(gain: Array, push: Array, start: Array) -> tuple[Array, Array]:
    """x[0] = start, x[k+1] = gain[k] x[k] + push[k]: all x[k] before each step, and the last one.

    Blocks of √K steps run side by side, so the interpreter takes 2√K steps instead of K.
    """
    count, width = push.shape
    block = max(1, int(np.sqrt(count)))
    blocks = -(-count // block)
    pad = blocks * block - count
    g = np.concatenate([gain, np.ones((pad, width))]).reshape(blocks, block, width)
    f = np.concatenate([push, np.zeros((pad, width))]).reshape(blocks, block, width)
    product, total = np.empty_like(g), np.empty_like(f)
    running, carried = np.ones((blocks, width), g.dtype), np.zeros((blocks, width), f.dtype)
    for i in range(block):
        product[:, i], total[:, i] = running, carried
        running, carried = running * g[:, i], carried * g[:, i] + f[:, i]
    x, heads = start.astype(f.dtype), np.empty((blocks, width), f.dtype)
    for b in range(blocks):
        heads[b] = x
        x = running[b] * x + carried[b]
    states = (product * heads[:, None] + total).reshape(-1, width)[:count]
    return states, x


