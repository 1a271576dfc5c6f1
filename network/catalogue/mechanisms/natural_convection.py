from __future__ import annotations

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.base import SurfaceLink, magnitude, raise_to_power
from network.catalogue.mechanisms.mechanism import Inputs


class NaturalConvection(SurfaceLink, kind="natural_convection"):
    """Buoyant convection by a power law: Q = B A |ΔT|^m ΔT, ΔT = T_a − T_b.

    m = 1/4 while the boundary layer is laminar (Ra < 1e9), 1/3 when it is turbulent. In air B is 1.42/L^(1/4)
    W/(m² K^1.25) for a laminar vertical wall of height L in m and 1.31 W/(m² K^1.33) for a turbulent one (Holman, Heat
    Transfer, simplified equations for air; unverified). Up to 20 % below Churchill & Chu.
    """

    coefficient = param("W/(m^2 K^1.25)", 0, 100, "coefficient B", typical=1.5, any_power_of="[temperature]")
    area = param("m^2", 0, 1000, "area", typical=1.0)
    exponent = param("1", 0.1, 1, "exponent m", default=0.25)
    affine = False
    strength = "coefficient"
    sentence = "{between[0]} loses heat to {between[1]} by natural convection, {coefficient} over {area}"

    def _conductance(self, T_a: Array, T_b: Array) -> Array:
        G: Array = self.coefficient * self.area * raise_to_power(magnitude(T_a - T_b), self.exponent)
        return G

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self._conductance(T_a, T_b) * (T_a - T_b)
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, Array]:
        by_a = (1 + self.exponent) * self._conductance(T_a, T_b)
        return by_a, -by_a
