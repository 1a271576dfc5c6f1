from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import set_in_each
from network.catalogue.mechanisms.base import Inputs, Source
from network.catalogue.typical_values import usual_surroundings


class Stratification(Source, kind="stratification"):
    """Air that is the warmer the higher it lies: Q = G (T_air + γ h − T_surface) into the part.

    Stands in the place of the part's convection. T_air is the surroundings' temperature where it is recorded, h the
    mean height of the surface above that thermometer (below it negative), γ the gradient; `input` is a position that
    adds to h, of a head that climbs. Exact for air that is layered evenly and a film of constant h A; where the part
    is a bar that stands up, one for each stretch of it (`surface: column@0.5..1`). For halls 0.2 to 1 K/m while heated
    from above or hardly stirred, next to nothing under fans (typical figures, unverified), γ constant over the run.
    At rest in height its share is a constant heat of G γ h, which nothing tells from a source that is always on: a
    diagnosis finds that, and does not look for this one; a second thermometer, one metre higher, does.
    """

    surface = place("the part, or the stretch of it, that the air passes")
    air = place("the surroundings, where their temperature is recorded")
    conductance = param("W/K", 0, 1e6, "conductance h A of the surface", typical=10)
    gradient = param("K/m", -50, 50, "how much warmer the air is a metre higher", typical=0.5)
    height = param("m", -100, 100, "mean height of the surface above the thermometer", typical=1.5)
    input = channel(None, "m", "a position that the surface rises with, added to its height")
    strength = "conductance"
    shapes = ("gradient",)
    changed = {"conductance": ("a surface that is cooled better: more air passes it",
                               "a surface that is cooled worse: a cover on it, or air that stands")}  # fmt: skip
    sentence = "{surface} exchanges {conductance} with {air}, which is warmer by {gradient} upwards, at {height}"

    def heat(self, u: Inputs, *T: Array) -> Array:
        T_surface, T_air = T
        height = self.height if self.input is None else self.height + u[self.input]
        return np.asarray(self.conductance * (T_air + self.gradient * height - T_surface))

    @classmethod
    def is_searched(cls) -> bool:
        return False

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """On every part, in what most links lead to."""
        air = usual_surroundings(machine)
        if air is not None:
            yield from set_in_each(super().besides(machine), air=air)
