from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import fresh
from network.catalogue.mechanisms.base import Inputs, Relay, Source, beyond
from network.catalogue.typical_values import size_body
from network.platform.quantities.units import show


class ThermostatCooling(Source, Relay, kind="thermostat_cooling"):
    """A cooler with hysteresis: q = −P while on; it goes on above set + h, off below set − h, `delay` later each time.

    For one mass C with constant heat q < P, no losses and no delay it is on for t_on = 2hC/(P − q) and off for
    t_off = 2hC/q: the period 2hC P/(q (P − q)) is shortest at q = P/2, so it falls as the load rises up to half the
    cooling power. A delay d lets the temperature overshoot by q d/C above and (P − q) d/C below.
    """

    watches = place("the place whose temperature switches it")
    set = param("degC", -50, 300, "set point", typical=22)
    hysteresis = param("K", 0, 50, "half width of the hysteresis", positive=True, typical=0.7)
    power = param("W", 0, 1e6, "heat taken while on", typical=500)
    delay = param("s", 0, 7200, "time between crossing and switching", default=0)
    strength = "power"
    shapes = ("set", "hysteresis")
    sentence = "a cooler takes {power} out of {into}, on and off around {set} ± {hysteresis} at {watches}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = -self.power * np.ones_like(u["time"])
        return q

    def guard(self, mode: Array, u: Inputs, *T: Array) -> Array:
        return beyond(mode, T[0], self.set, self.hysteresis)

    def pause(self) -> Array:
        return self.delay

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Into and watching every part, set to the reference: off until it is the half width warmer."""
        for name in cls.hosts(machine):
            around = show(machine.reference, "degC", 17)
            body = size_body(cls, machine, into={name: 1}, watches=name, set=around)
            yield {"sources": {fresh(f"{cls.kind} {name}", machine.sources): body}}
