from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import nested, param, place
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike
from network.catalogue.fluids import find_viscosity
from network.catalogue.lubricant import Lubricant
from network.catalogue.mechanisms.base import complex_steps
from network.catalogue.mechanisms.bearing_friction import BearingFriction
from network.catalogue.mechanisms.friction import Friction
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.number_format import per_kelvin


class ViscousFriction(Friction, kind="viscous_friction"):
    """Bearing friction that falls as its lubricant warms: q = |ω| M e^(−b (T − T_ref)), T_ref the machine's reference.

    With `oil: {grade: 32}` instead of b it is q = |ω| M (ν(T)/ν(T_ref))^(2/3), as the lubricant's torque goes
    (Palmgren; unverified), ν(T) by Walther's law (ASTM D341), log log (ν + 0.7) = A − B log T. b is the slope of −ln ν
    over T times 2/3: 0.038 1/K at 20 °C and 0.028 at 40 °C for VG 32. One exponential follows it to some 5 % within
    10 K of where b was taken. A diagnosis looks for b. palmgren_friction makes M from the bearing's size.
    """

    torque = param("N m", 0, 1e5, "friction torque at the reference temperature", typical=0.3)
    thinning = param("1/K", 0, 0.2, "decrease of the torque per kelvin", default=None, typical=0.03)
    oil: Lubricant | None = nested("the lubricant by its grade, instead of thinning", lambda: Lubricant)
    reads = place("where the lubricant's temperature is read")
    one_of = (("thinning",), ("oil",))
    affine = False
    strength = "thinning"
    replaces = {"bearing_friction": {"torque": "torque"}}
    derived = ("cold", "walther_A", "walther_B")
    cold: Array
    walther_A: Array
    walther_B: Array
    sentence = "the friction that heats {into} falls by {percent} as {reads} warms"

    @property
    def percent(self) -> str:
        """The thinning in words, at the reference."""
        (slope,) = complex_steps(lambda T: np.log(self._thinned(T)), np.array(float(self.cold)))
        return per_kelvin(-float(slope))

    def moment(self, u: Inputs, *T: Array) -> Array:
        return np.asarray(self.torque * self._thinned(T[0]))

    def _thinned(self, T: Array) -> Array:
        """The torque at T over that at the reference."""
        if self.oil is None:
            return np.asarray(np.exp(-self.thinning * (T - self.cold)))
        now, cold = (find_viscosity(x, self.walther_A, self.walther_B) for x in (T, self.cold))
        return np.asarray((now / cold) ** (2 / 3))

    def slopes(self, u: Inputs, *T: Array) -> tuple[Array, ...]:
        return (-self.thinning * self.heat(u, *T),) if self.oil is None else super().slopes(u, *T)

    def resolve(self, machine: MachineLike) -> Self:
        A, B = (0.0, 0.0) if self.oil is None else self.oil.oil.walther
        return self.replaced(cold=machine.reference, walther_A=A, walther_B=B)

    @classmethod
    def take_over(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """Of a constant torque: it reads where the heat goes first."""
        if isinstance(entry, BearingFriction) and entry.is_constant:
            return {"reads": str(entry.into[0][0])}
        return None
