from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

import numpy as np

from network.declare import Array
from network.fields import param, place
from network.mechanisms.base import SPINDLE, Inputs, Source, keeping
from network.mechanisms.bearing_friction import BearingFriction


class ViscousFriction(Source, kind="viscous_friction"):
    """Bearing friction that falls as its lubricant warms: q = ω M e^(−b (T − T_ref)), T_ref the machine's reference.

    b is 0.02 to 0.06 1/K for mineral oils around room temperature: the slope of ln ν by Walther's equation (ASTM
    D341) times 2/3, as torque goes with ν^(2/3) (Palmgren). Valid some 30 K around the reference.
    """

    torque = param("N m", 0, 1e5, "friction torque at the reference temperature", typical=0.3)
    thinning = param("1/K", -0.2, 0.2, "decrease of the torque per kelvin", typical=0.03)
    reads = place("where the lubricant's temperature is read")
    inputs = SPINDLE
    affine = False
    strength = "thinning"
    looks_like = ("preload_friction", "contact", "forced_convection")
    replaces = {"bearing_friction": {"torque": "torque"}}
    derived = ("cold",)
    cold: float
    sentence = "the friction of {name} falls by {thinning} as {reads} warms"

    def heat(self, u: Inputs, *T: Array) -> Array:
        return np.abs(u["speed"]) * self.torque * np.exp(-self.thinning * (T[0] - self.cold))

    def resolved(self, machine: Any) -> Self:
        return self.replaced(cold=machine.reference)

    @classmethod
    def proposes(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """In the place of every bearing of constant torque, reading where most of its heat goes first."""
        for entry in machine.sources.values():
            if isinstance(entry, BearingFriction):
                yield keeping(cls, entry, cls.replaces[entry.kind], reads=str(entry.into[0][0]))
