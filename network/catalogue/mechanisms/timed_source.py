from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.base import Inputs, Source


class TimedSource(Source, kind="timed_source"):
    """Heat in pulses by the clock: q = P while (t − phase) mod period < duration, else 0. t is the time of the run.

    Hydraulic pumps, lubrication pulses, a heater on a timer. It neither knows the spindle nor any temperature, which
    tells it from a cooler with hysteresis; with `duration` near `period` it is a constant source.
    """

    power = param("W", -1e6, 1e6, "heat while on", typical=300)
    period = param("min", 0.01, 1e5, "time from one pulse to the next", typical=30)
    duration = param("min", 0, 1e5, "time it is on in each period", positive=True, typical=5)
    phase = param("min", -1e5, 1e5, "time of the run at which a pulse begins", default=0)
    strength = "power"
    shapes = ("period", "duration", "phase")
    sentence = "{into} receives {power} for {duration} in every {period}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        since = np.mod(np.real(u["time"] - self.phase), np.real(self.period))
        q: Array = self.power * (since < np.real(self.duration))
        return q

    def edges(self, duration: float) -> Array:
        period, on, phase = (np.ravel(v)[:, None] for v in (self.period, self.duration, self.phase))
        pulses = np.arange(np.ceil(np.max((duration + np.abs(phase)) / period)) + 1)
        starts = np.mod(phase, period) - period + pulses * period
        t = np.unique([starts, starts + on])
        return t[(t > 0) & (t < duration)]

    def faults(self) -> Iterator[Advice]:
        if self.duration > self.period:
            yield "duration", "is on for longer than its period", "give a duration below the period, or a heat_source"
