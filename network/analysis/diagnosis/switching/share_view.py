"""A share of the runs, from their beginning on, as a fit without the relay sees it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.calibration.projector import Projector
from network.analysis.diagnosis.screening.screen import whiten
from network.catalogue.declaration.declare import Array, Mask


@dataclass(frozen=True, eq=False)
class View:
    """A share of every run as a fit without the relay sees it: which rows, and what its parameters take up there."""

    about: Linearised
    share: float

    @cached_property
    def cells(self) -> Mask:
        return np.concatenate([d.ends_before(self.share) for d in self.about.problem.data])

    @cached_property
    def _seen(self) -> Mask:
        return whiten(self.about, self.cells.astype(float)) > 0

    @property
    def rows(self) -> int:
        """Residuals of the share."""
        return int(self._seen.sum())

    @cached_property
    def projector(self) -> Projector:
        slopes = self.about.slopes * self._seen
        return Projector(slopes, slopes @ slopes.T + np.diag(self.about.problem.prior[1] ** -2.0))

    @cached_property
    def off(self) -> Array:
        """Gradient of the parameters' priors."""
        mean, spread = self.about.problem.prior
        return np.asarray((mean - np.concatenate([self.about.theta, np.zeros(len(self.about.eta))])) / spread**2)

    @cached_property
    def hours(self) -> float:
        return sum(float(np.ptp(d.run.knots.samples)) for d in self.about.problem.data) * self.share / 3600

    def white(self, means: Array) -> Array:
        """Residuals of cells' means of all runs (…, cells), whitened, 0 behind the share."""
        measured = np.concatenate([d.means for d in self.about.problem.data])
        return whiten(self.about, np.where(self.cells, measured - means, 0.0))

    def take_up(self, residual: Array) -> tuple[Array, Array]:
        """What parameters take up of residuals (…, rows): their adjustment, and by how much the misfit falls."""
        return self.projector.adjust(residual, self.off)

    @cached_property
    def misfit(self) -> float:
        """What the fit leaves, its numbers adjusted linearly to the share."""
        residual = self.white(np.concatenate([p.cells for p in self.about.predictions]))
        return float(residual @ residual - self.take_up(residual)[1])
