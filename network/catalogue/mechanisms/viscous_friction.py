from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, place
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike
from network.catalogue.mechanisms.base import Inputs
from network.catalogue.mechanisms.bearing_friction import BearingFriction
from network.catalogue.mechanisms.friction import Friction
from network.platform.quantities.number_format import per_kelvin


class ViscousFriction(Friction, kind="viscous_friction"):
    """Bearing friction that falls as its lubricant warms: q = |ω| M e^(−b (T − T_ref)), T_ref the machine's reference.

    b is the slope of −ln ν over T times 2/3, as the lubricant's torque goes with ν^(2/3) (Palmgren; unverified): for
    an oil of 32 mm²/s at 40 °C and 5.4 at 100 °C, ASTM D341 (Walther), log log (ν + 0.7) = A − B log T, gives 0.038 1/K
    at 20 °C and 0.028 at 40 °C. One exponential follows it to some 5 % within 10 K of where b was taken.
    """

    torque = param("N m", 0, 1e5, "friction torque at the reference temperature", typical=0.3)
    thinning = param("1/K", 0, 0.2, "decrease of the torque per kelvin", typical=0.03)
    reads = place("where the lubricant's temperature is read")
    affine = False
    strength = "thinning"
    replaces = {"bearing_friction": {"torque": "torque"}}
    derived = ("cold",)
    cold: float
    sentence = "the friction that heats {into} falls by {percent} as {reads} warms"

    @property
    def percent(self) -> str:
        """The thinning in words."""
        return per_kelvin(float(self.thinning))

    def moment(self, u: Inputs, *T: Array) -> Array:
        M: Array = self.torque * np.exp(-self.thinning * (T[0] - self.cold))
        return M

    def slopes(self, u: Inputs, *T: Array) -> tuple[Array, ...]:
        return (-self.thinning * self.heat(u, *T),)

    def resolve(self, machine: MachineLike) -> Self:
        return self.replaced(cold=machine.reference)

    @classmethod
    def take_over(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """Of a constant torque: it reads where the heat goes first."""
        if isinstance(entry, BearingFriction) and entry.is_constant:
            return {"reads": str(entry.into[0][0])}
        return None
