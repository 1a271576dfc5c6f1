from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import set_in_each
from network.catalogue.mechanisms.base import Source, raise_to_power
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.typical_values import usual_speed


class MotorLoss(Source, kind="motor_loss"):
    """Losses of a motor: q = copper (while |n| > 0) + iron (|n|/n_ref)^p.

    p is 1 (hysteresis) to 2 (eddy currents) at constant induction. Copper loss at constant current; it does not change
    with temperature here (see copper_temperature). A proposal begins with iron loss alone, and copper loss is fitted
    beside it; copper loss alone is a heat_source with `with: running`. Source: separation of iron losses k_h f +
    k_e f², Bertotti, IEEE Trans. Magn. 24 (1988) 621.
    """

    copper = param("W", 0, 1e6, "copper loss while running", typical=60)
    iron = param("W", 0, 1e6, "iron loss at the reference speed", typical=200)
    iron_exponent = param("1", 0.5, 3, "exponent of the iron loss over speed", default=1.5)
    reference_speed = param("rpm", 0, 300_000, "speed at which the iron loss is given", positive=True, typical=10_000)
    input = channel("speed", "rpm")
    strength = "iron"
    shapes = ("copper",)
    changed = dict.fromkeys(
        ("copper", "iron"), ("a motor that loses more: its load, or a fault", "a motor that loses less: its load")
    )
    sentence = "a motor heats {into} with {copper} copper loss and {iron} iron loss at {reference_speed}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        n = np.abs(u[self.input])
        q: Array = self.copper * (n > 0) + self.iron * raise_to_power(n / self.reference_speed, self.iron_exponent)
        return q

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """In every part that has a heat capacity."""
        return set_in_each(super().besides(machine), copper="0 W", **usual_speed(machine))
