"""Intervals ahead in one regime: modal states at their edges and in between.

A mode with rate λ that begins at m with the slope v = p − λ m, under a forcing p + r τ, is at m + a v + b r after τ,
with a = τ φ₁(−λτ) and b = τ² φ₂(−λτ) (solvers.modal); it bends by e^(−λτ) (r − λ v).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.solvers.linear import LinearProblem
from network.engine.solvers.modal import SLOW, Modes, scan

STILL = 1e-100
"""1/s: what stands for a rate of zero, so that nothing is divided by it."""


class Window:
    """Intervals first to last (excluded) of one regime, whatever the relays do. heat, change: of every relay while on,
    just after the beginning of each interval and over it (K, relays) [W]; into: lumps by relays."""

    def __init__(
        self, problem: LinearProblem, modes: Modes, first: int, last: int, heat: Array, change: Array, into: Array
    ) -> None:
        here, plan, W = slice(first, last), problem.plan, modes.W
        self.first, self.last, self.regime, self.modes = first, last, int(problem.regime_of[first]), modes
        self.edges, steps = plan.edges[first : last + 1], plan.steps[here, None]
        self.rates = np.where(modes.rates == 0, STILL, modes.rates)
        self.slowest = float(np.abs(self.rates).min())
        self.by_relay = (W @ (problem.regimes[self.regime].F_heat @ into)).T
        self.p = problem.f0[here] @ W.T
        self.r = (problem.f1[here] - problem.f0[here]) @ W.T / steps
        self.heat, self.climb = heat[here], change[here] / steps
        self.is_ramped = bool(self.r.any() or self.climb.any())
        self.a, self.b = self.factors(steps)
        self.gain = 1 - self.rates * self.a
        self._forced: dict[bytes, tuple[Array, Array, Array]] = {}

    def factors(self, tau: Array) -> tuple[Array, Array]:
        """a and b at tau (points, 1), by the series of b for modes that hardly move, where it would cancel."""
        a = np.expm1(-self.rates * tau)
        a /= -self.rates
        if not self.is_ramped:
            return a, np.zeros((1, 1))
        b = tau - a
        b /= self.rates
        if self.slowest * tau[-1, 0] < SLOW:
            slow = np.abs(self.rates) * tau[-1, 0] < SLOW
            z = self.rates[slow] * tau
            b[:, slow] = tau * tau * (0.5 - z * (1 / 6 - z * (1 / 24 - z / 120)))
        return a, b

    def force_modes(self, on: Array) -> tuple[Array, Array, Array]:
        """Forcing of the modes at the beginnings of the intervals, its slope, and what both add over an interval."""
        key = on.tobytes()
        if key not in self._forced:
            p, r = self.p + (self.heat * on) @ self.by_relay, self.r + (self.climb * on) @ self.by_relay
            self._forced[key] = p, r, self.a * p + self.b * r
        return self._forced[key]

    def propagate(self, m: Array, v: Array, r: Array, tau: Array) -> Array:
        """Modes that begin at m with slope v, τ later (points, which ascend): (points, modes)."""
        a, b = self.factors(tau[:, None])
        a = a * v
        a += m
        if self.is_ramped:
            a += b * r
        return a

    def ahead(self, k: int, t: float, m: Array, on: Array, count: int, due: float) -> Ahead:
        """Some intervals from t in interval k on, where the modes are m, up to an instant that is due."""
        i, j = k - self.first, min(k + count, self.last) - self.first
        edges, is_cut = self.edges[i : j + 1].copy(), due < self.edges[j]
        if is_cut:
            edges = np.append(edges[: int(edges.searchsorted(due))], due)
            j = i + len(edges) - 1
        p, r, push = self.force_modes(on)
        v, states = p[i:j].copy(), np.empty((j - i + 1, len(m)), p.dtype)
        v[0] += (t - edges[0]) * r[i] - self.rates * m
        states[0], edges[0] = m, t
        states[1] = self.propagate(m, v[0], r[i], edges[1:2] - t)[0]
        if j > i + 1:
            states[1:-1], states[-1] = scan(self.gain[i + 1 : j], push[i + 1 : j], states[1])
            v[1:] -= self.rates * states[1:-1]
            if is_cut:
                states[-1] = self.propagate(states[-2], v[-1], r[j - 1], edges[-1:] - edges[-2])[0]
        return Ahead(self, k, edges, states, v, r[i:j])


@dataclass(frozen=True)
class Ahead:
    """Intervals from k on, the first from where the search is, the last up to a switching that is due: modal states at
    all edges; at the left edge of each interval their slopes v and the slopes r of their forcing."""

    window: Window
    k: int
    edges: Array
    states: Array
    v: Array
    r: Array

    def __len__(self) -> int:
        return len(self.v)

    def within(self, i: int, tau: Array) -> Array:
        """Modal states at some tau [s], which ascend, in interval i: (points, modes)."""
        return self.window.propagate(self.states[i], self.v[i], self.r[i], tau)

    def bends(self, i: int, tau: Array) -> Array:
        """Sizes of the second derivatives at tau in interval i, which are never larger from there on."""
        rates = self.window.rates
        return np.asarray(np.abs((self.r[i] - rates * self.v[i]) * np.exp(-rates * tau[:, None])))

    @property
    def first_bends(self) -> Array:
        """The same at the beginnings of all intervals."""
        return np.asarray(np.abs(self.r - self.window.rates * self.v))
