"""A run as a fit sees it: states at both ends of every interval between knots, and how they answer to further heat.

Within an interval the heat runs straight, so the modes move in closed form (φ functions, as in solvers.modal) and the
answer to a small further heat is exact as well; what is approximate is the straightness, which the knots look after.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.channels import Readouts
from network.engine.response.modal_march import ModalEnds, follow, modes_by_regime
from network.engine.response.output_map import OutputMap, map_outputs
from network.engine.response.segments import Push, Segment, segments
from network.engine.solvers.linear import LinearProblem
from network.engine.solvers.modal import Modes

__all__ = ["LinearRun", "Push", "kick", "solve"]

AT_ONCE = 400_000
"""Numbers in the modal states of pushes that are answered together, so that they stay in the cache."""

SETTLE = ("P", "P_held", "P_heat")
"""What the temperatures of massless junctions follow, by regime."""


def kick(course: LinearRun, *kicks: tuple[int, Array]) -> Push:
    """Nothing but jumps of the states."""
    return Push(*course.no_heat, kicks)


@dataclass(frozen=True, eq=False)
class LinearRun:
    """A solved run, or several that follow each other. x0, x1: states at the beginnings and ends of the K intervals
    (K, n); restarts: the first interval of each of several runs, at which nothing is left of what was before."""

    problem: LinearProblem
    modes: tuple[Modes, ...]
    x0: Array
    x1: Array
    restarts: tuple[int, ...] = field(default=(), kw_only=True)

    @property
    def readouts(self) -> Readouts:
        return self.problem.readouts

    @cached_property
    def T(self) -> tuple[Array, Array]:
        """Temperatures of all lumps just after and just before the edges (K, N)."""
        network, forcing = self.problem.plan.network, self.problem.forcing
        T0, T1 = (np.empty((len(self.x0), network.size)) for _ in range(2))
        for T, x, held in zip((T0, T1), (self.x0, self.x1), forcing.held, strict=True):
            T[:, network.free], T[:, network.bound] = x[:, : len(network.free)], held
        at = network.massless
        for r, mine in self._by_regime() if len(at) else ():
            P, P_held, P_heat = (rows[at].T for rows in (getattr(self.problem.regimes[r], n) for n in SETTLE))
            k = np.arange(len(self.x0))[mine]
            for T, x, held, heat in zip((T0, T1), (self.x0, self.x1), forcing.held, forcing.heat, strict=True):
                T[k[:, None], at] = x[k] @ P + held[k] @ P_held + heat[k] @ P_heat
        return T0, T1

    @cached_property
    def T_ends(self) -> Array:
        """Temperatures of all lumps just after, then just before the edges (2 K, N)."""
        return np.concatenate(self.T)

    @cached_property
    def inputs(self) -> dict[str, Array]:
        """Inputs just after, then just before the edges: (2 K, 1)."""
        begin, end = self.problem.plan.just_inside
        return {name: np.concatenate([begin[name], end[name]]) for name in begin}

    @cached_property
    def no_heat(self) -> tuple[Indices, Array, Array]:
        """Into no lump."""
        none = np.empty((len(self.problem.plan.steps), 0))
        return np.empty(0, int), none, none

    @cached_property
    def derived(self) -> dict[tuple[object, ...], Array]:
        """What is found along this run: derivatives of heats by group, number and members, and temperatures and inputs
        within its intervals."""
        return {}

    @cached_property
    def rates(self) -> tuple[Array, Array]:
        """dx/dt just after and just before the edges (K, n)."""
        dx0, dx1 = self.problem.f0.copy(), self.problem.f1.copy()
        for r, mine in self._by_regime():
            A = self.problem.regimes[r].A
            dx0[mine] += self.x0[mine] @ A.T
            dx1[mine] += self.x1[mine] @ A.T
        return dx0, dx1

    def _by_regime(self) -> Iterator[tuple[int, Indices | slice]]:
        if len(self.problem.regimes) == 1:
            yield 0, slice(None)
            return
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
    def stretches(self) -> tuple[Segment, ...]:
        """As the run itself goes."""
        return tuple(segments(self.problem, self.modes))

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """As it answers: nothing is carried beyond the ends of runs."""
        ends = {*(k - 1 for k in self.restarts), len(self.x0) - 1} if self.restarts else set[int]()
        return tuple(s.forget(k for k in ends if s.first <= k < s.last) for s in self.stretches)

    @cached_property
    def modal_ends(self) -> tuple[ModalEnds, ...]:
        """Its own modes in every stretch."""
        of = self.x0, self.x1, self.problem.f0, self.problem.f1
        return tuple(ModalEnds(*(v[s.first : s.last] @ s.modes.W.T for v in of)) for s in self.stretches)

    @cached_property
    def output_map(self) -> OutputMap:
        """The base readings."""
        return map_outputs(self.problem)

    # -- answers ------------------------------------------------------------------------------------------------------
    def complete_pushes(self, pushes: Sequence[Push], by_guard: Array | None = None) -> Sequence[Push]:
        """Pushes with all that they bring about by the way (moved switchings, heat of bent laws)."""
        return pushes

    def straighten(self, pushes: Sequence[Push]) -> Sequence[Push]:
        """The same without what bent laws add."""
        return self.complete_pushes(pushes)

    def divide_pushes(
        self, pushes: Sequence[Push], by_guard: Array | None = None
    ) -> tuple[Sequence[Push], Sequence[Push] | None]:  # fmt: skip
        """The same apart: as its straight laws answer them, and heat that bent laws add; None where none is bent."""
        return self.complete_pushes(pushes, by_guard), None

    def answers(self, pushes: Sequence[Push]) -> Array:
        """Changes of rows and sensor states for each push: (pushes, width, 2 K)."""
        return self.ends(self.complete_pushes(pushes), self.output_map)

    def ends(self, pushes: Sequence[Push], output_map: OutputMap) -> Array:
        """Changes of the outputs just after, then just before the edges, for resolved pushes: (pushes, ·, 2 K)."""
        answer = np.empty((len(pushes), output_map.count, 2 * len(self.x0)))
        for some in self.portions(len(pushes)):
            self._ends(pushes[some], output_map, answer[some])
        return answer

    def portions(self, count: int, at_once: int = AT_ONCE) -> Iterator[slice]:
        """Pushes, as many at a time as are worth answering together."""
        each = max(1, at_once // (len(self.x0) * self.problem.order + 1))
        return (slice(first, min(first + each, count)) for first in range(0, count, each))

    def _ends(self, pushes: Sequence[Push], output_map: OutputMap, answer: Array) -> None:
        K, x = len(self.x0), np.zeros((len(pushes), self.problem.order))
        for s in self.segments:
            m, stop, end = s.march_pushes(pushes, x @ s.modes.W.T)
            over = output_map.over[s.index] @ s.modes.V
            for side, values in ((0, m), (K, stop)):
                seen = np.matmul(over, values.transpose(1, 2, 0))
                answer[:, :, side + s.first : side + s.last] = np.real(seen)
                if output_map.sees_heat:
                    self._see_at_once(s, pushes, output_map, answer, side)
            x = np.real(end @ s.modes.V.T)

    @staticmethod
    def _see_at_once(s: Segment, pushes: Sequence[Push], output_map: OutputMap, answer: Array, side: int) -> None:
        """Massless junctions warm at once with the heat that they get."""
        for i, push in enumerate(pushes):
            q = (push.q1 if side else push.q0)[s.first : s.last]
            answer[i, :, side + s.first : side + s.last] += (q @ push.into(output_map.direct[s.index])).T


def solve(
    problem: LinearProblem, known: dict[bytes, Modes] | None = None, like: LinearRun | None = None,
    starts: Mapping[int, Array] | None = None,
) -> LinearRun:  # fmt: skip
    """The course of a reduced problem; `known`: modes found before, by the matrix of their regime; like: a course of
    the same regimes at the same intervals; starts: of several runs that follow each other, the states at the first
    interval of each."""
    modes, (K, n) = like.modes if like else modes_by_regime(problem, {} if known is None else known), problem.f0.shape
    course = LinearRun(problem, modes, np.empty((K, n)), np.empty((K, n)), restarts=tuple(starts or ()))
    if like is not None:
        course.__dict__.update(stretches=like.stretches, segments=like.segments)
    course.x0[:], course.x1[:], ends = follow(problem, course.stretches, starts or {0: problem.x0})
    if starts:
        course.__dict__["modal_ends"] = ends
    return course
