"""A run marched through in its modes: from edge to edge in closed form, for one forcing or for several in turn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.solvers.linear import LinearProblem, LinearSolution
from network.engine.solvers.modal import WORST_CONDITION, Modes, modes_of, phi, scan
from network.engine.solvers.modal_courses import ModalCourses, ModalStates

SAME_LENGTH = 12
"""Decimals of a second to which steps of one length are worked out once: finer than instants of a day are known."""


@dataclass(frozen=True)
class _Stretch:
    """Intervals in one regime, first to last (excluded), and over each of them h φ₁, h² φ₂ and h³ φ₃."""

    first: int
    last: int
    regime: int
    a: Array
    b: Array
    c: Array


@dataclass(frozen=True)
class Propagators:
    """What carries the modes of a problem over its intervals, whatever drives them."""

    modes: tuple[Modes, ...]
    stretches: tuple[_Stretch, ...]

    @property
    def condition(self) -> float:
        return max(modes.condition for modes in self.modes)


def propagators(problem: LinearProblem) -> Propagators | None:
    """None where the modes are too badly conditioned (equal cells in a stream, for instance)."""
    modes = tuple(modes_of(regime, problem.scale) for regime in problem.regimes)
    if max(m.condition for m in modes) > WORST_CONDITION:
        return None
    return Propagators(modes, tuple(_stretches(problem, modes)))


def _stretches(problem: LinearProblem, modes: Sequence[Modes]) -> Iterator[_Stretch]:
    regime_of = problem.regime_of
    cuts = (np.flatnonzero(np.diff(regime_of)) + 1).tolist()
    for first, last in zip([0, *cuts], [*cuts, len(regime_of)], strict=True):
        regime, steps = int(regime_of[first]), problem.plan.steps[first:last]
        lengths, at = np.unique(np.round(steps, SAME_LENGTH), return_inverse=True)
        few = len(lengths) < len(steps) / 2
        h = (lengths if few else steps)[:, None]
        one, two, three = phi(-modes[regime].rates * h)
        factors = (h * one, h**2 * two, h**3 * three)
        yield _Stretch(first, last, regime, *(f[at] if few else f for f in factors))


def solve(problem: LinearProblem, each_interval: bool = False, by: Propagators | None = None) -> LinearSolution | None:
    """The solution; `by`: the propagators where these are known. None where the modes are too badly conditioned."""
    by = by or propagators(problem)
    if by is None:
        return None
    march = _March(problem, by, each_interval)
    x_end = march.run()
    steps = len(problem.plan.steps)
    size = float(np.abs(problem.x0).max(initial=1.0))
    error = 4 * np.finfo(float).eps * by.condition * size * np.sqrt(steps)
    courses = ModalCourses(problem, by.modes, march.states)
    return LinearSolution(courses, x_end, march.x_integral, each_interval, float(error))


class _March:
    """Modal states at the left edge of every interval, and the integrals of the states."""

    def __init__(self, problem: LinearProblem, by: Propagators, each_interval: bool) -> None:
        self.problem, self.by, self.each_interval = problem, by, each_interval
        steps = len(problem.plan.steps)
        kind = float if all(m.is_real for m in by.modes) else complex
        self.states = ModalStates(*(np.empty((steps, problem.order), kind) for _ in range(5)))
        self.x_integral = np.zeros((steps if each_interval else len(problem.regimes), problem.order))

    def run(self) -> Array:
        """The states x at the end."""
        x, plan, s = self.problem.x0, self.problem.plan, self.states
        for stretch in self.by.stretches:
            here, modes = slice(stretch.first, stretch.last), self.by.modes[stretch.regime]
            s.a[here], s.b[here] = stretch.a, stretch.b
            s.p[here] = self.problem.f0[here] @ modes.W.T
            s.r[here] = (self.problem.f1[here] - self.problem.f0[here]) @ modes.W.T / plan.steps[here, None]
            push = stretch.a * s.p[here] + stretch.b * s.r[here]
            s.m[here], end = scan(1 - modes.rates * stretch.a, push, modes.W @ x)
            self._integrate(stretch, stretch.a * s.m[here] + stretch.b * s.p[here] + stretch.c * s.r[here])
            x = np.real(modes.V @ end)
        return x

    def _integrate(self, stretch: _Stretch, integral: Array) -> None:
        V = self.by.modes[stretch.regime].V
        if self.each_interval:
            self.x_integral[stretch.first : stretch.last] = np.real(integral @ V.T)
        else:
            self.x_integral[stretch.regime] += np.real(V @ integral.sum(axis=0))
