"""What is kept of a fit that is only compared with others: its numbers, not the runs and slopes behind them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.arrow_matrix import Folded
from network.analysis.calibration.problem import Problem
from network.catalogue.declaration.declare import Array


@dataclass(frozen=True, eq=False)
class Estimate:
    """theta, eta: the most probable; left: whitened residual there; cost: J; covariance: of (θ, η), linearised; folded:
    their precision with the runs' own nuisances folded in."""

    problem: Problem
    theta: Array
    eta: Array
    left: Array
    cost: float
    covariance: Array
    folded: Folded

    @property
    def free(self) -> int:
        return len(self.theta)

    @property
    def log_evidence(self) -> float:
        return log_evidence(self.problem, self.cost, self.folded)


def log_evidence(problem: Problem, cost: float, precision: Folded) -> float:
    """Log of the probability of the recordings, parameters integrated out (Laplace), but for a constant."""
    volume = precision.log_determinant + 2 * float(np.log(problem.prior[1]).sum())
    return -0.5 * (cost + problem.log_determinant + volume)
