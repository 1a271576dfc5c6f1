"""What is looked at while a run answers: rows over the states of each regime, and over heat that is seen at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.solvers.linear import LinearProblem


@dataclass(frozen=True, eq=False)
class OutputMap:
    """over: by regime, rows over the states (count, n); direct: by regime, rows over the heat of all lumps (count, N),
    which massless junctions feel at once."""

    over: tuple[Array, ...]
    direct: tuple[Array, ...]
    sees_heat: bool

    @property
    def count(self) -> int:
        return len(self.over[0])

    def through(self, matrix: Array) -> OutputMap:
        """Combinations of what is seen: matrix (combinations, count)."""
        over, direct = (tuple(matrix @ rows for rows in own) for own in (self.over, self.direct))
        return OutputMap(over, direct, self.sees_heat)


def map_outputs(problem: LinearProblem, rows: Array | None = None) -> OutputMap:
    """Base readings and sensor states, or other rows over all lumps (·, N)."""
    massless = len(problem.plan.network.massless) > 0
    over, direct = [], []
    for regime in problem.regimes:
        seen = problem.readouts.rows if rows is None else rows
        over.append(problem.outputs(regime) if rows is None else rows @ regime.P)
        heat = seen @ regime.P_heat if massless else np.zeros((len(seen), len(regime.P)))
        direct.append(np.vstack([heat, np.zeros((len(over[-1]) - len(heat), len(regime.P)))]))
    return OutputMap(tuple(over), tuple(direct), massless and any(d.any() for d in direct))
