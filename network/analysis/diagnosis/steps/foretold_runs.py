"""Runs told by numbers that others found, and known no better than these tell them.

With θ ~ N(θ̂, Σ) by the others, S = (S_θ, S_η) the whitened slopes of the runs by numbers and by their own constants,
and r what is left at θ̂ with η at its most probable,

    ln p(r | others) = −½ (|r|² + strain − bᵀ (I + Σ N)⁻¹ Σ b + ln |I + Σ N|),   b = S_θ r,

N the precision of θ by these runs with their constants folded in: the predictive density with the numbers integrated
out, linearised. A fit that two runs alone determine is worth more on the third than its numbers as they stand: what
they are uncertain by is no misfit. Source: Gelman et al., Bayesian Data Analysis, 3rd ed., 7.1; unverified.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.misfit import strain_of
from network.catalogue.declaration.declare import Array


@dataclass(frozen=True, eq=False)
class ForetoldRuns:
    """seen: the runs about the numbers θ̂ of the others; spread: Σ, None where these stand as they are."""

    seen: Linearised
    spread: Array | None = None

    @cached_property
    def precision(self) -> Array:
        """Of the constants, and of the numbers where they may move."""
        slopes, first = self.seen.slopes[self._moved :], self.seen.free - self._moved
        own = np.diag(self.seen.problem.prior[1][self.seen.free :] ** -2.0)
        known = np.zeros((0, 0)) if self.spread is None else np.linalg.inv(self.spread)
        assert len(known) == first
        return np.asarray(slopes @ slopes.T + block_diag(known, own))

    @property
    def slopes(self) -> Array:
        """By all of these."""
        return self.seen.slopes[self._moved :]

    @property
    def _moved(self) -> int:
        """The first that may move."""
        return self.seen.free if self.spread is None else 0

    @cached_property
    def _pull(self) -> Array:
        """What draws them away from θ̂."""
        pull = np.zeros(len(self.slopes))
        if self.spread is not None:
            pull[: self.seen.free] = self.seen.slopes[: self.seen.free] @ self.seen.left
        return pull

    @cached_property
    def left(self) -> Array:
        """Whitened residual at the most probable of all that may move."""
        return np.asarray(self.seen.left - np.linalg.solve(self.precision, self._pull) @ self.slopes)

    @cached_property
    def misfit(self) -> float:
        """Σ of squares, and what constants are strained by, less what the numbers are uncertain by."""
        whole = float(self.seen.left @ self.seen.left) + strain_of(self.seen)
        return max(whole - float(self._pull @ np.linalg.solve(self.precision, self._pull)), 0.0)

    @cached_property
    def log_spread(self) -> float:
        """ln |I + Σ N|: by how much what is told of the runs is wider for the numbers' sake [2 nats]."""
        if self.spread is None:
            return 0.0
        free, spread = self.seen.free, self.seen.problem.prior[1]
        N = self.seen.reduced[0] - np.diag(spread[:free] ** -2.0)
        return float(np.linalg.slogdet(np.eye(free) + self.spread @ N)[1])
