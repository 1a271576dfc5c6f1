from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.declare import Advice, Array
from network.fields import param
from network.mechanisms.base import SPINDLE, Inputs, Source

KILOWATT_AT = 2 * np.pi / 60 * 3000
"""rad/s: a bearing whose torque makes a kilowatt at 3000 rpm was probably meant in N mm."""


class BearingFriction(Source, kind="bearing_friction"):
    """Friction of a bearing of constant torque: q = 2π/60 · |n| · M = ω M.

    With n in rpm and M in N mm this is q = 1.047e-4 n M. The partition between the rings is `into`; one half each is
    the usual assumption. Zero at rest; the sign of n does not matter. Source: Harris, Rolling Bearing Analysis,
    H = 1.047e-4 n M; the same as eq. 10 of the heat-quantity method (where M is printed in N m: it is N mm).
    """

    torque = param("N m", 0, 1e5, "friction torque", typical=0.3)
    inputs = SPINDLE
    strength = "torque"
    looks_like = ("motor_loss", "viscous_friction", "windage")
    sentence = "a bearing rubs with {torque} and heats {into}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        return np.abs(u["speed"]) * self.torque

    def doubts(self) -> Iterator[Advice]:
        kilowatts = float(self.torque) * KILOWATT_AT / 1e3
        if kilowatts > 1:
            yield "torque", f"makes {kilowatts:.3g} kW at 3000 rpm", "was N mm meant instead of N m?"
