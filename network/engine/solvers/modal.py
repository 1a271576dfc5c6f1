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

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.engine.solvers.linear import CHUNK, LinearProblem, LinearSolution, Regime
from network.engine.solvers.plan import Plan

WORST_CONDITION = 1e6
"""Of the eigenvectors: beyond it the rounding would exceed 1e-9 K and the exponential path takes over."""
FEW_SAMPLES = 6
"""Output samples for each interval up to which every sample is computed from its own interval's state."""
FEW_STEPS = 32
"""Steps of a scan that are worth no blocks."""
BLOCK = 128
AT_A_TIME = 32
"""Blocks in one product: its operands stay in the cache and need no fresh pages."""
PHI_SERIES = (1 / np.cumprod(np.arange(1.0, 16.0))[2:]).tolist()
"""1/(k+3)! of φ₃."""
SLOW = 1e-3


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
        return Modes(_without_rounding(-values), U / scale[:, None], U.T * scale, 1.0)
    values, U = np.linalg.eig(B)
    condition = float(np.linalg.cond(U))
    inverse = np.linalg.inv(U) if condition < 1e12 else np.zeros_like(U)
    return Modes(-values, U / scale[:, None], inverse * scale, condition)


def _without_rounding(rates: Array) -> Array:
    """A machine that nothing cools has a mode of rate 0, which rounding (N ε of the largest) makes a slow growth; what
    grows faster than that does grow: heat that rises with its own temperature."""
    noise = len(rates) * np.finfo(float).eps * np.abs(rates).max(initial=0.0)
    return np.where(np.abs(rates) <= noise, 0.0, rates)


def phi(z: Array) -> tuple[Array, Array, Array]:
    """φ₁, φ₂, φ₃ at z: (eᶻ − 1)/z, (φ₁ − 1)/z, (φ₂ − ½)/z, by the series of φ₃ where these cancel."""
    small = np.abs(z) < 0.5
    safe = np.where(small, 1.0, z)
    one = np.expm1(z) / safe
    two = (one - 1) / safe
    three = (two - 0.5) / safe
    if small.any():
        near = z[small]
        third = np.full_like(near, PHI_SERIES[-1])
        for coefficient in PHI_SERIES[-2::-1]:
            third = third * near + coefficient
        second = 0.5 + near * third
        one[small], two[small], three[small] = 1 + near * second, second, third
    return one, two, three


