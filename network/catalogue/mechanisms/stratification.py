from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Inputs


class Stratification(Source, kind="stratification"):
    """Air that is the warmer the higher it lies, beside a part's convection: Q = G γ h into the part.

    The convection reckons with the surroundings where their temperature is recorded; h is the mean height of the
    surface above that thermometer (below it negative), γ the gradient, G the conductance of that convection: together
    G (T_air + γ h − T). Only the product counts. `input` is a position that adds to h, of a head that climbs. Exact
    for air that is layered evenly and a film of constant h A; a bar that stands up takes one for each stretch of it.
    For halls 0.2 to 1 K/m where they are heated from above or hardly stirred, next to nothing under fans (typical
    figures, unverified). Where nothing climbs it is a constant heat, which nothing tells from a source that is always
    on: a diagnosis finds that, and does not look for this one; a second thermometer, a metre higher, does.
    """

    conductance = param("W/K", 0, 1e6, "conductance h A of the convection beside it", typical=10)
    gradient = param("K/m", -50, 50, "how much warmer the air is a metre higher", typical=0.5)
    height = param("m", -100, 100, "mean height of the surface above the thermometer", typical=1.5)
    input = channel(None, "m", "a position that the surface rises with, added to its height")
    strength = "gradient"
    searched = False
    changed = {"gradient": ("air that is layered more", "air that is layered less: a fan that stirs it, a door")}
    sentence = "{into} stands in air that is warmer by {gradient} upwards, {height} above the thermometer"

    def heat(self, u: Inputs, *T: Array) -> Array:
        height = self.height if self.input is None else self.height + u[self.input]
        return np.asarray(self.conductance * self.gradient * height * np.ones_like(u["time"]))
