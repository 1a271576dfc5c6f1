"""Linear networks: each cause alone, in the modes of the run. The answers add up to the run but for rounding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.solvers import expm
from network.engine.solvers.forcing import Forcing
from network.engine.solvers.linear import LinearProblem, force_states
from network.engine.solvers.modal_run import Propagators, propagators, solve
from network.engine.superposition.causes import Cause


def answer_exactly(problem: LinearProblem, causes: Sequence[Cause], base: float) -> Array:
    """Rises over `base` [°C] that each cause brings to the readouts: (causes, rows, instants)."""
    by = propagators(problem) if problem.plan.method != "expm" else None
    return np.stack([_answer(problem, by, cause, base) for cause in causes])


def _answer(problem: LinearProblem, by: Propagators | None, cause: Cause, base: float) -> Array:
    forcing = _forcing_of(problem, cause, base)
    f0, f1 = force_states(problem.regimes, problem.regime_of, forcing, problem.readouts)
    alone = replace(problem, forcing=forcing, f0=f0, f1=f1, x0=np.zeros(problem.order))
    if cause.is_start:
        alone = replace(alone, x0=alone.begin(problem.plan.T0 - base))
    solution = solve(alone, by=by) if by is not None else expm.solve(alone)
    assert solution is not None
    return solution.courses.all()


def _forcing_of(problem: LinearProblem, cause: Cause, base: float) -> Forcing:
    network, given = problem.plan.network, problem.forcing
    held: list[Array] = [np.zeros_like(values) for values in given.held]
    if cause.held is not None:
        for side in (0, 1):
            held[side][:, cause.held] = given.held[side][:, cause.held] - base
    if cause.source is None:
        nothing = np.zeros((len(held[0]), 1))
        return Forcing((held[0], held[1]), None, ((nothing, nothing),), (np.zeros((network.size, 1)),))
    group, column = cause.source
    first, last = (series[:, column, None] for series in given.sources[group])
    return Forcing((held[0], held[1]), None, ((first, last),), (given.into[group][:, column, None],))
