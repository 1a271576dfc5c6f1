from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

import numpy as np

from network.declare import Advice, Array
from network.fields import amount, param, word
from network.mechanisms.base import SPINDLE, Inputs, Source


class HeatSource(Source, kind="heat_source"):
    """Constant heat, heat while the spindle turns, or heat in proportion to an input: q = P · u/u_at.

    `with: always` gives P at all times, `with: running` while |n| > 0, `with: name` in proportion to that input
    channel, which gives P at the value `at`.
    """

    power = param("W", -1e6, 1e6, "heat", typical=100)
    driver = word("always, running, or the name of an input channel", default="always", key="with")
    at = amount("value of the input at which the heat is `power`, like 15 m/min", default=None)
    derived = ("full",)
    full: float
    strength = "power"
    looks_like = ("timed_source", "ambient_drift")
    sentence = "{into} receives {power} from a source ({driver})"

    def needs(self) -> Mapping[str, str]:
        if self.driver == "always":
            return {}
        return SPINDLE if self.driver == "running" else {self.driver: self.at.unit}

    def resolved(self, machine: Any) -> Self:
        return self.replaced(full=self.at.value if self.at is not None else None)

    def faults(self) -> Iterator[Advice]:
        follows = self.driver not in ("always", "running")
        if follows and self.at is None:
            yield "driver", f"follows '{self.driver}' but lacks 'at'", f"give the value of {self.driver} that makes `power`"
        if not follows and self.at is not None:
            yield "at", f"has 'at' with `with: {self.driver}`", "drop `at`, or name the input in `with`"

    def heat(self, u: Inputs, *T: Array) -> Array:
        if self.driver == "always":
            return self.power * np.ones_like(u["time"])
        if self.driver == "running":
            return self.power * (u["speed"] != 0)
        return self.power * u[self.driver] / self.full
