from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import param, word
from network.catalogue.fluids import FLUIDS
from network.catalogue.mechanisms.base import Link
from network.catalogue.mechanisms.film import USUAL
from network.catalogue.mechanisms.mechanism import Inputs

LEAST, MOST = 1e-6, 2.3e-2
"""P/H between which the correlation was measured."""


class PressedJoint(Link, kind="pressed_joint"):
    """A dry joint by its surfaces: Q = A (1.25 k (m/σ) (P/H)^0.95 + k_f/Y) (T_a − T_b), Y = 1.53 σ (P/H)^−0.097.

    Spots that touch (Cooper, Mikic & Yovanovich, Int. J. Heat Mass Transfer 12 (1969) 279, with Yovanovich's 1.25), and
    the fluid between them at 20 °C, its mean free path left out. k is the harmonic mean of both solids, 2 k₁k₂/(k₁ +
    k₂), σ = √(σ₁² + σ₂²) the rms roughness, m the slope of its asperities, by default 0.125 (σ/µm)^0.402 (unverified),
    H the hardness of the softer one. For P/H from 1e-6 to 0.023, flat faces; waviness and mortared or painted joints
    make it less. Not looked for by a diagnosis: conduction stands for it, and contact for a pressure that changes.
    """

    area = param("m^2", 0, 1000, "area of the joint", typical=0.005)
    pressure = param("MPa", 0, 5000, "mean contact pressure: bolt forces over the area", positive=True, typical=2)
    roughness = param("um", 0, 1000, "rms roughness of both faces together", positive=True, typical=3)
    hardness = param("GPa", 0, 100, "hardness of the softer face; HB 180 is some 1.8 GPa", positive=True, typical=2)
    conductivity = param(
        "W/(m K)", 0, 5000, "harmonic mean of both; default steel on cast iron", positive=True, default=49
    )
    asperity_slope = param("1", 0, 2, "mean slope of the asperities", positive=True, default=None, typical=0.15)
    fluid = word("what fills the gaps", *FLUIDS, default="air")
    touches = True
    strength = "area"
    searched = False
    sentence = "{between[0]} and {between[1]} are pressed together with {pressure} over {area}"

    @property
    def coefficient(self) -> Array:
        """h of the joint [W/(m² K)]."""
        pressed = self.pressure / self.hardness
        usual = 0.125 * (self.roughness * 1e6) ** 0.402
        slope = usual if self.asperity_slope is None else self.asperity_slope
        spots = 1.25 * self.conductivity * slope / self.roughness * pressed**0.95
        return np.asarray(spots + FLUIDS[self.fluid].conductivity(USUAL) / (1.53 * self.roughness * pressed**-0.097))

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.area * self.coefficient * (T_a - T_b)
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, Array]:
        G = np.asarray(self.area * self.coefficient)
        return G, -G

    def doubts(self) -> Iterator[Advice]:
        pressed = float(self.pressure / self.hardness)
        if not LEAST <= pressed <= MOST:
            right = f"the correlation holds for {LEAST:.0e} to {MOST:.1e}"
            yield "pressure", f"is {pressed:.1e} of the hardness", right
