"""Free convection at surfaces: film coefficients by correlations, with the range each was fitted in.

Properties at the film temperature (catalogue.fluids). Vertical plate (Ra 0.1 to 1e12) and horizontal cylinder (Ra 1e-5
to 1e12): Churchill & Chu, Int. J. Heat Mass Transfer 18 (1975) 1323 and 1049. A vertical cylinder is a plate of its
height where D/H ≥ 35/Gr^(1/4), which holds above some 5 cm of air. Horizontal plates: McAdams, Heat Transmission,
Nu = 0.54 Ra^(1/4) (Ra 1e4 to 1e7) and 0.15 Ra^(1/3) (to 1e11) for a warm one facing up, 0.27 Ra^(1/4) (1e5 to 1e10)
facing down, with area over perimeter as length; a plate colder than its fluid takes the other one's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.fluids import FLUIDS, Fluid
from network.catalogue.mechanisms.base import magnitude

GRAVITY = 9.80665


@dataclass(frozen=True)
class Film:
    """One correlation Nu(Ra, Pr), its range of Ra, and what its length is; `cold`: the one for a surface below the
    fluid's temperature, where that is another."""

    low: float
    high: float
    length: str
    constant: float = 0.0
    turbulent: float = 0.0
    laminar: float = 0.0
    cold: str = ""

    def nusselt(self, Ra: Array, Pr: Array) -> Array:
        if not self.constant:
            return np.maximum(self.laminar * Ra**0.25, self.turbulent * Ra ** (1 / 3))
        prandtl_factor = (1 + (self.laminar / Pr) ** (9 / 16)) ** (8 / 27)
        return np.asarray((self.constant + 0.387 * Ra ** (1 / 6) / prandtl_factor) ** 2)


PLATE = Film(1e-1, 1e12, "height", constant=0.825, laminar=0.492)
FILMS = {
    "vertical_plate": PLATE,
    "vertical_cylinder": PLATE,
    "horizontal_cylinder": Film(1e-5, 1e12, "diameter", constant=0.60, laminar=0.559),
    "plate_facing_up": Film(1e4, 1e11, "area over perimeter", laminar=0.54, turbulent=0.15, cold="plate_facing_down"),
    "plate_facing_down": Film(1e5, 1e10, "area over perimeter", laminar=0.27, cold="plate_facing_up"),
}
SHAPES = {
    "plate": {"vertical": "vertical_plate", "up": "plate_facing_up", "down": "plate_facing_down"},
    "cylinder": {"vertical": "vertical_cylinder", "horizontal": "horizontal_cylinder"},
}
"""Shape → how it may lie → its film."""
ORIENTATIONS = ("vertical", "horizontal", "up", "down")


def rayleigh(T_a: Array, T_b: Array, length: Array, fluid: Fluid = FLUIDS["air"]) -> Array:
    """Ra = g β |ΔT| L³ Pr/ν² at the mean of both temperatures [°C]."""
    T = (T_a + T_b) / 2
    buoyancy = GRAVITY * fluid.expansion(T) * magnitude(T_a - T_b) * length**3
    return np.asarray(buoyancy * fluid.prandtl(T) / fluid.viscosity(T) ** 2)


def free_nusselt(geometry: str, T_a: Array, T_b: Array, length: Array, fluid: Fluid = FLUIDS["air"]) -> Array:
    """Mean Nu = h L/k between surface T_a and fluid T_b [°C]."""
    film, Ra, Pr = FILMS[geometry], rayleigh(T_a, T_b, length, fluid), fluid.prandtl((T_a + T_b) / 2)
    Nu = film.nusselt(Ra, Pr)
    if film.cold:
        Nu = np.where(np.real(T_a - T_b) < 0, FILMS[film.cold].nusselt(Ra, Pr), Nu)
    return Nu


def coefficient(geometry: str, T_a: Array, T_b: Array, length: Array, fluid: Fluid = FLUIDS["air"]) -> Array:
    """Mean heat transfer coefficient [W/(m² K)] between surface T_a and fluid T_b [°C]."""
    Nu = free_nusselt(geometry, T_a, T_b, length, fluid)
    return np.asarray(Nu * fluid.conductivity((T_a + T_b) / 2) / length)
