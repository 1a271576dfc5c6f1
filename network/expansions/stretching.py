from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

from network.declare import Advice, Array
from network.expansions.base import Expansion, Reading, chosen, own_expansion, own_length, steel_unless_known
from network.fields import param, place, word
from network.mechanisms.base import Inputs
from network.units import show


class Stretching(Expansion, kind="stretching"):
    """A part grows along its axis: ΔL = α L mean(ΔT); with `method: heat`, ΔL = α L E/(ρ c S L), E the heat absorbed.

    Both agree for constant properties, wherever the heat enters: mean(ΔT) = E/(ρ c S L). The heat form integrates heat
    flows and also holds where temperature alone does not tell (melting). Source: eq. 3–5 of the heat-quantity method.
    """

    of = place("the part or range that grows")
    length = param("m", 0, 1000, "length that grows; default the range's share of the bar", default=None, typical=0.3)
    expansion = param("1/K", -1e-4, 2e-3, "expansion; default the material\'s", default=None, typical=1.1e-5)
    method = word("what the growth is computed from", "temperature", "heat", default="temperature")
    strength = "length"
    looks_like = ("bending", "tilt")
    derived = ("alpha", "bar", "capacity")
    alpha: Array | None
    bar: Array | None
    capacity: float
    sentence = "{of} grows over {grows_over} and moves the tool centre point along {axis}"

    def resolved(self, machine: Any) -> Self:
        node = machine.nodes[self.of.node]
        alpha, bar = own_expansion(machine, self.of), own_length(machine, self.of)
        return self.replaced(alpha=alpha, bar=bar, capacity=node.capacity * (self.of.share or 1 / node.lumps))

    @property
    def grown(self) -> Array:
        """The length that grows [m]."""
        return chosen(self.length, self.bar)

    @property
    def grows_over(self) -> str:
        return show(float(self.grown), "mm")

    def faults(self) -> Iterator[Advice]:
        known = {"alpha": self.expansion, "bar": self.length}
        lacking = [own for own, given in known.items() if given is None and self.__dict__.get(own, 0.0) is None]
        if "alpha" in lacking:
            yield "of", f"{self.of.node} names no material", "give `expansion`, as in 1.1e-5 1/K"
        if "bar" in lacking:
            yield "of", f"the length of {self.of} is not known", "give `length`"

    def readings(self) -> tuple[Reading, ...]:
        return (Reading(self.of, "heat" if self.method == "heat" else "mean"),)

    def movement(self, u: Inputs, *readings: Array) -> Array:
        rise = readings[0] / self.capacity if self.method == "heat" else readings[0]
        d: Array = self.direction * chosen(self.expansion, self.alpha) * self.grown * rise
        return d

    def kept_when_merged(self) -> dict[str, Any]:
        alpha = float(chosen(self.expansion, self.alpha))
        length = show(float(self.grown), "m", 17)
        return {"length": length, "expansion": show(alpha, "1/K", 17), "method": "temperature"}

    @classmethod
    def subjects(cls, machine: Any, axis: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """Every part, over its length or a typical one."""
        for name, node in machine.nodes.items():
            if node.is_part:
                length = node.length if node.length is not None else cls.params()["length"].proposal()
                yield name, {"of": name, "length": show(float(length), "mm", 17), **steel_unless_known(machine, name)}
