"""One channel of a recording less what was simulated, in units of its noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.printing import Brief
from network.platform.quantities.units import difference, unit


@dataclass(frozen=True, eq=False, repr=False)
class ChannelResidual(Brief):
    """One channel of one recording. t [s]; measured, simulated in SI; sigma: declared 1σ of a sample; unit: shown;
    spread: how often that noise each sample has, where some were set right; once without."""

    name: str
    unit: str
    t: Array
    measured: Array
    simulated: Array
    sigma: float
    spread: Array | None = None

    @property
    def residual(self) -> Array:
        """Measured less simulated, SI, NaN in gaps."""
        return np.asarray(self.measured - self.simulated)

    @property
    def in_noise(self) -> Array:
        """Residual in units of noise."""
        left = self.residual / self.sigma
        return np.asarray(left if self.spread is None else left / self.spread)

    @property
    def finite(self) -> Array:
        return np.isfinite(self.measured)

    @property
    def n(self) -> int:
        return int(self.finite.sum())

    @property
    def rmse_in_noise(self) -> float:
        return rms(self.in_noise)

    def summary(self) -> dict[str, Any]:
        """The channel's part of `compare --json`: rmse and max in its unit."""
        shown = self.residual / difference(unit(self.unit)).scale
        largest = float(np.nanmax(np.abs(shown))) if self.n else None
        return {
            "rmse": rms(shown) if self.n else None, "unit": "K" if unit(self.unit).is_temperature else self.unit,
            "rmse_in_noise": self.rmse_in_noise if self.n else None, "max": largest, "n": self.n,
        }  # fmt: skip


def pool_residuals(channels: Iterable[ChannelResidual]) -> float:
    """√mean of all finite residuals in units of noise."""
    return rms(np.concatenate([channel.in_noise for channel in channels]))


def rms(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if len(finite) else float("nan")
