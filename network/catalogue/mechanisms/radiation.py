from __future__ import annotations

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.base import ZERO_CELSIUS, SurfaceLink
from network.catalogue.mechanisms.mechanism import Inputs

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m² K⁴), exact in SI since 2019 (CODATA)."""


class Radiation(SurfaceLink, kind="radiation"):
    """Grey-body exchange between a surface and its surroundings: Q = ε A σ (T_a⁴ − T_b⁴), T in kelvin.

    Valid for a small convex body in large surroundings (Stefan–Boltzmann law, surroundings black). Not to be confused
    with a convection of 4 ε A σ T³ ≈ 5.7 W/(m² K) · ε A at 20 °C, which it is for small differences: a calibrated
    convection absorbs it below some 30 K.
    """

    emissivity_area = param("m^2", 0, 100, "emissivity times radiating area", typical=0.5)
    affine = False
    strength = "emissivity_area"
    changed = {
        "emissivity_area": (
            "a surface that radiates more: paint or dirt",
            "a surface that radiates less: a cover or a polish",
        )
    }
    sentence = "{between[0]} radiates to {between[1]} over {emissivity_area} of black-body area"

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        fourth_powers = (T_a + ZERO_CELSIUS) ** 4 - (T_b + ZERO_CELSIUS) ** 4
        Q: Array = self.emissivity_area * STEFAN_BOLTZMANN * fourth_powers
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, Array]:
        scale = 4 * self.emissivity_area * STEFAN_BOLTZMANN
        return scale * (T_a + ZERO_CELSIUS) ** 3, -scale * (T_b + ZERO_CELSIUS) ** 3
