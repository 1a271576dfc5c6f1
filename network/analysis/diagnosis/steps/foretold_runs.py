"""Runs told by numbers that others found, and known no better than these tell them.

With θ ~ N(θ̂, Λ⁻¹) by the others, S = (S_θ, S_η) the whitened slopes of the runs by numbers and by their own constants,
the log predictive density with numbers and constants integrated out, linearised, is but for a constant

    −½ (|r|² + strain of η + (θ − θ̂)ᵀ Λ (θ − θ̂) + ln |Λ + N| − ln |Λ|)

at the θ and η that make it largest, r what is left there, N the precision of θ by these runs with their constants
folded in. What two runs alone determine is told no surer than they do. Source: Gelman et al., Bayesian Data Analysis,
3rd ed., 7.1; unverified.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from network.analysis.calibration.linearised import Linearised
from network.catalogue.declaration.declare import Array


@dataclass(frozen=True, eq=False)
class ForetoldRuns:
    """seen: the runs about the numbers θ̂ of the others; known: Λ, in the noise of the readings."""

    seen: Linearised
    known: Array

    @cached_property
    def precision(self) -> Array:
        """Of numbers and constants together, told by the others and by the runs."""
        own = np.diag(self.seen.problem.prior[1][self.seen.free :] ** -2.0)
        return np.asarray(self.seen.slopes @ self.seen.slopes.T + block_diag(self.known, own))

    @cached_property
    def _step(self) -> Array:
        """Of numbers and constants to where the density is largest."""
        free = self.seen.free
        pull = np.concatenate([self.seen.slopes[:free] @ self.seen.left, np.zeros(len(self.seen.slopes) - free)])
        return np.asarray(np.linalg.solve(self.precision, pull))

    @cached_property
    def left(self) -> Array:
        """Whitened residual there."""
        return np.asarray(self.seen.left - self._step @ self.seen.slopes)

    @cached_property
    def density(self) -> float:
        """Log predictive density of the runs [nats], but for a constant."""
        free, (mean, spread) = self.seen.free, self.seen.problem.prior
        moved, eta = self._step[:free], self.seen.eta + self._step[free:]
        strained = float(np.sum(((eta - mean[free:]) / spread[free:]) ** 2)) - len(eta)  # beyond chance
        misfit = float(self.left @ self.left) + max(strained, 0.0) + float(moved @ self.known @ moved)
        return -(misfit + self._log_widened) / 2

    @property
    def _log_widened(self) -> float:
        """ln |Λ + N| − ln |Λ|."""
        free = self.seen.free
        told = self.seen.reduced[0] - np.diag(self.seen.problem.prior[1][:free] ** -2.0)
        widths = [float(np.linalg.slogdet(each)[1]) for each in (self.known + told, self.known)]
        return widths[0] - widths[1]
