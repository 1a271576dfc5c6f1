from __future__ import annotations

from network.declare import Array
from network.fields import param
from network.mechanisms.base import Inputs, Stream


class Advection(Stream, kind="advection"):
    """A stream of fluid that carries heat one way: Q = W (T_up − T_down), W = ṁ c_p, upwind.

    A place with several lumps is passed lump by lump along the part. A loop ends with the place it began with. With a
    `delay` the fluid on the way is a chain of well-mixed cells: cells of equal volume, `CELLS` for each leg, whose step
    response is that of a pipe with axial mixing (Levenspiel, Chemical Reaction Engineering, tanks in series).
    """

    capacity_flow = param("W/K", 0, 1e6, "capacity flow ṁ c_p", typical=100)
    delay = param("s", 0, 36_000, "transport time from the first place to the last", default=0)
    strength = "capacity_flow"
    looks_like = ("convection", "sensor_lag")
    sentence = "a stream of {capacity_flow} passes {through}"

    def heat_flow(self, T_up: Array, T_down: Array, u: Inputs) -> Array:
        return self.capacity_flow * (T_up - T_down)

    def transport(self) -> tuple[float, float]:
        return float(self.delay), float(self.capacity_flow)
