from __future__ import annotations

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, whole
from network.catalogue.mechanisms.base import Inputs, Stream


class PlugFlow(Stream, kind="plug_flow"):
    """A stream that comes after its delay, hardly mixed on the way: Q = W (T_up − T_down), T_up(t) = T(t − delay).

    As with advection each place counts as well mixed and a loop ends where it began. The delay is a chain of `cells`
    well-mixed cells on each leg between two places, and so an approximation: a step arrives over a standard deviation
    of d/√cells about the delay d of a leg (12 % of it with 64 cells), and a swing of angular frequency ω loses
    (ω d)²/(2 cells) of its height (Levenspiel, Chemical Reaction Engineering, ch. 14, tanks in series): with 64 cells
    0.3 % for a period of ten delays, 27 % for one of a single delay. Heat on the way is accounted for, as in a hose.
    Not looked for by a diagnosis, which tells how late a stream comes as the `delay` of advection.
    """

    capacity_flow = param("W/K", 0, 1e6, "capacity flow ṁ c_p", typical=100)
    delay = param("s", 0, 36_000, "transport time from the first place to the last", positive=True, typical=60)
    cells = whole("well-mixed cells on each leg", 8, 400, default=64)
    strength = "capacity_flow"
    shapes = ("delay",)
    changed = {"capacity_flow": ("a stream that grew", "a stream that fell: a filter that clogged, a pump that wears")}
    sentence = "a stream of {capacity_flow} passes {through} within {delay}"

    def heat_flow(self, T_up: Array, T_down: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.capacity_flow * (T_up - T_down)
        return Q

    def transport(self) -> tuple[float, float]:
        return float(self.delay), float(self.capacity_flow)

    @classmethod
    def is_searched(cls) -> bool:
        return False
