"""Surroundings that differ from what is recorded or stated of them."""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array, Declared
from network.catalogue.declaration.fields import param

LINES = 48
"""Straight lines that draw one period: the corners lie on the cosine, between them it is off by 0.2 % of the swing."""


class Drift(Declared):
    """T = T_given + offset + rate · t + swing cos(2π (t − peak)/period): t is the time of the run, T_given what is
    recorded or stated.

    The room a machine feels is not the one a thermometer on the wall reads: it warms over a shift, breathes with the
    day, and lies above it under the roof. The cosine is drawn by straight lines, 48 a period, alike for every solver.
    """

    rate = param("K/h", -50, 50, "how fast it warms beside what is given", default=0, typical=0.3)
    offset = param("K", -50, 50, "how far it lies above what is given", default=0, typical=1)
    swing = param("K", 0, 50, "half of what it goes up and down by", default=0, typical=1)
    period = param("h", 0.1, 1e4, "from one peak to the next", default=24)
    peak = param("h", -1e4, 1e4, "time of the run at which it is warmest", default=0)

    def at(self, t: Array) -> Array:
        """K beside what is given, at times of the run [s]."""
        corners = LINES * (t - self.peak) / self.period
        k = np.floor(np.real(corners))
        first, last = (np.cos(2 * np.pi * corner / LINES) for corner in (k, k + 1))
        wave = first + (corners - k) * (last - first)
        return np.asarray(self.offset + self.rate * t + self.swing * wave)

    def edges(self, duration: float) -> Array:
        """Corners of the cosine in 0 < t < duration."""
        if self.swing == 0:
            return np.empty(0)
        step = float(self.period) / LINES
        k = np.arange(np.ceil(-float(self.peak) / step), np.floor((duration - float(self.peak)) / step) + 1)
        t = np.asarray(float(self.peak) + k * step)
        return t[(t > 0) & (t < duration)]
