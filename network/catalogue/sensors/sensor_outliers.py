from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, whole
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.sensors.base import SensorEffect

INSTANT = 1e-3
"""s: times that differ by less are the same reading."""
MIX = (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)
"""Of the generator SplitMix64 (Steele, Lea & Flood, OOPSLA 2014), which makes neighbouring whole numbers unlike."""


class SensorOutliers(SensorEffect, kind="sensor_outliers"):
    """Single readings that are far off: reading = truth + size at one in so many instants, else the truth.

    Sparks in the cable, a bit that flips, a display that is written down wrongly. Which readings are hit follows from
    their time and `seed` alone (their millisecond, mixed, below `share`), so that a run can be repeated; it is made to
    see what outliers do, no law. Readings far from their neighbours are set aside before anything is judged, so a
    diagnosis does not look for this one. Source: the contaminated normal distribution (Huber, Robust Statistics, ch. 1;
    unverified).
    """

    quantities = ("temperature",)
    size = param("K", -1000, 1000, "what a hit reading reads too much", typical=5)
    share = param("1", 0, 1, "of the readings that are hit", default=0.01, typical=0.01)
    seed = whole("another one hits other readings", 0, 1_000_000, default=0)
    strength = "size"
    is_steady = False
    searched = False
    shapes = ("share",)
    sentence = "{channel} reads {size} too much in {share} of its readings"

    def is_hit(self, t: Array) -> Array:
        """Which instants are hit."""
        first, second, third = (np.uint64(number) for number in MIX)
        with np.errstate(over="ignore"):
            x = np.round(np.real(t) / INSTANT).astype(np.int64).astype(np.uint64) + np.uint64(self.seed + 1) * first
            x = (x ^ (x >> np.uint64(30))) * second
            x = (x ^ (x >> np.uint64(27))) * third
        return np.asarray((x >> np.uint64(11)) / 2.0**53 < np.real(self.share))

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        return np.asarray(truth + self.size * self.is_hit(u["time"]))

    def truth(self, reading: Array, u: Inputs) -> Array:
        return np.asarray(reading - self.size * self.is_hit(u["time"]))
