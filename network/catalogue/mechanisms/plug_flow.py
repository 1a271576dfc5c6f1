from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, whole
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike
from network.catalogue.mechanisms.advection import Advection
from network.catalogue.mechanisms.base import Stream
from network.catalogue.mechanisms.mechanism import Inputs

SEARCHED = 24
"""Cells of a leg in a search: with them the arrival of a step is spread over a fifth of the delay."""


class PlugFlow(Stream, kind="plug_flow"):
    """A stream that comes after its delay, hardly mixed on the way: Q = W (T_up − T_down), T_up(t) = T(t − delay).

    As with advection each place counts as well mixed and a loop ends where it began. The delay is a chain of `cells`
    well-mixed cells on each leg between two places, and so an approximation: a step arrives over a standard deviation
    of d/√cells about the delay d of a leg (12 % of it with 64 cells), and a swing of angular frequency ω loses
    (ω d)²/(2 cells) of its height (Levenspiel, Chemical Reaction Engineering, ch. 14, tanks in series): with 64 cells
    0.3 % for a period of ten delays, 27 % for one of a single delay. Heat on the way is accounted for, as in a hose. A
    diagnosis tries it in the place of every stream that the file has without delay.
    """

    capacity_flow = param("W/K", 0, 1e6, "capacity flow ṁ c_p", typical=100)
    delay = param("s", 0, 36_000, "transport time from the first place to the last", positive=True, typical=60)
    cells = whole("well-mixed cells on each leg", 8, 400, default=64)
    strength = "delay"
    replaces = {"advection": {"capacity_flow": "capacity_flow"}}
    changed = {"capacity_flow": ("a stream that grew", "a stream that fell: a filter that clogged, a pump that wears")}
    sentence = "a stream of {capacity_flow} passes {through} within {delay}"

    def heat_flow(self, T_up: Array, T_down: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.capacity_flow * (T_up - T_down)
        return Q

    def transport(self) -> tuple[float, float]:
        return float(self.delay), float(self.capacity_flow)

    @classmethod
    def take_over(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """Fewer cells, so that a search stays fast; of a stream that has a delay already, nothing."""
        is_at_once = isinstance(entry, Advection) and not float(entry.delay)
        return {"cells": SEARCHED} if is_at_once else None
