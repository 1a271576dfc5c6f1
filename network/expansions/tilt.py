from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

from network.declare import Advice, Array
from network.expansions.base import AXES, LINEAR_AXES, Expansion, Reading, own_expansion, own_length
from network.fields import param, places
from network.mechanisms.base import Inputs
from network.units import show


class Tilt(Expansion, kind="tilt"):
    """Two supports a distance apart grow differently and tilt what they carry: δ = arm · (g_a − g_b)/distance.

    g = α · length · rise is the growth of a support; α and length are each support's own unless given. Small angles.
    On an angular axis the result is the angle itself and `arm` is left out.
    """

    between = places("the two supports")
    distance = param("m", 0, 100, "distance of the supports", positive=True, typical=0.3)
    arm = param("m", 0, 100, "lever arm to the tool centre point", default=None, typical=0.4)
    length = param("m", 0, 100, "length of each support; default the range's share of its bar", default=None)
    expansion = param("1/K", -1e-4, 2e-3, "coefficient of expansion; default each material's", default=None)
    axes = AXES
    strength = "arm"
    looks_like = ("bending", "stretching")
    derived = ("growth_a", "growth_b")
    growth_a: float | None
    growth_b: float | None
    sentence = "{between[0]} and {between[1]} tilt the head and move the tool centre point along {axis}"

    def resolved(self, machine: Any) -> Self:
        growths = []
        for place in self.between:
            alpha, length = own_expansion(self.expansion, machine, place), own_length(self.length, machine, place)
            growths.append(None if alpha is None or length is None else alpha * length)
        return self.replaced(growth_a=growths[0], growth_b=growths[1])

    def faults(self) -> Iterator[Advice]:
        known = self.__dict__
        if known.get("growth_a", 0.0) is None or known.get("growth_b", 0.0) is None:
            yield "between", "a support has no material or no length of its own", "give `expansion` and `length`"
        if self.axis and (self.arm is None) == (self.axis in LINEAR_AXES):
            right = "give `arm`" if self.arm is None else "drop `arm`: on a, b, c the result is the angle"
            yield "arm", f"on axis {self.axis} the lever arm is {'missing' if self.arm is None else 'of no use'}", right

    def readings(self) -> tuple[Reading, ...]:
        return tuple(Reading(place) for place in self.between)

    def displacement(self, u: Inputs, *readings: Array) -> Array:
        angle = (self.growth_a * readings[0] - self.growth_b * readings[1]) / self.distance
        return self.direction * angle * (self.arm if self.axis in LINEAR_AXES else 1.0)

    def kept_when_merged(self) -> dict[str, Any]:
        """Only where both supports grow alike can numbers stand for two materials and lengths."""
        if self.growth_a == self.growth_b and self.growth_a is not None:
            return {"length": "1 m", "expansion": show(self.growth_a, "1/K", 17)}
        return {}

    @classmethod
    def subjects(cls, machine: Any) -> Iterator[tuple[str, dict[str, Any]]]:
        parts = [n for n, node in machine.nodes.items() if node.is_part and node.expansion is not None]
        for a, b in machine.joined_parts():
            if a in parts and b in parts:
                yield f"{a} {b}", {"between": [a, b], "length": "300 mm", "arm": "400 mm"}
