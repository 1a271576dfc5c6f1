from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import amount, param, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import fresh
from network.catalogue.mechanisms.base import SPINDLE, Inputs, Source
from network.catalogue.typical_values import size_body


class HeatSource(Source, kind="heat_source"):
    """Constant heat, heat while the spindle turns, or heat in proportion to an input: q = P, or q = P · u/u_at.

    `with: always` gives P at all times, `with: running` while |n| > 0, `with: name` in proportion to that input
    channel, which gives P at the value `at`. A negative P cools.
    """

    power = param("W", -1e6, 1e6, "heat", typical=100)
    driver = word("always, running, or the name of an input channel", default="always", key="with")
    at = amount("value of the input at which the heat is `power`, like 15 m/min", default=None)
    derived = ("full",)
    full: float
    strength = "power"
    sentence = "{into} receives {power} from a source {when}"

    @property
    def when(self) -> str:
        """When it is on, in words."""
        if self.driver == "always":
            return "that is always on"
        return "while the spindle turns" if self.driver == "running" else f"that follows {self.driver}"

    def needs(self) -> Mapping[str, str]:
        if self.driver == "always":
            return {}
        return SPINDLE if self.driver == "running" else {self.driver: self.at.unit}

    def resolve(self, machine: MachineLike) -> Self:
        return self.replaced(full=self.at.value if self.at is not None else None)

    def faults(self) -> Iterator[Advice]:
        follows = self.driver not in ("always", "running")
        if follows and self.at is None:
            right = f"give the value of {self.driver} that makes `power`"
            yield "driver", f"follows '{self.driver}' but lacks 'at'", right
        if not follows and self.at is not None:
            yield "at", f"has 'at' with `with: {self.driver}`", "drop `at`, or name the input in `with`"

    def heat(self, u: Inputs, *T: Array) -> Array:
        if self.driver == "always":
            share = np.ones_like(u["time"])
        else:
            share = u["speed"] != 0 if self.driver == "running" else u[self.driver] / self.full
        q: Array = self.power * share
        return q

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Into every part: always, and while the spindle runs if the machine knows its speed."""
        for driver in ("always", "running") if "speed" in machine.inputs else ("always",):
            for name in cls.hosts(machine):
                body = size_body(cls, machine, into={name: 1}, **{"with": driver})
                yield {"sources": {fresh(f"{cls.kind} {driver} {name}", machine.sources): body}}
