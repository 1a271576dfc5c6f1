from __future__ import annotations

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.base import Inputs, Link


class Conduction(Link, kind="conduction"):
    """Heat through a solid or a joint of constant conductance: Q = G (T_a − T_b).

    G = k A/L through a plane wall (Fourier's law). Valid for constant properties and for wall times L²/(k/ρc) short
    beside the process; else give the wall as a bar with lumps.
    """

    conductance = param("W/K", 0, 1e6, "conductance", typical=20)
    strength = "conductance"
    changed = {"conductance": ("a joint that sits tighter", "a joint that loosened")}
    sentence = "{between[0]} and {between[1]} exchange heat by conduction at {conductance}"

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.conductance * (T_a - T_b)
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, Array]:
        return self.conductance, -self.conductance
