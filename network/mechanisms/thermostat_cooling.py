from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from network.declare import Array, typical_body
from network.fields import param, place
from network.mechanisms.base import Inputs, Relay
from network.units import show


class ThermostatCooling(Relay, kind="thermostat_cooling"):
    """A cooler with hysteresis: takes `power` while on; on above set + hysteresis, off below set − hysteresis.

    `delay` is the time between the crossing and the switching. For one mass C with a constant heat q, no losses and
    no delay the period is 2 h C (1/q + 1/(P − q)): it falls as the load rises up to half the cooling power.
    """

    watches = place("the place whose temperature switches it")
    set = param("degC", -50, 300, "set point", typical=22)
    hysteresis = param("K", 0, 50, "half width of the hysteresis", positive=True, typical=0.7)
    power = param("W", 0, 1e6, "heat taken while on", typical=500)
    delay = param("s", 0, 7200, "time between crossing and switching", default=0)
    strength = "power"
    looks_like = ("timed_source", "viscous_friction", "convection")
    sentence = "a cooler takes {power} out of {into}, on and off around {set} ± {hysteresis} at {watches}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        return -self.power * np.ones_like(u["time"])

    def guard(self, mode: Array, u: Inputs, *T: Array) -> Array:
        return np.where(mode > 0, self.set - self.hysteresis - T[0], T[0] - self.set - self.hysteresis)

    def pause(self) -> Array:
        return self.delay

    @classmethod
    def proposes(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """Into and watching every part, switching around the reference."""
        for name in cls.hosts(machine):
            body = typical_body(cls, into={name: 1}, watches=name, set=show(machine.reference + 1, "degC"))
            yield {"sources": {f"{cls.kind} {name}": body}}
