from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import Place, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import fresh_entry
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Inputs, Relay, beyond
from network.catalogue.typical_values import size_body
from network.platform.quantities.units import show


class Thermostat(Source, Relay):
    """Heat of a constant power that hysteresis switches: q = ±P while on, off once it has come h to the other side of
    the set point, `delay` later each time. sign: of the heat; warmer: K over the reference at which one is proposed."""

    sign: ClassVar[float]
    warmer: ClassVar[float]

    watches = place("the place whose temperature switches it")
    set = param("degC", -50, 300, "set point", typical=22)
    hysteresis = param("K", 0, 50, "half width of the hysteresis", positive=True, typical=0.7)
    power = param("W", 0, 1e6, "heat taken or given while on", typical=500)
    delay = param("s", 0, 7200, "time between crossing and switching", default=0)
    strength = "power"
    shapes = ("set", "hysteresis")

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = self.sign * self.power * np.ones_like(u["time"])
        return q

    def guard(self, mode: Array, u: Inputs, *T: Array) -> Array:
        return beyond(mode, -self.sign * T[0], -self.sign * self.set, self.hysteresis)

    def pause(self) -> Array:
        return self.delay

    def levels(self) -> tuple[Place, float, float] | None:
        away = -self.sign * float(self.hysteresis)
        return self.watches, float(self.set) + away, float(self.set) - away

    def keep_between(self, low: float, high: float) -> Mapping[str, Any]:
        written = (("set", (low + high) / 2, "degC"), ("hysteresis", (high - low) / 2, "K"))
        return {key: show(value, unit, 17) for key, value, unit in written}

    def follow(self, mode: str) -> Mapping[str, Any] | None:
        kept = {key: value for key, value in self.to_plain().items() if key in ("into", "power", "while")}
        return {"kind": "heat_source", **kept, "with": mode, "at": f"{self.sign:g}"}

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Into and watching every part."""
        around = show(machine.reference + cls.warmer, "degC", 17)
        for name in cls.hosts(machine):
            body = size_body(cls, machine, into={name: 1}, watches=name, set=around)
            yield {"sources": {fresh_entry(cls.kind, name, machine.sources): body}}
