from __future__ import annotations

import numpy as np

from network.catalogue.convection_correlations import free_nusselt
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param, word
from network.catalogue.fluids import FLUIDS
from network.catalogue.mechanisms.base import raise_to_power
from network.catalogue.mechanisms.film import TurningFilm, join_free_and_forced
from network.catalogue.mechanisms.mechanism import Inputs


class RotatingCylinder(TurningFilm, kind="rotating_cylinder"):
    """A shaft, a chuck or a tool that turns in a wide room: Nu = 0.133 Re^(2/3) Pr^(1/3), Re = |ω| D²/ν, h = Nu k/D.

    Becker, Int. J. Heat Mass Transfer 6 (1963) 1053, as in a problem of Incropera & DeWitt (the coefficients
    unverified), for Re < 4.3e5 and 0.7 < Pr < 670. At rest it is a still horizontal cylinder (Churchill & Chu); in
    between Nu³ = Nu_rotating³ + Nu_still³. Looks like forced_convection with an exponent of 2/3, which a diagnosis
    looks for in its stead; radiation and a fan on the shaft come on top. In a narrow bore: annular_gap.
    """

    diameter = param("mm", 0, 5000, "diameter", positive=True, typical=80)
    fluid = word("the fluid around it", *FLUIDS, default="air")
    input = channel("speed", "rpm")
    most = 4.3e5
    sentence = "{between[0]} turns in {between[1]} as a cylinder of {diameter}, {area}"

    def reynolds(self, T: Array, u: Inputs) -> Array:
        return np.asarray(np.abs(u[self.input]) * self.diameter**2 / FLUIDS[self.fluid].viscosity(T))

    def coefficient(self, T_a: Array, T_b: Array, u: Inputs) -> Array:
        fluid, T = FLUIDS[self.fluid], (T_a + T_b) / 2
        turning = 0.133 * raise_to_power(self.reynolds(T, u), np.array(2 / 3)) * fluid.prandtl(T) ** (1 / 3)
        still = free_nusselt("horizontal_cylinder", T_a, T_b, self.diameter, fluid)
        return np.asarray(join_free_and_forced(turning, still) * fluid.conductivity(T) / self.diameter)
