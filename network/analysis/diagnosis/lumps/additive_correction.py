"""What a machine that stands in for another one is told to lack."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.analysis.calibration.measured_means import Measured
from network.catalogue.declaration.declare import Array


@dataclass(frozen=True, eq=False)
class AdditiveCorrection:
    """A difference of a run's channels over time, as means about instants t [s]: (channels, instants)."""

    t: Array
    values: Array

    @classmethod
    def of(cls, data: Measured, cells: Array) -> AdditiveCorrection:
        """From the cells of a layout of the run (channels · cells)."""
        return cls(data.centres, cells.reshape(len(data.run.channels), -1))

    def at(self, data: Measured) -> Array:
        """The same about the cells of a layout of the run (channels · cells)."""
        return np.concatenate([np.interp(data.centres, self.t, row) for row in self.values])
