"""Fluids that films and lubricants are made of: air, water and mineral oils by their ISO VG grade, over temperature.

Everything takes °C. Air at 1 atm: conductivity and viscosity by Sutherland's law (constants of White, Viscous Fluid
Flow, tables 1-2 and 1-3), Pr = 0.71, an ideal gas; -50 to 300 °C. Water, 5 to 95 °C: viscosity of Popiel & Wojtkowiak,
Heat Transfer Eng. 19 (1998) 87; density and conductivity parabolas through the values of Modelica.Thermal.FluidHeatFlow
at 10, 30 and 90 °C, specific heat 4182 J/(kg K): within 1 %, the expansion within 8 %. Oil, 0 to 120 °C: see `Oil`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.base import ZERO_CELSIUS

PRESSURE = 101_325.0
GAS_CONSTANT = 287.05


class Fluid(ABC):
    """k [W/(m K)], ν [m²/s], Pr and the volume's expansion β [1/K] at T [°C]."""

    @abstractmethod
    def conductivity(self, T: Array) -> Array: ...

    @abstractmethod
    def viscosity(self, T: Array) -> Array: ...

    @abstractmethod
    def prandtl(self, T: Array) -> Array: ...

    @abstractmethod
    def expansion(self, T: Array) -> Array: ...


class Air(Fluid):
    def conductivity(self, T: Array) -> Array:
        K = T + ZERO_CELSIUS
        return np.asarray(0.0241 * (K / 273) ** 1.5 * (273 + 194) / (K + 194))

    def viscosity(self, T: Array) -> Array:
        K = T + ZERO_CELSIUS
        dynamic = 1.716e-5 * (K / 273) ** 1.5 * (273 + 111) / (K + 111)
        return np.asarray(dynamic * GAS_CONSTANT * K / PRESSURE)

    def prandtl(self, T: Array) -> Array:
        return np.asarray(0.71)

    def expansion(self, T: Array) -> Array:
        return np.asarray(1 / (T + ZERO_CELSIUS))


class Water(Fluid):
    specific_heat = 4182.0

    def _density(self, T: Array) -> Array:
        return np.asarray(999.7 - 0.205 * (T - 10) - 0.00375 * (T - 10) * (T - 30))

    def _dynamic(self, T: Array) -> Array:
        return np.asarray(1 / (557.82468 + 19.408782 * T + 0.1360459 * T**2 - 3.1160832e-4 * T**3))

    def conductivity(self, T: Array) -> Array:
        return np.asarray(0.588 + 1.35e-3 * (T - 10) - 4.1667e-6 * (T - 10) * (T - 30))

    def viscosity(self, T: Array) -> Array:
        return np.asarray(self._dynamic(T) / self._density(T))

    def prandtl(self, T: Array) -> Array:
        return np.asarray(self._dynamic(T) * self.specific_heat / self.conductivity(T))

    def expansion(self, T: Array) -> Array:
        return np.asarray((0.205 + 0.00375 * (2 * T - 40)) / self._density(T))


@dataclass(frozen=True)
class Oil(Fluid):
    """A mineral oil by its viscosities at 40 and 100 °C [m²/s].

    Walther: log log (ν + 0.7) = A − B log T, ν in mm²/s (above 2), T in kelvin, decimal logarithms (ASTM D341).
    Density 870 kg/m³ at 15 °C, less 0.65 per kelvin; conductivity 0.117/d (1 − 0.00054 T) and specific heat
    (1685 + 3.4 T)/√d with d = 0.87 (Cragoe, Bureau of Standards Misc. Publ. 97, 1929; unverified).
    """

    at_40: float
    at_100: float

    @cached_property
    def walther(self) -> tuple[float, float]:
        """A and B."""
        return walther_constants(self.at_40, self.at_100)

    def conductivity(self, T: Array) -> Array:
        return np.asarray(0.117 / 0.87 * (1 - 0.00054 * T))

    def viscosity(self, T: Array) -> Array:
        return find_viscosity(T, *self.walther)

    def prandtl(self, T: Array) -> Array:
        volumetric = (1685 + 3.4 * T) / 0.87**0.5 * (870 - 0.65 * (T - 15))
        return np.asarray(self.viscosity(T) * volumetric / self.conductivity(T))

    def expansion(self, T: Array) -> Array:
        return np.asarray(0.65 / (870 - 0.65 * (T - 15)))


def walther_constants(at_40: float, at_100: float) -> tuple[float, float]:
    """A and B of Walther's law from two viscosities [m²/s]."""
    low, high = (np.log10(np.log10(v * 1e6 + 0.7)) for v in (at_40, at_100))
    warm, hot = (np.log10(T + ZERO_CELSIUS) for T in (40.0, 100.0))
    B = (low - high) / (hot - warm)
    return float(low + B * warm), float(B)


def find_viscosity(T: Array, A: Array | float, B: Array | float) -> Array:
    """ν [m²/s] at T [°C] by Walther's law; −100 °C at the least, below which it has no meaning."""
    K = np.where(np.real(T) > -100, T, -100.0) + ZERO_CELSIUS
    return np.asarray((10 ** (10 ** (A - B * np.log10(K))) - 0.7) * 1e-6)


ISO_VG = {10: 2.6, 15: 3.4, 22: 4.3, 32: 5.4, 46: 6.8, 68: 8.7, 100: 11.4, 150: 15.0, 220: 19.4, 320: 24.0, 460: 30.5}
"""Grade, the viscosity at 40 °C in mm²/s ± 10 % (ISO 3448) → usual viscosity at 100 °C of a mineral oil of viscosity
index 95 to 100 (data sheets; VG 32 by the worked sheet of ASTM D341)."""


def oil_of_grade(grade: int, at_100: float | None = None) -> Oil:
    """The oil of an ISO VG grade; at_100: its viscosity at 100 °C [m²/s], if not the usual one."""
    return Oil(grade * 1e-6, ISO_VG[grade] * 1e-6 if at_100 is None else at_100)


FLUIDS: dict[str, Fluid] = {
    "air": Air(), "water": Water(), **{f"oil_vg_{grade}": oil_of_grade(grade) for grade in ISO_VG},
}  # fmt: skip
