"""A few readings far from all others: a plug touched, a word of the bus lost. The rest is judged without them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from network.analysis.comparison.amounts import amount
from network.catalogue.declaration.declare import Array

if TYPE_CHECKING:
    from network.analysis.comparison.channel_residual import ChannelResidual

AMONG = 9
"""Readings that one is compared with: what lasts for half as many is no spike."""
FAR = 20.0
"""Robust standard deviations, of at least the declared noise, from which a reading lies apart."""
FEW = 0.03
"""Share of the readings: where more lie apart, they are no exception."""


@dataclass(frozen=True)
class Spikes:
    """count readings of a channel, up to `most` away from those around them (SI)."""

    name: str
    unit: str
    count: int
    most: float

    @property
    def sentence(self) -> str:
        size = amount(self.most, self.unit, 2)
        if self.count == 1:
            return f"{self.name}: 1 reading lies {size} apart from the rest, which is judged without it"
        return f"{self.name}: {self.count} readings lie up to {size} apart from the rest, which is judged without them"


def calm_spikes(channel: ChannelResidual) -> tuple[ChannelResidual, Spikes | None]:
    """A channel without its spikes, and what they were."""
    away = np.zeros(len(channel.t))
    away[channel.finite] = _away(channel.residual[channel.finite])
    far = _far(away[channel.finite], channel.sigma)
    if not 0 < far.sum() <= FEW * channel.n:
        return channel, None
    measured = channel.measured.copy()
    measured[np.flatnonzero(channel.finite)[far]] = np.nan
    most = float(np.abs(away).max())
    return replace(channel, measured=measured), Spikes(channel.name, channel.unit, int(far.sum()), most)


def _away(values: Array) -> Array:
    """How far each lies from the median of those around it."""
    if len(values) < AMONG:
        return np.zeros(len(values))
    padded = np.pad(values, AMONG // 2, mode="edge")
    return np.asarray(values - np.median(np.lib.stride_tricks.sliding_window_view(padded, AMONG), axis=1))


def _far(away: Array, sigma: float) -> NDArray[np.bool_]:
    spread = 1.4826 * float(np.median(np.abs(away))) if len(away) else 0.0
    return np.asarray(np.abs(away) > FAR * max(spread, sigma))
