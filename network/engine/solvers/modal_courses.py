"""Readings of a modal solution, from the modal states at the edges of its intervals, when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.engine.solvers.courses import Courses, KnownCourses
from network.engine.solvers.linear import CHUNK, LinearProblem
from network.engine.solvers.modal import SLOW, Modes, phi
from network.engine.solvers.plan import Plan

FEW_SAMPLES = 6
"""Output samples for each interval up to which every sample is computed from its own interval's state."""
BLOCK = 128
AT_A_TIME = 32
"""Blocks in one product: its operands stay in the cache and need no fresh pages."""


@dataclass(frozen=True)
class ModalStates:
    """Modal states m at the left edge of every interval and the forcing p + r τ of it (K, n); how far a steady and a
    growing forcing carry them over it: a = h φ₁ and b = h² φ₂."""

    m: Array
    p: Array
    r: Array
    a: Array
    b: Array


class ModalCourses(Courses):
    """Worked out from the states, and kept."""

    def __init__(self, problem: LinearProblem, modes: Sequence[Modes], states: ModalStates) -> None:
        self.problem, self.modes, self.states = problem, modes, states
        self._known: dict[int, Array] = {}

    @property
    def width(self) -> int:
        return self.problem.readouts.width

    def __getitem__(self, row: int) -> Array:
        return self._known[row] if row in self._known else self.rows(np.array([row]))[0]

    def rows(self, which: Indices) -> Array:
        new = np.array([row for row in np.unique(which).tolist() if row not in self._known], int)
        if len(new):
            found = new if self._is_long else np.arange(self.width)
            y = self._work_out(found)
            self._known.update(zip(found.tolist(), y, strict=True))
            if np.array_equal(found, which):
                return y
        known = [self._known[row] for row in which.tolist()]
        return np.stack(known) if known else np.empty((0, len(self.problem.plan.t)))

    @property
    def _is_long(self) -> bool:
        """Whether output is evenly spaced and intervals hold many samples; else all rows cost hardly more than one."""
        plan = self.problem.plan
        return plan.spacing > 0 and len(plan.t) > FEW_SAMPLES * len(plan.steps)

    def _work_out(self, which: Indices) -> Array:
        y = np.empty((len(which), len(self.problem.plan.t)))
        sample = self._sample_by_blocks if self._is_long else self._sample_at_once
        sample(y, which)
        self.problem.add_direct(y, which)
        return y

    def _over_modes(self, r: int, which: Indices) -> Array:
        return np.asarray(self.problem.outputs(self.problem.regimes[r], which) @ self.modes[r].V)

    def limits(self) -> tuple[Array, Array]:
        """With v = p − λ m, m(τ) lies within a |v| + b |r| of m for real modes, and the direct part runs straight."""
        if not self._is_long or not all(modes.is_real for modes in self.modes):
            return KnownCourses(self.all()).limits()
        low, high = np.full(self.width, np.inf), np.full(self.width, -np.inf)
        everything = np.arange(self.width)
        for r, modes in enumerate(self.modes):
            mine, over = np.flatnonzero(self.problem.regime_of == r), self._over_modes(r, everything)
            lines, first, last = self.problem.see_at_once(r)
            for at in np.array_split(np.arange(len(mine)), max(1, len(mine) * self.width // CHUNK)):
                m, p, slope, a, b = (getattr(self.states, name)[mine[at]] for name in ("m", "p", "r", "a", "b"))
                reach = (a * np.abs(p - modes.rates * m) + b * np.abs(slope)) @ np.abs(over).T
                here = m @ over.T
                below, above = here - reach, here + reach
                below[:, lines] += np.minimum(first[at], last[at])
                above[:, lines] += np.maximum(first[at], last[at])
                low, high = np.minimum(low, below.min(axis=0)), np.maximum(high, above.max(axis=0))
        return low, high

    # -- few samples in each interval -------------------------------------------------------------------------------
    def _sample_at_once(self, y: Array, which: Indices) -> None:
        """Readings at every instant from its own interval's state: for inputs that change at nearly every sample."""
        plan, interval = self.problem.plan, self.problem.plan.interval_of
        for r in range(len(self.modes)):
            rows = self._over_modes(r, which)
            mine = np.flatnonzero(self.problem.regime_of[interval] == r)
            for at in np.array_split(mine, max(1, len(mine) * self.problem.order // CHUNK)):
                y[:, at] = np.real(rows @ self._states(r, interval[at], plan.t[at]).T)

    def _states(self, r: int, k: Indices, t: Array) -> Array:
        since, s = t - self.problem.plan.edges[k], self.states
        states, later = s.m[k], np.flatnonzero(since)
        if len(later):
            k, tau = k[later], since[later, None]
            z = -self.modes[r].rates * tau
            one, two, _ = phi(z)
            states[later] = np.exp(z) * s.m[k] + tau * one * s.p[k] + tau * tau * two * s.r[k]
        return np.asarray(states)

    # -- many -------------------------------------------------------------------------------------------------------
    def _sample_by_blocks(self, y: Array, which: Indices) -> None:
        """One product for each regime."""
        for r, blocks in self._blocks.items():
            blocks.fill(y, self._over_modes(r, which))

    @cached_property
    def _blocks(self) -> dict[int, _Blocks]:
        plan, of = self.problem.plan, self.problem.regime_of
        has_samples = np.diff(plan.bounds) > 0
        each = {r: np.flatnonzero((of == r) & has_samples) for r in range(len(self.modes))}
        return {r: _Blocks(plan, mine, self.modes[r].rates, self.states) for r, mine in each.items() if len(mine)}


class _Blocks:
    """Samples of some intervals in blocks of BLOCK: e^(−λτ) is a factor of the block times one of the place in it.

    With s = p/λ − r/λ² and d = r/λ a fast mode moves as e^(−λτ)(m − s) + s + τ d: a product of block rows (modes, a
    constant, a slope) with columns (decays over the block, one, time). Slow modes (λτ ≪ 1), where that would cancel,
    go by φ functions.
    """

    def __init__(self, plan: Plan, intervals: Indices, rates: Array, states: ModalStates) -> None:
        self.plan, self.intervals, self.rates, self.states = plan, intervals, rates, states
        self.first, self.last = plan.bounds[intervals], plan.bounds[intervals + 1]
        self.count = -(-(self.last - self.first) // BLOCK)
        self.begin = np.cumsum(self.count) - self.count
        nth = np.arange(self.count.sum()) - np.repeat(self.begin, self.count)
        since = plan.t[self.first] - plan.edges[intervals]
        self.tau = np.repeat(since, self.count) + nth * (BLOCK * plan.spacing)
        within = np.arange(BLOCK) * plan.spacing
        self.slow = np.abs(rates) * float(plan.t[-1] - plan.t[0]) < SLOW
        self.right = np.vstack([np.exp(np.multiply.outer(-rates, within)), np.ones(BLOCK), within])
        self.drift, self.settled, self.moving = self._factors()

    def _factors(self) -> tuple[Array, Array, Array]:
        """Of every interval: how its modes climb and where they settle; of every block: what they decay from."""
        m, p, r = (part[self.intervals] for part in (self.states.m, self.states.p, self.states.r))
        safe = np.where(self.slow, 1.0, self.rates)
        drift = np.where(self.slow, 0.0, r / safe)
        settled = np.where(self.slow, 0.0, (p - drift) / safe)
        moving = np.repeat(np.where(self.slow, 0.0, m - settled), self.count, axis=0)
        moving *= np.exp(np.multiply.outer(-self.tau, self.rates))
        return drift, settled, moving

    def fill(self, y: Array, rows: Array) -> None:
        """Puts rows over the modes into y (rows × samples)."""
        climb = np.repeat(rows @ self.drift.T, self.count, axis=1)
        level = np.repeat(rows @ self.settled.T, self.count, axis=1) + self.tau * climb
        for some in self._portions():
            blocks = slice(self.begin[some[0]], self.begin[some[-1]] + self.count[some[-1]])
            left = np.empty((len(rows), blocks.stop - blocks.start, len(self.right)), self.moving.dtype)
            np.multiply(rows[:, None, :], self.moving[blocks], out=left[:, :, :-2])
            left[:, :, -2], left[:, :, -1] = level[:, blocks], climb[:, blocks]
            readings = np.real(left.reshape(-1, len(self.right)) @ self.right).reshape(len(rows), -1)
            for i in some:
                begin, first, last = (self.begin[i] - blocks.start) * BLOCK, self.first[i], self.last[i]
                y[:, first:last] = readings[:, begin : begin + last - first]
        if self.slow.any():
            for k, first, last in zip(self.intervals, self.first, self.last, strict=True):
                y[:, first:last] += self._slow_readings(rows[:, self.slow], self.slow, k, slice(first, last))

    def _portions(self) -> Iterator[range]:
        """Intervals, as many at a time as make some AT_A_TIME blocks."""
        portion = (self.begin // AT_A_TIME).tolist()
        cuts = [i for i in range(1, len(portion)) if portion[i] != portion[i - 1]]
        return (range(a, b) for a, b in zip([0, *cuts], [*cuts, len(portion)], strict=True))

    def _slow_readings(self, rows: Array, slow: Mask, k: int, at: slice) -> Array:
        tau, s = (self.plan.t[at] - self.plan.edges[k])[:, None], self.states
        z = -self.rates[slow] * tau
        one, two, _ = phi(z)
        states = np.exp(z) * s.m[k, slow] + tau * one * s.p[k, slow] + tau * tau * two * s.r[k, slow]
        return np.real(rows @ states.T)
