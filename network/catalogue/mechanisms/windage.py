from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import set_in_each
from network.catalogue.mechanisms.base import Source, raise_to_power
from network.catalogue.mechanisms.friction import turning
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.typical_values import usual_speed


class Windage(Source, kind="windage"):
    """Air friction of a rotor: q = P (|n|/n_ref)^p, P the loss at n_ref.

    p = 3 for constant friction coefficient: the loss of a disc is C_M ρ ω³ r⁵/2; where the flow in the gap is turbulent
    C_M falls with Re^−0.2 and p is about 2.8. Source: rotating discs after von Kármán 1921 and Daily & Nece 1960.
    """

    power = param("W", 0, 1e6, "loss at the reference speed", typical=200)
    reference_speed = param("rpm", 0, 300_000, "speed at which the loss is given", positive=True, typical=10_000)
    exponent = param("1", 1, 5, "exponent of the loss over speed", default=3)
    input = channel("speed", "rpm")
    strength = "power"
    sentence = "windage heats {into} with {power} at {reference_speed}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = self.power * raise_to_power(np.abs(u[self.input]) / self.reference_speed, self.exponent)
        return q

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        return set_in_each(super().besides(machine), **usual_speed(machine))

    @classmethod
    def hosts(cls, machine: MachineLike) -> Iterator[str]:
        return turning(machine)
