from __future__ import annotations

import numpy as np

from network.catalogue.convection_correlations import free_nusselt
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.fluids import FLUIDS
from network.catalogue.mechanisms.base import raise_to_power
from network.catalogue.mechanisms.film import TurningFilm, join_free_and_forced
from network.catalogue.mechanisms.mechanism import Inputs

AIR = FLUIDS["air"]
TURNS = 2.4e5
"""ω r²/ν at which the flow over the disc becomes turbulent."""


class RotatingDisc(TurningFilm, kind="rotating_disc"):
    """A face that turns in wide air: h R/k = 0.326 √Re, Re = |ω| R²/ν, while laminar.

    From ω r²/ν = 2.4e5 outwards the local h is 0.0188 (k/r) (ω r²/ν)^0.8; the mean over both zones is used, so nothing
    jumps: Nu = 0.326 √Re (Re_c/Re) + 0.01446 Re^0.8 (1 − (Re_c/Re)^1.3). For air, one face, Re < 2e6. At rest a still
    vertical plate of its mean height π R/2, in between the sum of cubes. `area`: of one face, π R², or of both. A
    diagnosis looks for forced_convection in its stead. Source: the free rotating disc (von Kármán; local laws of
    Popiel & Bogusławski 1975, transition of Cobb & Saunders 1956; unverified; 0.326 is tested against the equations).
    """

    diameter = param("mm", 0, 5000, "diameter", positive=True, typical=250)
    input = channel("speed", "rpm")
    most = 2e6
    sentence = "{between[0]} turns in {between[1]} as a disc of {diameter}, {area}"

    def reynolds(self, T: Array, u: Inputs) -> Array:
        return np.asarray(np.abs(u[self.input]) * (self.diameter / 2) ** 2 / AIR.viscosity(T))

    def coefficient(self, T_a: Array, T_b: Array, u: Inputs) -> Array:
        T, radius = (T_a + T_b) / 2, self.diameter / 2
        height = np.pi / 2 * radius
        still = free_nusselt("vertical_plate", T_a, T_b, height) * radius / height
        turning = disc_nusselt(self.reynolds(T, u))
        return np.asarray(join_free_and_forced(turning, still) * AIR.conductivity(T) / radius)


def disc_nusselt(Re: Array) -> Array:
    """Mean h R/k of a free disc in air, laminar within and turbulent outside the radius of transition."""
    share = np.where(np.real(Re) > TURNS, TURNS / np.where(np.real(Re) > TURNS, Re, TURNS), 1.0)
    laminar = 0.326 * raise_to_power(Re, np.array(0.5)) * share
    turbulent = 0.0188 * 2 / 2.6 * raise_to_power(Re, np.array(0.8)) * (1 - share**1.3)
    return np.asarray(laminar + turbulent)
