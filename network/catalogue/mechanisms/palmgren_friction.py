from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import nested, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import set_in_each
from network.catalogue.fluids import find_viscosity
from network.catalogue.lubricant import Lubricant
from network.catalogue.mechanisms.bearing_friction import find_palmgren_torque
from network.catalogue.mechanisms.friction import Rubbing, turning
from network.catalogue.mechanisms.mechanism import Inputs


class PalmgrenFriction(Rubbing, kind="palmgren_friction"):
    """A bearing after Palmgren, its oil at its own temperature: q = |ω| (M₀(ν(T) n) + f₁ P d_m).

    M₀ = 1e-7 f₀ max((ν n)^(2/3), 160) d_m³ in N mm, ν in mm²/s by Walther's law from the oil's grade (see lubricant), n
    in 1/min, d_m in mm; the branches meet at ν n = 2024, as in bearing_friction. f₀ is 0.7 to 1.7 for oil-air and
    grease, 2 to 4 in an oil bath, more for rollers (Harris, Rolling Bearing Analysis; unverified). Not looked for by a
    diagnosis: nobody can tell f₀, ν and d_m apart, so bearing_friction and viscous_friction stand for it.
    """

    lubrication_factor = param("1", 0, 50, "f₀: bearing and lubrication", typical=1.5)
    oil: Lubricant = nested("the lubricant by its grade, like {grade: 32}", lambda: Lubricant, required=True)
    mean_diameter = param("mm", 0, 5000, "mean diameter of the bearing", positive=True, typical=80)
    load_factor = param("1", 0, 0.1, "f₁: bearing and load", default=0, typical=0.0005)
    load = param("N", 0, 1e7, "load that makes friction", default=0, typical=500)
    reads = place("where the oil's temperature is read; default the first place of `into`", default=None)
    strength = "lubrication_factor"
    searched = False
    affine = False
    derived = ("walther_A", "walther_B")
    walther_A: Array
    walther_B: Array
    sentence = "a bearing of {mean_diameter} rubs in its oil, f₀ = {lubrication_factor}, and heats {into}"

    def resolve(self, machine: MachineLike) -> Self:
        A, B = self.oil.oil.walther
        return self.replaced(walther_A=A, walther_B=B, reads=self.reads if self.reads is not None else self.into[0][0])

    def moment(self, u: Inputs, *T: Array) -> Array:
        viscosity = find_viscosity(T[0], self.walther_A, self.walther_B)
        stirred = find_palmgren_torque(self.lubrication_factor, viscosity, u[self.input], self.mean_diameter)
        return np.asarray(stirred + self.load_factor * self.load * self.mean_diameter)

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Into what turns, with an oil of VG 32."""
        return set_in_each(super().besides(machine), oil={"grade": 32})

    @classmethod
    def hosts(cls, machine: MachineLike) -> Iterator[str]:
        return turning(machine)
