"""Exact solution of an affine network by matrix exponentials: no modes, so equal cells in a stream do no harm.

One exponential for each regime and step length: exp of [[h A, I, 0, 0], [0, 0, I, 0], [0, 0, 0, I], [0, 0, 0, 0]] has
e^(hA), φ₁, φ₂ and φ₃ in its first row: they carry the state, a forcing that runs straight, and the integral of the
state (van Loan, IEEE Trans. Automatic Control 23 (1978) 395).
"""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.solvers.courses import KnownCourses
from network.engine.solvers.linear import LinearProblem, LinearSolution


class _Steps:
    """The step matrices of one regime by step length: E, h φ₁, h² φ₂, h³ φ₃."""

    def __init__(self, A: Array) -> None:
        self.A, self.known = A, dict[float, Array]()

    def __call__(self, h: float) -> Array:
        from scipy.linalg import expm  # slow to load

        key = float(f"{h:.12g}")
        if key not in self.known:
            n = len(self.A)
            big = np.zeros((4 * n, 4 * n))
            big[:n, :n] = self.A * key
            for block in range(3):
                big[block * n : (block + 1) * n, (block + 1) * n : (block + 2) * n] = np.eye(n)
            first_row = expm(big)[:n].reshape(n, 4, n).transpose(1, 0, 2)
            self.known[key] = first_row * (key ** np.arange(4))[:, None, None]
        return self.known[key]


def solve(problem: LinearProblem, each_interval: bool = False) -> LinearSolution:
    """The solution, stepping from instant to instant."""
    plan, x = problem.plan, problem.x0
    steps = [_Steps(regime.A) for regime in problem.regimes]
    outputs = [problem.outputs(regime) for regime in problem.regimes]
    y = np.empty((problem.readouts.width, len(plan.t)))
    integral = np.zeros((len(plan.steps) if each_interval else len(problem.regimes), problem.order))
    bounds = plan.bounds
    for k, h in enumerate(plan.steps):
        r, here = int(problem.regime_of[k]), slice(bounds[k], bounds[k + 1])
        p, slope = problem.f0[k], (problem.f1[k] - problem.f0[k]) / h
        samples = _samples(steps[r], x, p, slope, plan.t[here] - plan.edges[k])
        y[:, here] = outputs[r] @ samples.T
        _, one, two, three = steps[r](h)
        integral[k if each_interval else r] += one @ x + two @ p + three @ slope
        x = _advance(steps[r], x, p, slope, h)
    problem.add_direct(y)
    error = 1e-15 * float(np.abs(problem.x0).max(initial=1.0)) * np.sqrt(len(plan.t) + len(plan.steps))
    return LinearSolution(KnownCourses(y), x, integral, each_interval, float(error))


def _advance(steps: _Steps, x: Array, p: Array, slope: Array, h: float) -> Array:
    E, one, two, _ = steps(h)
    return np.asarray(E @ x + one @ p + two @ slope)


def _samples(steps: _Steps, x: Array, p: Array, slope: Array, tau: Array) -> Array:
    """States at the instants tau after the edge, each from the one before."""
    states, before = np.empty((len(tau), len(x))), 0.0
    for i, instant in enumerate(tau):
        if instant > before:
            x, p, before = _advance(steps, x, p, slope, instant - before), p + slope * (instant - before), instant
        states[i] = x
    return states
