from __future__ import annotations

import numpy as np

from network.catalogue.convection_correlations import free_nusselt
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param, word
from network.catalogue.fluids import FLUIDS
from network.catalogue.mechanisms.base import raise_to_power
from network.catalogue.mechanisms.film import MovingFilm, join_free_and_forced
from network.catalogue.mechanisms.mechanism import Inputs

TURNS = 5e5
"""Reynolds number at which the flow along the plate becomes turbulent."""


class PlateFlow(MovingFilm, kind="plate_flow"):
    """Flow along a wall, or a slide that moves through still air: Nu = 0.664 √Re Pr^(1/3), Re = w L/ν, h = Nu k/L.

    Above Re = 5e5: Nu = (0.037 Re^0.8 − 871) Pr^(1/3), laminar at its leading end (Incropera & DeWitt, flat plate in
    parallel flow; unverified), with 871 taken so that nothing jumps; to Re = 1e8, Pr 0.6 to 50 (laminar beyond that
    too). w is the velocity of a stream, or that of the part itself, by an input. At rest it is a still vertical plate,
    in between Nu³ = Nu_forced³ + Nu_still³. Where the part moves, a diagnosis looks for forced_convection in its stead.
    """

    length = param("m", 0, 100, "length along the flow", positive=True, typical=0.5)
    velocity = param("m/s", 0, 300, "velocity of the stream", default=None, typical=3)
    own_speed = channel(None, "m/min", "the input at which the part itself moves, like feed", key="moves")
    fluid = word("the fluid along it", *FLUIDS, default="air")
    most = 1e8
    one_of = (("velocity",), ("own_speed",))
    sentence = "{between[1]} flows along {between[0]}, {area}, {length} in the direction of flow"

    def reynolds(self, T: Array, u: Inputs) -> Array:
        speed = self.velocity if self.velocity is not None else np.abs(u[self.own_speed])
        return np.asarray(speed * self.length / FLUIDS[self.fluid].viscosity(T))

    def coefficient(self, T_a: Array, T_b: Array, u: Inputs) -> Array:
        fluid, T = FLUIDS[self.fluid], (T_a + T_b) / 2
        forced = plate_nusselt(self.reynolds(T, u)) * fluid.prandtl(T) ** (1 / 3)
        still = free_nusselt("vertical_plate", T_a, T_b, self.length, fluid)
        return np.asarray(join_free_and_forced(forced, still) * fluid.conductivity(T) / self.length)


def plate_nusselt(Re: Array) -> Array:
    """Mean Nu/Pr^(1/3) along a plate: laminar to TURNS, from there with a turbulent rest."""
    laminar = 0.664 * raise_to_power(Re, np.array(0.5))
    offset = 0.037 * TURNS**0.8 - 0.664 * TURNS**0.5
    return np.where(np.real(Re) > TURNS, 0.037 * raise_to_power(Re, np.array(0.8)) - offset, laminar)
