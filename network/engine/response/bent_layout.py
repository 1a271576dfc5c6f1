"""Windows of a bent course laid out as a linear problem, and where the runs in it begin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.channels import Readouts
from network.engine.solvers.elimination import Regime
from network.engine.solvers.forcing import Forcing
from network.engine.solvers.linear import LinearProblem, begin_runs
from network.engine.solvers.plan import Plan


@dataclass(frozen=True)
class Begun:
    """The runs of a course: their own plans, and their intervals in it."""

    plans: tuple[Plan, ...]
    runs: tuple[slice, ...]

    def starts(self, problem: LinearProblem) -> dict[int, Array] | None:
        """States at the beginnings of several runs, by interval."""
        return begin_runs(problem, self.plans, self.runs) if len(self.runs) > 1 else None

    @property
    def temperatures(self) -> Array:
        """Those of the beginnings at both ends of all intervals (2 K, N)."""
        one = [np.tile(p.T0, (run.stop - run.start, 1)) for p, run in zip(self.plans, self.runs, strict=True)]
        return np.concatenate([*one, *one])


def lay_out(
    plan: Plan, readouts: Readouts, regimes: Sequence[Regime], of: Indices, held: tuple[Array, Array], heat: Array
) -> LinearProblem:  # fmt: skip
    """Windows with a heat into all lumps (2 K, N) beside their matrices. held: given temperatures at both ends."""
    network, K = plan.network, len(plan.steps)
    n = len(network.free) + readouts.states
    alike = not len(network.massless) and not network.melting
    driven = regimes[0].drive(heat) if alike else np.empty((2 * K, n))
    for w, regime in enumerate(regimes):
        mine = np.flatnonzero(of == w)
        for given, at in ((held[0], mine), (held[1], mine + K)):
            driven[at] = given[mine] @ regime.F_held.T + (driven[at] if alike else regime.drive(heat[at]))
            driven[at, len(network.free) :] += readouts.state_constant
    f0, f1 = driven[:K], driven[K:]
    forcing = Forcing(held, (heat[:K], heat[K:]), ())
    scale = np.concatenate([np.sqrt(network.capacity[network.free]), np.ones(readouts.states)])
    problem = LinearProblem(plan, readouts, tuple(regimes), of, forcing, f0, f1, np.zeros(len(scale)), scale)
    return replace(problem, x0=problem.begin(plan.T0))
