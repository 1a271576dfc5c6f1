from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import instant, param
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.units import show


class TimedSource(Source, kind="timed_source"):
    """Heat by the clock: q = P while (t − phase) mod period < duration, or while begins ≤ t < ends, else 0.

    t is the time of the run. Hydraulic pumps, lubrication pulses, a heater on a timer; a single window is a door that
    stood open, or a hand lamp. It neither knows the spindle nor any temperature, which tells it from a cooler with
    hysteresis; with `duration` near `period` it is a constant source. Proposed with a period: where a window lies has
    no slope that a fit could follow.
    """

    power = param("W", -1e6, 1e6, "heat while on", typical=300)
    period = instant(0.01, 1e5, "time from one pulse to the next", default=None, typical=30)
    duration = instant(0, 1e5, "time it is on in each period", positive=True, default=None, typical=5)
    phase = instant(-1e5, 1e5, "time of the run at which a pulse begins", default=0, typical=60)
    begins = instant(-1e5, 1e5, "time of the run at which a single window begins", default=None, typical=30)
    ends = instant(-1e5, 1e5, "time of the run at which it ends", default=None, typical=60)
    one_of = (("period", "duration"), ("begins", "ends"))
    strength = "power"
    shapes = ("period", "duration", "phase")
    sentence = "{into} receives {power} {when}"

    @property
    def is_single(self) -> bool:
        """Whether it is on once, in a window."""
        return self.begins is not None

    @property
    def when(self) -> str:
        """When it is on, in words."""
        if self.is_single:
            return f"from {show(float(self.begins), 'min')} to {show(float(self.ends), 'min')} of the run"
        first = round(float(np.mod(self.phase, self.period)))
        since = f", beginning at {show(float(first), 'min')}" if 0 < first < round(float(self.period)) else ""
        return f"for {show(float(self.duration), 'min')} in every {show(float(self.period), 'min')}{since}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        t = np.real(u["time"])
        if self.is_single:
            is_on = (t >= np.real(self.begins)) & (t < np.real(self.ends))
        else:
            is_on = np.mod(np.real(t - self.phase), np.real(self.period)) < np.real(self.duration)
        q: Array = self.power * is_on
        return q

    def edges(self, duration: float) -> Array:
        if self.is_single:
            t = np.unique([np.ravel(self.begins), np.ravel(self.ends)])
            return t[(t > 0) & (t < duration)]
        period, on, phase = (np.ravel(v)[:, None] for v in (self.period, self.duration, self.phase))
        pulses = np.arange(np.ceil(np.max((duration + np.abs(phase)) / period)) + 1)
        starts = np.mod(phase, period) - period + pulses * period
        t = np.unique([starts, starts + on])
        return t[(t > 0) & (t < duration)]

    def faults(self) -> Iterator[Advice]:
        if self.is_single:
            if self.ends <= self.begins:
                yield "ends", "ends before it begins", "give a time after `begins`"
            if self.phase != 0:
                yield "phase", "has a phase beside a single window", "drop it, or give period and duration"
        elif self.duration > self.period:
            yield "duration", "is on for longer than its period", "give a duration below the period, or a heat_source"
