"""A run as a fit sees it: states at both ends of every interval between knots, and how they answer to further heat.

Within an interval the heat runs straight, so the modes move in closed form (φ functions, as in solvers.modal) and the
answer to a small further heat is exact as well; what is approximate is the straightness, which the knots look after.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.calibration.recursion import recur
from network.channels import Readouts
from network.declare import Array, Indices
from network.solvers.linear import LinearProblem, Regime
from network.solvers.modal import Modes, modes_of, phi


@dataclass(frozen=True)
class Push:
    """A small further heat: q0, q1 [W] into some lumps, just after and before the edges of every interval (K, lumps);
    kicks: (interval, jump of the states at its beginning)."""

    lumps: Indices
    q0: Array
    q1: Array
    kicks: tuple[tuple[int, Array], ...] = ()


def kick(course: Course, *kicks: tuple[int, Array]) -> Push:
    """Nothing but jumps of the states."""
    empty = np.empty((len(course.problem.plan.steps), 0))
    return Push(np.empty(0, int), empty, empty, kicks)


@dataclass(frozen=True, eq=False)
class Course:
    """A solved run. x0, x1: states at the beginnings and ends of the K intervals (K, n)."""

    problem: LinearProblem
    modes: tuple[Modes, ...]
    x0: Array
    x1: Array

    @property
    def readouts(self) -> Readouts:
        return self.problem.readouts

    @cached_property
    def T(self) -> tuple[Array, Array]:
        """Temperatures of all lumps just after and just before the edges (K, N)."""
        T0, T1 = (np.empty((len(self.x0), self.problem.plan.network.size)) for _ in range(2))
        forcing = self.problem.forcing
        for r, mine in self._by_regime():
            regime = self.problem.regimes[r]
            for T, x, held, heat in zip((T0, T1), (self.x0, self.x1), forcing.held, forcing.heat, strict=True):
                T[mine] = x[mine] @ regime.P.T + held[mine] @ regime.P_held.T
                if len(self.problem.plan.network.massless):
                    T[mine] += heat[mine] @ regime.P_heat.T
        return T0, T1

    @cached_property
    def rates(self) -> tuple[Array, Array]:
        """dx/dt just after and just before the edges (K, n)."""
        dx0, dx1 = self.problem.f0.copy(), self.problem.f1.copy()
        for r, mine in self._by_regime():
            A = self.problem.regimes[r].A
            dx0[mine] += self.x0[mine] @ A.T
            dx1[mine] += self.x1[mine] @ A.T
        return dx0, dx1

    def _by_regime(self) -> Iterator[tuple[int, Indices]]:
        for r in range(len(self.problem.regimes)):
            yield r, np.flatnonzero(self.problem.regime_of == r)

    @cached_property
    def readings(self) -> Array:
        """Rows and sensor states just after, then just before the edges: (width, 2 K)."""
        rows = self.readouts.rows
        ends = [np.vstack([rows @ T.T, x[:, x.shape[1] - self.readouts.states :].T])
                for T, x in zip(self.T, (self.x0, self.x1), strict=True)]  # fmt: skip
        return np.hstack(ends)

    @cached_property
    def _stretches(self) -> tuple[_Stretch, ...]:
        return tuple(_stretches(self.problem, self.modes))

    def answers(self, pushes: Sequence[Push]) -> Array:
        """Changes of rows and sensor states for each push: (pushes, width, 2 K)."""
        K, width = len(self.problem.plan.steps), self.readouts.width
        answer = np.empty((len(pushes), width, 2 * K))
        each = max(1, 40_000 // (K * self.problem.order + 1) + 1)
        for first in range(0, len(pushes), each):
            some = pushes[first : first + each]
            self._answer(some, answer[first : first + each])
        return answer

    def _answer(self, pushes: Sequence[Push], answer: Array) -> None:
        K = len(self.problem.plan.steps)
        x = np.zeros((len(pushes), self.problem.order))
        for s in self._stretches:
            m, end = s.moved(pushes, x)
            m1 = np.concatenate([m[1:], end[None]])
            for side, values in ((0, m), (K, m1)):
                read = np.real(values @ s.outputs.T)  # (k, pushes, width)
                answer[:, :, side + s.first : side + s.last] = read.transpose(1, 2, 0)
            self._see_at_once(s, pushes, answer)
            x = np.real(end @ s.modes.V.T)

    def _see_at_once(self, s: _Stretch, pushes: Sequence[Push], answer: Array) -> None:
        """Massless junctions warm at once with the heat that they get."""
        if not len(self.problem.plan.network.massless):
            return
        K, rows, here = len(self.problem.plan.steps), self.readouts.rows @ s.regime.P_heat, slice(s.first, s.last)
        for i, push in enumerate(pushes):
            for side, q in ((0, push.q0), (K, push.q1)):
                answer[i, : len(rows), side + s.first : side + s.last] += rows[:, push.lumps] @ q[here].T

    def states_after(self, pushes: Sequence[Push]) -> tuple[Array, Array]:
        """Changes of the states at beginnings and ends of the intervals: (pushes, K, n) each."""
        K, n = len(self.problem.plan.steps), self.problem.order
        begin, stop = np.empty((len(pushes), K, n)), np.empty((len(pushes), K, n))
        x = np.zeros((len(pushes), n))
        for s in self._stretches:
            m, end = s.moved(pushes, x)
            begin[:, s.first : s.last] = np.real(m @ s.modes.V.T).transpose(1, 0, 2)
            x = np.real(end @ s.modes.V.T)
            stop[:, s.first : s.last - 1], stop[:, s.last - 1] = begin[:, s.first + 1 : s.last], x
        return begin, stop


@dataclass(frozen=True)
class _Stretch:
    """Intervals first to last (excluded) in one regime: decay over each, and what heat at its two ends adds."""

    first: int
    last: int
    modes: Modes
    regime: Regime
    gain: Array
    c0: Array
    c1: Array
    outputs: Array

    def moved(self, pushes: Sequence[Push], x: Array) -> tuple[Array, Array]:
        """Modal states before each interval (k, pushes, n) and after the last, from states x (pushes, n)."""
        here, W = slice(self.first, self.last), self.modes.W
        start = x @ W.T
        push_on = np.empty((self.last - self.first, len(pushes), len(W)), start.dtype)
        for i, push in enumerate(pushes):
            by_heat = (W @ self.regime.F_heat[:, push.lumps]).T
            push_on[:, i] = self.c0 * (push.q0[here] @ by_heat) + self.c1 * (push.q1[here] @ by_heat)
            for k, jump in push.kicks:
                if k == self.first:
                    start[i] += W @ jump
                elif self.first < k < self.last:
                    push_on[k - 1 - self.first, i] += W @ jump
        return recur(self.gain, push_on, start)


def _stretches(problem: LinearProblem, modes: Sequence[Modes]) -> Iterator[_Stretch]:
    cuts = np.flatnonzero(np.diff(problem.regime_of)) + 1
    for first, last in zip([0, *cuts.tolist()], [*cuts.tolist(), len(problem.regime_of)], strict=True):
        r = int(problem.regime_of[first])
        h = problem.plan.steps[first:last, None]
        z = -modes[r].rates * h
        one, two, _ = phi(z)
        outputs = problem.outputs(problem.regimes[r]) @ modes[r].V
        gain, c1 = np.exp(z), h * two
        yield _Stretch(first, last, modes[r], problem.regimes[r], gain, h * one - c1, c1, outputs)


def solve(problem: LinearProblem) -> Course:
    """The course of a reduced problem."""
    modes = tuple(modes_of(regime, problem.scale) for regime in problem.regimes)
    K, n = problem.f0.shape
    x0, x1, x = np.empty((K, n)), np.empty((K, n)), problem.x0
    for s in _stretches(problem, modes):
        here = slice(s.first, s.last)
        push = s.c0 * (problem.f0[here] @ s.modes.W.T) + s.c1 * (problem.f1[here] @ s.modes.W.T)
        m, end = recur(s.gain, push[:, None], (s.modes.W @ x)[None])
        x0[here] = np.real(m[:, 0] @ s.modes.V.T)
        x = np.real(s.modes.V @ end[0])
        x1[s.first : s.last - 1], x1[s.last - 1] = x0[s.first + 1 : s.last], x
    return Course(problem, modes, x0, x1)
