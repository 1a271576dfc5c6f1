from __future__ import annotations

from network.declare import Array
from network.fields import param
from network.mechanisms.base import Inputs, SurfaceLink, magnitude


class NaturalConvection(SurfaceLink, kind="natural_convection"):
    """Buoyant convection by a power law: Q = B A |ΔT|^m ΔT, ΔT = T_a − T_b.

    m = 0.25 while the boundary layer is laminar, 0.33 when turbulent; B is about 1.4 (laminar, per m^0.25 of height)
    to 1.3 W/(m² K^1.33) for a vertical wall in air. Source: Holman, Heat Transfer, table 7-2; unverified edition.
    """

    coefficient = param(
        "W/(m^2 K^1.25)", 0, 100, "coefficient B", typical=1.5, any_power_of="[temperature]"
    )
    area = param("m^2", 0, 1000, "area", typical=1.0)
    exponent = param("1", 0, 1, "exponent m", default=0.25)
    affine = False
    strength = "coefficient"
    looks_like = ("convection", "radiation")
    sentence = "{between[0]} loses heat to {between[1]} by natural convection, {coefficient} over {area}"

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs) -> Array:
        return self.coefficient * self.area * magnitude(T_a - T_b) ** self.exponent * (T_a - T_b)

    def slopes(self, T_a: Array, T_b: Array, u: Inputs) -> tuple[Array, Array]:
        by_a = (1 + self.exponent) * self.coefficient * self.area * magnitude(T_a - T_b) ** self.exponent
        return by_a, -by_a
