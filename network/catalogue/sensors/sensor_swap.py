from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any

from network.catalogue.declaration.declare import Array, typical_body
from network.catalogue.declaration.fields import word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.sensors.base import SensorEffect


class SensorSwap(SensorEffect, kind="sensor_swap"):
    """Two sensors are exchanged: reading of a = truth at the place of b, reading of b = truth at the place of a.

    Crossed plugs, or two columns of a logger under each other's names. It is enough to say it at one of the two. Places
    alone are exchanged; noise and further effects stay with the channel. No number to fit: it is there or not, so a
    search tries all pairs in all runs and needs no gradient. Two parts that warm alike cannot be told apart.
    """

    shows_in_readings = True
    other = word("the name of the sensor it is exchanged with", key="with")
    strength = "other"
    searched = False
    """By no slope: all pairs are tried in the readings."""
    sentence = "{channel} and {other} are exchanged"

    @property
    def exchanges(self) -> str:
        return str(self.other)

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        return truth

    @classmethod
    def proposes(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Every pair that reads the same quantity at different places and is not exchanged yet, at both of them."""
        done = {*machine.exchanged_by, *machine.exchanged_by.values()}
        for (a, one), (b, other) in combinations(machine.sensors.items(), 2):
            if one.quantity == other.quantity and one.measures != other.measures and not {a, b} & done:
                yield {"sensors": {a: cls.put_on(one, typical_body(cls, **{"with": b})),
                                   b: cls.put_on(other, typical_body(cls, **{"with": a}))}}  # fmt: skip
