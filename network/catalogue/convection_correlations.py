"""Free convection of air at surfaces: film coefficients by correlations, with the range each was fitted in.

Air at 1 atm, properties at the film temperature: conductivity and viscosity by Sutherland's law (constants of White,
Viscous Fluid Flow, tables 1-2 and 1-3), Pr = 0.71. Vertical plate (Ra 0.1 to 1e12) and horizontal cylinder (Ra 1e-5 to
1e12): Churchill & Chu, Int. J. Heat Mass Transfer 18 (1975) 1323 and 1049. Horizontal plates: McAdams, Heat
Transmission, Nu = 0.54 Ra^(1/4) (Ra 1e4 to 1e7) and 0.15 Ra^(1/3) (to 1e11) for a warm one facing up, 0.27 Ra^(1/4)
(1e5 to 1e10) facing down, with area over perimeter as length; a plate colder than the air takes the other one's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.base import ZERO_CELSIUS, magnitude

GRAVITY = 9.80665
PRANDTL = 0.71
GAS_CONSTANT = 287.05
PRESSURE = 101_325.0


@dataclass(frozen=True)
class Film:
    """One correlation Nu(Ra), its range of Ra, and what its length is; `cold`: the one for a surface below the air's
    temperature, where that is another."""

    low: float
    high: float
    length: str
    constant: float = 0.0
    turbulent: float = 0.0
    laminar: float = 0.0
    cold: str = ""

    def nusselt(self, Ra: Array) -> Array:
        if not self.constant:
            return np.maximum(self.laminar * Ra**0.25, self.turbulent * Ra ** (1 / 3))
        prandtl_factor = (1 + (self.laminar / PRANDTL) ** (9 / 16)) ** (8 / 27)
        return np.asarray((self.constant + 0.387 * Ra ** (1 / 6) / prandtl_factor) ** 2)


FILMS = {
    "vertical_plate": Film(1e-1, 1e12, "height", constant=0.825, laminar=0.492),
    "horizontal_cylinder": Film(1e-5, 1e12, "diameter", constant=0.60, laminar=0.559),
    "plate_facing_up": Film(1e4, 1e11, "area over perimeter", laminar=0.54, turbulent=0.15, cold="plate_facing_down"),
    "plate_facing_down": Film(1e5, 1e10, "area over perimeter", laminar=0.27, cold="plate_facing_up"),
}


def rayleigh(T_a: Array, T_b: Array, length: Array) -> Array:
    """Ra = g β |ΔT| L³ / (ν α) of air at the mean of both temperatures [°C]."""
    _, viscosity, T_film = _air(T_a, T_b)
    return np.asarray(GRAVITY * magnitude(T_a - T_b) * length**3 * PRANDTL / (T_film * viscosity**2))


def coefficient(geometry: str, T_a: Array, T_b: Array, length: Array) -> Array:
    """Mean heat transfer coefficient [W/(m² K)] between surface T_a and air T_b [°C]."""
    conductivity, _, _ = _air(T_a, T_b)
    film, Ra = FILMS[geometry], rayleigh(T_a, T_b, length)
    Nu = film.nusselt(Ra)
    if film.cold:
        Nu = np.where(np.real(T_a - T_b) < 0, FILMS[film.cold].nusselt(Ra), Nu)
    return np.asarray(Nu * conductivity / length)


def _air(T_a: Array, T_b: Array) -> tuple[Array, Array, Array]:
    """Conductivity [W/(m K)], kinematic viscosity [m²/s] and film temperature [K]."""
    T = (T_a + T_b) / 2 + ZERO_CELSIUS
    conductivity = 0.0241 * (T / 273) ** 1.5 * (273 + 194) / (T + 194)
    viscosity = 1.716e-5 * (T / 273) ** 1.5 * (273 + 111) / (T + 111)
    return conductivity, viscosity * GAS_CONSTANT * T / PRESSURE, T
