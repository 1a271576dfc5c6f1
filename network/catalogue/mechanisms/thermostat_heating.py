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

KEPT_ABOVE = 10.0
"""K over the reference at which a proposal keeps a part."""


class ThermostatHeating(Source, Relay, kind="thermostat_heating"):
    """A heater with hysteresis: q = P while on; it goes on below set − h, off above set + h, `delay` later each time.

    The mirror of thermostat_cooling: a boiler, a heated bed, an oven. One mass C that loses q_loss < P and has no delay
    is on for t_on = 2hC/(P − q_loss) and off for t_off = 2hC/q_loss. It is on from the start where that is cold. Not
    looked for beside thermostat_cooling: where it switches must be searched for at every part, at all set points.
    """

    watches = place("the place whose temperature switches it")
    set = param("degC", -50, 300, "set point", typical=40)
    hysteresis = param("K", 0, 50, "half width of the hysteresis", positive=True, typical=0.7)
    power = param("W", 0, 1e6, "heat given while on", typical=500)
    delay = param("s", 0, 7200, "time between crossing and switching", default=0)
    strength = "power"
    shapes = ("set", "hysteresis")
    sentence = "a heater gives {power} to {into}, on and off around {set} ± {hysteresis} at {watches}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = self.power * np.ones_like(u["time"])
        return q

    def guard(self, mode: Array, u: Inputs, *T: Array) -> Array:
        return beyond(mode, -T[0], -self.set, self.hysteresis)

    def pause(self) -> Array:
        return self.delay

    @classmethod
    def is_searched(cls) -> bool:
        return False

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Into and watching every part, which it keeps warmer than the reference."""
        for name in cls.hosts(machine):
            warm = show(machine.reference + KEPT_ABOVE, "degC", 17)
            body = size_body(cls, machine, into={name: 1}, watches=name, set=warm)
            yield {"sources": {fresh(f"{cls.kind} {name}", machine.sources): body}}
