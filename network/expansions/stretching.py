from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

from network.declare import Advice, Array
from network.expansions.base import Expansion, Reading, own_expansion, own_length
from network.fields import param, place, word
from network.mechanisms.base import Inputs
from network.units import show


class Stretching(Expansion, kind="stretching"):
    """A part grows along its axis: ΔL = α L mean(ΔT); with `method: heat`, ΔL = α E/(ρ c S), E the heat absorbed.

    Both agree for constant properties, wherever the heat enters: mean(ΔT) = E/(ρ c S L). The heat form integrates heat
    flows and also holds where temperature alone does not tell (melting). Source: eq. 3–5 of the heat-quantity method.
    """

    of = place("the part or range that grows")
    length = param("m", 0, 1000, "length that grows; default the range's share of the bar", default=None)
    expansion = param("1/K", -1e-4, 2e-3, "coefficient of expansion; default the material's", default=None)
    method = word("what the growth is computed from", "temperature", "heat", default="temperature")
    strength = "length"
    looks_like = ("bending", "tilt")
    derived = ("alpha", "grown", "capacity")
    alpha: float
    grown: float
    capacity: float
    sentence = "{of} grows over {length} and moves the tool centre point along {axis}"

    def resolved(self, machine: Any) -> Self:
        node = machine.nodes[self.of.node]
        return self.replaced(
            alpha=own_expansion(self.expansion, machine, self.of),
            grown=own_length(self.length, machine, self.of),
            capacity=node.capacity * (self.of.share or 1 / node.lumps),
        )

    def faults(self) -> Iterator[Advice]:
        if self.__dict__.get("alpha", 0.0) is None:
            yield "of", f"{self.of.node} names no material", "give `expansion`, as in 1.1e-5 1/K"
        if self.__dict__.get("grown", 0.0) is None:
            yield "of", f"the length of {self.of} is not known", "give `length`"

    def readings(self) -> tuple[Reading, ...]:
        return (Reading(self.of, "heat" if self.method == "heat" else "mean"),)

    def displacement(self, u: Inputs, *readings: Array) -> Array:
        rise = readings[0] / self.capacity if self.method == "heat" else readings[0]
        return self.direction * self.alpha * self.grown * rise

    def kept_when_merged(self) -> dict[str, Any]:
        return {"length": show(self.grown, "m", 17), "expansion": show(self.alpha, "1/K", 17), "method": "temperature"}

    @classmethod
    def subjects(cls, machine: Any) -> Iterator[tuple[str, dict[str, Any]]]:
        for name, node in machine.nodes.items():
            if node.is_part and node.expansion is not None:
                yield name, {"of": name} if node.length is not None else {"of": name, "length": "300 mm"}
