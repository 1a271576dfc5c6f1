from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import Place, param, place, places, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.expansions.base import (
    AXES,
    LINEAR_AXES,
    Expansion,
    Reading,
    choose,
    lie_in_one_lump,
    neighbours,
    own_expansion,
    steel_unless_known,
    tell_one_lump,
)
from network.catalogue.expansions.stretching import Stretching
from network.catalogue.mechanisms.base import Link
from network.catalogue.mechanisms.mechanism import Inputs


class Bending(Expansion, kind="bending"):
    """A part heated on one face bends: θ = α L s / 2, ΔH = (L/2) tan(θ/2); θ is half the angle of the arc.

    s is the gradient of the rise across the height [K/m]: its first moment Σ ΔT y/Σ y² over the lumps of `of` (a bar
    whose axis is the height), or (T_top − T_bottom)/distance of two places. `method: paper` is eq. 7–9 of the
    heat-quantity method from heat, θ = α L E/(ρ c S H²), S the bar's section: the same for a linear profile with the
    far face at reference. On an angular axis the result is θ, the slope at the end. Positive s lifts the middle
    (heated top: convex). Free bending of a slender part: no restraint, plane sections.
    """

    of = place("a bar whose axis is the height", default=None)
    between = places("top and bottom", 2, default=None)
    distance = param("m", 0, 100, "distance of top and bottom", positive=True, default=None, typical=0.2)
    length = param("m", 0, 1000, "length of the part that bends", typical=1.0)
    expansion = param("1/K", -1e-4, 2e-3, "expansion; default the material's", default=None, typical=1.1e-5)
    method = word("first moment of the profile, or the heat absorbed", "moment", "paper", default="moment")
    one_of = (("between", "distance"), ("of",))
    axes = AXES
    strength = "length"
    derived = ("alpha", "height", "capacity")
    alpha: Array | None
    height: Array | None
    capacity: float
    lumps: int = 2
    sentence = "{host} bends over {length} and moves the tool centre point along {way}"

    @property
    def host(self) -> Place:
        return self.of if self.of is not None else self.between[0]

    def resolve(self, machine: MachineLike) -> Self:
        node = machine.nodes[self.host.node]
        height = float(node.length) * self.host.share if node.length is not None else None
        alpha = own_expansion(machine, self.host)
        return self.replaced(alpha=alpha, height=height, capacity=node.capacity * self.host.share, lumps=node.lumps)

    def faults(self) -> Iterator[Advice]:
        if self.of is not None and self.of.share == 0:
            yield "of", f"{self.of} is a point", "a bar bends over a range, as in table@0..1"
        if self.of is None and self.method == "paper":
            yield "method", "`method: paper` needs a bar's heat", "use `of: bar`, or drop the method"
        if self.expansion is None and self.__dict__.get("alpha", 0.0) is None:
            yield "length", f"{self.host.node} names no material", "give `expansion`, as in 1.1e-5 1/K"
        if self.of is not None and self.__dict__.get("height", 0.0) is None:
            yield "of", f"{self.of.node} has no length to bend over", "use a bar, or `between` with `distance`"

    def doubts(self) -> Iterator[Advice]:
        if self.method != "paper" and lie_in_one_lump((self.of,) if self.of is not None else self.between, self.lumps):
            yield "of" if self.of is not None else "between", *tell_one_lump(self.host, self.lumps)

    def readings(self) -> tuple[Reading, ...]:
        if self.of is None:
            return tuple(Reading(place) for place in self.between)
        return (Reading(self.of, "heat" if self.method == "paper" else "gradient"),)

    def movement(self, u: Inputs, *readings: Array) -> Array:
        theta = choose(self.expansion, self.alpha) * self.length * self._curvature_per_alpha(*readings) / 2
        sagitta = self.length / 2 * np.tan(theta / 2)
        d: Array = self.direction * (sagitta if self.axis in LINEAR_AXES else theta)
        return d

    def _curvature_per_alpha(self, *readings: Array) -> Array:
        """s [K/m]."""
        if self.method == "paper":
            return np.asarray(2 * readings[0] / (self.capacity * choose(self.height, None)))
        return readings[0] if self.of is not None else np.asarray((readings[0] - readings[1]) / self.distance)

    @classmethod
    def subjects(cls, machine: MachineLike, axis: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """Parts that are joined: one may be the warm face of what the other belongs to; and bars cut along their axis,
        which may be the height where nothing moves or grows along it."""
        for a, b in neighbours(machine):
            yield f"{a} {b}", {"between": [a, b], **steel_unless_known(machine, a)}
        lengthwise = {bar.node for _, bar in Link.list_moving(machine)}
        lengthwise |= {e.of.node for own in machine.tcp.values() for e in own.values() if isinstance(e, Stretching)}
        for name, node in machine.nodes.items():
            if node.is_part and node.length is not None and node.lumps > 1 and name not in lengthwise:
                yield name, {"of": name, **steel_unless_known(machine, name)}
