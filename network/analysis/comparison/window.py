"""The stretch of time in which a channel is furthest off."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array

if TYPE_CHECKING:
    from network.analysis.comparison.channel_residual import ChannelResidual

SMOOTHING = 60
"""A worst window is looked for in the residual smoothed over this part of the recording."""


def worst_window(channel: ChannelResidual) -> tuple[float, float, float]:
    """(from, to [s], mean residual in SI) of the stretch around the largest smoothed residual in which it keeps its
    sign and at least half of that size."""
    t, r = channel.t[channel.finite], channel.residual[channel.finite]
    smooth = _smooth(r, max(len(r) // SMOOTHING, 1) // 2)
    peak = int(np.argmax(np.abs(smooth)))
    outside = np.flatnonzero(smooth * np.sign(smooth[peak]) < abs(smooth[peak]) / 2)
    first = int(outside[outside < peak].max(initial=-1)) + 1
    last = int(outside[outside > peak].min(initial=len(r))) - 1
    return float(t[first]), float(t[last]), float(r[first : last + 1].mean())


def _smooth(values: Array, half: int) -> Array:
    """Means over `half` neighbours on either side, as many as there are."""
    total, k = np.concatenate([[0.0], np.cumsum(values)]), np.arange(len(values))
    first, last = np.maximum(k - half, 0), np.minimum(k + half + 1, len(values))
    return np.asarray((total[last] - total[first]) / (last - first))