def solve(problem: LinearProblem, each_interval: bool = False) -> LinearSolution | None:
    """The solution, or None where the modes are too badly conditioned (equal cells in a stream, for instance)."""
    modes = [modes_of(regime, problem.scale) for regime in problem.regimes]
    if max(m.condition for m in modes) > WORST_CONDITION:
        return None
    run = _Run(problem, modes, each_interval)
    run.march()
    many = problem.plan.spacing > 0 and len(problem.plan.t) > FEW_SAMPLES * len(problem.plan.steps)
    y = run.sample_by_blocks() if many else run.sample_at_once()
    problem.add_direct(y)
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
            gain = 1 - modes.rates * h * one
            push = h * one * self.p[here] + h * h * two * self.r[here]
            self.m[here], end = scan(gain, push, modes.W @ x)
            self._integrate(
                here, regime, h * one * self.m[here] + h**2 * two * self.p[here] + h**3 * three * self.r[here]
            )
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

    def _empty(self) -> Array:
        return np.empty((self.problem.readouts.width, len(self.problem.plan.t)))

    def sample_at_once(self) -> Array:
        """Readings at every instant from its own interval's state: for inputs that change at nearly every sample."""
        plan, problem, y = self.problem.plan, self.problem, self._empty()
        interval = plan.interval_of
        for r, regime in enumerate(problem.regimes):
            rows = problem.outputs(regime) @ self.modes[r].V
            mine = np.flatnonzero(problem.regime_of[interval] == r)
            for at in np.array_split(mine, max(1, len(mine) * problem.order // CHUNK)):
                y[:, at] = np.real(rows @ self._states(r, interval[at], plan.t[at]).T)
        return y

    def _states(self, r: int, k: Indices, t: Array) -> Array:
        tau = (t - self.problem.plan.edges[k])[:, None]
        if not tau.any():
            return np.asarray(self.m[k])
        z = -self.modes[r].rates * tau
        one, two, _ = phi(z)
        return np.asarray(np.exp(z) * self.m[k] + tau * one * self.p[k] + tau * tau * two * self.r[k])

    def sample_by_blocks(self) -> Array:
        """Readings where output is evenly spaced and intervals hold many samples: one product for each regime."""
        plan, problem, y = self.problem.plan, self.problem, self._empty()
        for r, regime in enumerate(problem.regimes):
            mine = np.flatnonzero((problem.regime_of == r) & (np.diff(plan.bounds) > 0))
            if len(mine):
                rows = problem.outputs(regime) @ self.modes[r].V
                _Blocks(plan, mine).fill(y, rows, self.modes[r].rates, self)
        return y


class _Blocks:
    """Samples of some intervals in blocks of BLOCK: e^(−λτ) is a factor of the block times one of the place in it.

    With s = p/λ − r/λ² and d = r/λ a fast mode moves as e^(−λτ)(m − s) + s + τ d: a product of block rows (modes, a
    constant, a slope) with columns (decays over the block, one, time). Slow modes (λτ ≪ 1), where that would cancel,
    go by φ functions.
    """

    def __init__(self, plan: Plan, intervals: Indices) -> None:
        self.plan, self.intervals = plan, intervals
        self.first, self.last = plan.bounds[intervals], plan.bounds[intervals + 1]
        self.count = -(-(self.last - self.first) // BLOCK)
        self.begin = np.cumsum(self.count) - self.count
        nth = np.arange(self.count.sum()) - np.repeat(self.begin, self.count)
        since = plan.t[self.first] - plan.edges[intervals]
        self.tau = np.repeat(since, self.count) + nth * (BLOCK * plan.spacing)
        self.within = np.arange(BLOCK) * plan.spacing

    def fill(self, y: Array, rows: Array, rates: Array, run: _Run) -> None:
        """Puts the readings of the intervals into y (rows × samples)."""
        slow = np.abs(rates) * float(self.plan.t[-1] - self.plan.t[0]) < SLOW
        right = np.vstack([np.exp(np.multiply.outer(-rates, self.within)), np.ones(BLOCK), self.within])
        moving, level, climb = self._factors(rows, rates, slow, run)
        for some in self._portions():
            blocks = slice(self.begin[some[0]], self.begin[some[-1]] + self.count[some[-1]])
            left = np.empty((len(rows), blocks.stop - blocks.start, len(right)), moving.dtype)
            np.multiply(rows[:, None, :], moving[blocks], out=left[:, :, :-2])
            left[:, :, -2], left[:, :, -1] = level[:, blocks], climb[:, blocks]
            readings = np.real(left.reshape(-1, len(right)) @ right).reshape(len(rows), -1)
            for i in some:
                begin, first, last = (self.begin[i] - blocks.start) * BLOCK, self.first[i], self.last[i]
                y[:, first:last] = readings[:, begin : begin + last - first]
        if slow.any():
            for k, first, last in zip(self.intervals, self.first, self.last, strict=True):
                y[:, first:last] += self._slow_readings(rows[:, slow], rates[slow], slow, run, k, slice(first, last))

    def _portions(self) -> Iterator[range]:
        """Intervals, as many at a time as make some AT_A_TIME blocks."""
        portion = (self.begin // AT_A_TIME).tolist()
        cuts = [i for i in range(1, len(portion)) if portion[i] != portion[i - 1]]
        return (range(a, b) for a, b in zip([0, *cuts], [*cuts, len(portion)], strict=True))

    def _factors(self, rows: Array, rates: Array, slow: Mask, run: _Run) -> tuple[Array, Array, Array]:
        """Of every block: what its modes decay from (blocks × modes), where its readings settle, how they climb."""
        m, p, r = (part[self.intervals] for part in (run.m, run.p, run.r))
        safe = np.where(slow, 1.0, rates)
        drift = np.where(slow, 0.0, r / safe)
        settled = np.where(slow, 0.0, (p - drift) / safe)
        moving = np.repeat(np.where(slow, 0.0, m - settled), self.count, axis=0)
        moving *= np.exp(np.multiply.outer(-self.tau, rates))
        climb = np.repeat(rows @ drift.T, self.count, axis=1)
        return moving, np.repeat(rows @ settled.T, self.count, axis=1) + self.tau * climb, climb

    def _slow_readings(self, rows: Array, rates: Array, slow: Mask, run: _Run, k: int, at: slice) -> Array:
        tau = (self.plan.t[at] - self.plan.edges[k])[:, None]
        one, two, _ = phi(-rates * tau)
        states = np.exp(-rates * tau) * run.m[k, slow] + tau * one * run.p[k, slow] + tau * tau * two * run.r[k, slow]
        return np.real(rows @ states.T)


def scan(gain: Array, push: Array, start: Array) -> tuple[Array, Array]:
    """x[0] = start, x[k+1] = gain[k] x[k] + push[k]: all x[k] before each step, and the last one.

    Blocks of √K steps run side by side, so the interpreter takes 2√K steps instead of K; a few go one by one.
    """
    count, width = push.shape
    if count <= FEW_STEPS:
        return _one_by_one(gain, push, start.astype(push.dtype))
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


def _one_by_one(gain: Array, push: Array, x: Array) -> tuple[Array, Array]:
    states = np.empty_like(push)
    for k in range(len(push)):
        states[k] = x
        x = gain[k] * x + push[k]
    return states, x
