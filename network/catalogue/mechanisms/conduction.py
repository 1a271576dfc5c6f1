from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.base import Link
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.units import show


class Conduction(Link, kind="conduction"):
    """Heat through a solid or a joint of constant conductance: Q = G (T_a − T_b).

    G is given, or k A/L through a plane wall (Fourier's law). Valid for constant properties and for wall times
    L²/(k/ρc) short beside the process; else give the wall as a bar with lumps.
    """

    conductance = param("W/K", 0, 1e6, "conductance", typical=20, default=None)
    conductivity = param("W/(m K)", 0, 5000, "conductivity of the wall", typical=48, default=None)
    area = param("m^2", 0, 1000, "cross-section of the wall", typical=0.01, default=None)
    length = param("m", 0, 100, "way through the wall", positive=True, typical=0.03, default=None)
    one_of = (("conductance",), ("conductivity", "area", "length"))
    touches = True
    strength = "conductance"
    changed = {"conductance": ("a joint that sits tighter", "a joint that loosened")}
    sentence = "{between[0]} and {between[1]} exchange heat by conduction at {size}"

    @property
    def total(self) -> Array:
        """G [W/K]."""
        if self.conductance is not None:
            return self.conductance
        return np.asarray(self.conductivity * self.area / self.length)

    @property
    def size(self) -> str:
        return show(float(f"{float(self.total):.4g}"), "W/K")

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.total * (T_a - T_b)
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, Array]:
        return self.total, -self.total
