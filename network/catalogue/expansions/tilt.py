from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import param, places
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.expansions.base import (
    AXES,
    LINEAR_AXES,
    Expansion,
    Reading,
    choose,
    lie_in_one_lump,
    own_expansion,
    own_length,
    steel_unless_known,
    tell_one_lump,
)
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.units import show


class Tilt(Expansion, kind="tilt"):
    """Two supports a distance apart grow differently and tilt what they carry: δ = arm · (g_a − g_b)/distance.

    g = α · length · rise is the growth of a support; α and length are each support's own unless given. Small angles:
    below 1 mrad the error is under a millionth. On an angular axis the result is the angle and `arm` is left out.
    """

    between = places("the two supports")
    distance = param("m", 0, 100, "distance of the supports", positive=True, typical=0.3)
    arm = param("m", 0, 100, "lever arm to the tool centre point", default=None, typical=0.4)
    length = param("m", 0, 100, "length of each support; default the range's share of its bar", default=None)
    expansion = param("1/K", -1e-4, 2e-3, "expansion; default each material's", default=None, typical=1.1e-5)
    axes = AXES
    strength = "length"
    derived = ("alpha_a", "alpha_b", "length_a", "length_b")
    alpha_a: Array | None
    alpha_b: Array | None
    length_a: Array | None
    length_b: Array | None
    lumps: int = 2
    sentence = "{between[0]} grows more than {between[1]}: the tilt moves the tool centre point along {way}"

    def resolve(self, machine: MachineLike) -> Self:
        a, b = self.between
        return self.replaced(
            alpha_a=own_expansion(machine, a), alpha_b=own_expansion(machine, b),
            length_a=own_length(machine, a), length_b=own_length(machine, b),
            lumps=machine.nodes[a.node].lumps,
        )  # fmt: skip

    def faults(self) -> Iterator[Advice]:
        known = self.__dict__
        alphas, lengths = ([known.get(f"{what}_{side}", 0.0) for side in "ab"] for what in ("alpha", "length"))
        if self.expansion is None and None in alphas:
            yield "between", "a support names no material", "give `expansion`, as in 1.1e-5 1/K"
        if self.length is None and None in lengths:
            yield "between", "the length of a support is not known", "give `length`"
        if self.axis and (self.arm is None) == (self.axis in LINEAR_AXES):
            right = "give `arm`" if self.arm is None else "drop `arm`: on a, b, c the result is the angle"
            yield "arm", f"on axis {self.axis} the lever arm is {'missing' if self.arm is None else 'of no use'}", right

    def doubts(self) -> Iterator[Advice]:
        if [*self.faults()] or not lie_in_one_lump(self.between, self.lumps):
            return
        g_a, g_b = self.growths
        if np.all(g_a == g_b):
            yield "between", *tell_one_lump(self.between[0], self.lumps)

    def readings(self) -> tuple[Reading, ...]:
        return tuple(Reading(place) for place in self.between)

    @property
    def growths(self) -> tuple[Array, Array]:
        """Growth of each support for each kelvin [m/K]."""
        g_a: Array = choose(self.expansion, self.alpha_a) * choose(self.length, self.length_a)
        g_b: Array = choose(self.expansion, self.alpha_b) * choose(self.length, self.length_b)
        return g_a, g_b

    def movement(self, u: Inputs, *readings: Array) -> Array:
        g_a, g_b = self.growths
        angle = (g_a * readings[0] - g_b * readings[1]) / self.distance
        d: Array = self.direction * angle * (self.arm if self.axis in LINEAR_AXES else 1.0)
        return d

    def keep_in_merge(self) -> dict[str, Any]:
        """Only where both supports grow alike can numbers stand for two materials and lengths."""
        g_a, g_b = map(float, self.growths)
        return {"length": "1 m", "expansion": show(g_a, "1/K", 17)} if g_a == g_b else {}

    @classmethod
    def subjects(cls, machine: MachineLike, axis: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """Any two parts, as supports of a typical length: what carries something need not touch."""
        parts = [name for name, node in machine.nodes.items() if node.is_part]
        for a, b in combinations(parts, 2):
            arm = {"arm": "400 mm"} if axis in LINEAR_AXES else {}
            yield f"{a} {b}", {"between": [a, b], "length": "300 mm", **arm, **steel_unless_known(machine, a, b)}
