"""What a part stores beside C T because its specific heat changes with temperature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array

USUAL = 20.0
"""°C: where a material's properties hold."""


@dataclass(frozen=True)
class WarmCapacity:
    """C(T) = C (1 + b (T − 20 °C)) of a part: it stores C b (T − 20 °C)²/2 beside C T. growth: C b [J/K²].

    The same questions as `Melting` answers, so that the engine asks both alike.
    """

    growth: float
    manner = "changes its heat capacity as it warms"

    def compute_latent_heat(self, T: Array) -> Array:
        """What it stores beside C T [J]."""
        return np.asarray(self.growth * (T - USUAL) ** 2 / 2)

    def apparent_capacity(self, T: Array) -> Array:
        """Derivative of `compute_latent_heat` [J/K]."""
        return np.asarray(self.growth * (T - USUAL))

    def temperature(self, apparent: Array, capacity: float) -> Array:
        """T from the heat in the part over its heat capacity: x + (C b/C) x²/2 = apparent − 20, x = T − 20."""
        y, bend = apparent - USUAL, self.growth / capacity
        return np.asarray(USUAL + 2 * y / (1 + np.sqrt(np.maximum(1 + 2 * bend * y, 0.0))))
