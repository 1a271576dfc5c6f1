from __future__ import annotations

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.mechanisms.base import Stream
from network.catalogue.mechanisms.mechanism import Inputs


class Advection(Stream, kind="advection"):
    """A stream of fluid that carries heat one way: Q = W (T_up − T_down), W = ṁ c_p, upwind.

    Each place counts as well mixed; a part with several lumps is passed lump by lump along its length. A loop ends with
    the place it began with. With a `delay` the fluid on the way is a chain of equal, well-mixed cells (tanks in series:
    Levenspiel, Chemical Reaction Engineering, ch. 14): its step response comes after the delay on average, with a
    standard deviation of delay/√cells.
    """

    capacity_flow = param("W/K", 0, 1e6, "capacity flow ṁ c_p", typical=100)
    delay = param("s", 0, 36_000, "transport time from the first place to the last", default=0)
    strength = "capacity_flow"
    changed = {"capacity_flow": ("a stream that grew", "a stream that fell: a filter that clogged, a pump that wears")}
    sentence = "a stream of {capacity_flow} passes {through}"

    def heat_flow(self, T_up: Array, T_down: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.capacity_flow * (T_up - T_down)
        return Q

    def transport(self) -> tuple[float, float]:
        return float(self.delay), float(self.capacity_flow)
