"""What films of moving fluid have in common: Q = h A (T_a − T_b), h by a correlation of dimensionless numbers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import ClassVar

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.mechanisms.base import SurfaceLink
from network.catalogue.mechanisms.friction import turning
from network.catalogue.mechanisms.mechanism import Inputs

USUAL = np.array(20.0)
"""°C: where the range of a correlation is checked along a run."""


class MovingFilm(SurfaceLink):
    """The surface is named first, the fluid second. A diagnosis does not look for films by correlation: what they
    could explain, forced_convection in the place of a constant film explains with numbers that a fit can turn.

    most: Reynolds number up to which the correlation holds."""

    most: ClassVar[float] = np.inf
    area = param("m^2", 0, 1000, "area of the surface", typical=0.1)
    affine = False
    strength = "area"
    searched = False

    @abstractmethod
    def coefficient(self, T_a: Array, T_b: Array, u: Inputs) -> Array:
        """h [W/(m² K)] between surface T_a and fluid T_b [°C]."""

    @abstractmethod
    def reynolds(self, T: Array, u: Inputs) -> Array:
        """Reynolds number with the fluid's properties at T [°C]."""

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.area * self.coefficient(T_a, T_b, u) * (T_a - T_b)
        return Q

    def remarks(self, u: Mapping[str, Array]) -> Iterator[str]:
        largest = float(np.max(self.reynolds(USUAL, u)))
        if largest > self.most:
            yield f"Re = {largest:.2g} at 20 degC, and its correlation holds to {self.most:.2g}"


class TurningFilm(MovingFilm):
    """A film on what turns with the spindle."""

    @classmethod
    def candidates(cls, machine: MachineLike) -> Iterator[tuple[str, str]]:
        turns = {*turning(machine)}
        return (pair for pair in super().candidates(machine) if pair[0] in turns)


def join_free_and_forced(forced: Array, free: Array) -> Array:
    """Nu of both at once: Nu³ = Nu_forced³ + Nu_free³ (Incropera & DeWitt, mixed convection; unverified)."""
    return np.asarray((forced**3 + free**3) ** (1 / 3))
