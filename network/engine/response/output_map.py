"""What is looked at while a run answers: rows over the states of each regime, and over heat that is seen at once."""

from __future__ import annotations

from collections.abc import Sequence
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
        over, direct = (_combine(matrix, own) for own in (self.over, self.direct))
        return OutputMap(over, direct, self.sees_heat)


def _combine(matrix: Array, by_regime: Sequence[Array]) -> tuple[Array, ...]:
    """Combinations of rows; what several regimes share is worked out once."""
    made = {id(rows): matrix @ rows for rows in {id(rows): rows for rows in by_regime}.values()}
    return tuple(made[id(rows)] for rows in by_regime)


def map_outputs(problem: LinearProblem, rows: Array | None = None) -> OutputMap:
    """Base readings and sensor states, or other rows over all lumps (·, N); without massless junctions they are the
    same in all regimes."""
    massless = len(problem.plan.network.massless) > 0
    differ, over, direct = massless or problem.basis is not None, [], []
    for regime in problem.regimes if differ else problem.regimes[:1]:
        seen = problem.readouts.rows if rows is None else rows
        over.append(problem.outputs(regime) if rows is None else rows @ regime.P)
        heat = seen @ regime.P_heat if massless else np.zeros((len(seen), len(regime.P)))
        direct.append(np.vstack([heat, np.zeros((len(over[-1]) - len(heat), len(regime.P)))]))
    alike = 1 if differ else len(problem.regimes)
    return OutputMap(tuple(over) * alike, tuple(direct) * alike, massless and any(d.any() for d in direct))
