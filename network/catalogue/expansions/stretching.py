from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import Place, along, param, place, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.positions import beyond, clip, list_inputs, metres
from network.catalogue.expansions.base import Expansion, Reading, choose, own_expansion, own_length, steel_unless_known
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.units import show


class Stretching(Expansion, kind="stretching"):
    """A part grows along its axis: ΔL = α L mean(ΔT); with `method: heat`, ΔL = α L E/(ρ c S L), E the heat absorbed.

    Both agree for constant properties, wherever the heat enters: mean(ΔT) = E/(ρ c S L). The heat form integrates heat
    flows and also holds where temperature alone does not tell (melting). Source: eq. 3–5 of the heat-quantity method.

    With `fixed` and `at` the part is held at one point and another counts: ∫ α ΔT dx from the one to the other over
    the lumps in between, negative where `at` comes first. Each is a share of the length, a length, or follows an input
    (`at: position`). So a screw grows from its fixed bearing to the nut, which moves the tool centre point where the
    screw's encoder measures; where a linear scale does, the scale's own growth does instead. Not to be confused with
    `of: part@0.2..0.7`, which also takes a length of its own for the range.
    """

    of = place("the part or range that grows")
    fixed = along("the point where the part is held", default=None)
    at = along("the point whose movement counts", default=None)
    length = param(
        "m", 0, 1000, "length that grows; default the range's share of the bar, and the whole bar's with `fixed`",
        default=None, typical=0.3,
    )  # fmt: skip
    expansion = param("1/K", -1e-4, 2e-3, "expansion; default the material's", default=None, typical=1.1e-5)
    method = word("what the growth is computed from", "temperature", "heat", default="temperature")
    strength = "length"
    derived = ("alpha", "bar", "capacity")
    alpha: Array | None
    bar: Array | None
    capacity: float
    lumps: int = 1
    sentence = "{of} grows over {grows_over} and moves the tool centre point along {way}"

    def resolve(self, machine: MachineLike) -> Self:
        node = machine.nodes[self.of.node]
        alpha, bar = own_expansion(machine, self.of), own_length(machine, self.of)
        share = (self.of.share or 1 / node.lumps) if self.fixed is None else 1 / node.lumps
        return self.replaced(alpha=alpha, bar=bar, capacity=node.capacity * share, lumps=node.lumps)

    def needs(self) -> Mapping[str, str]:
        return {**super().needs(), **list_inputs(self.fixed, self.at)}

    @property
    def grown(self) -> Array:
        """The length that grows [m]."""
        return choose(self.length, self.bar)

    @property
    def grows_over(self) -> str:
        length = show(float(self.grown), "mm")
        if self.fixed is None:
            return length
        fixed, at = (self.fields[name].tell(getattr(self, name)) for name in ("fixed", "at"))
        return f"{length} (held at {fixed}, as far as {at})"

    def faults(self) -> Iterator[Advice]:
        points = [name for name in ("fixed", "at") if self.is_given(name)]
        if len(points) == 1:
            right = "give `fixed`, where the part is held, and `at`, the point whose movement counts"
            yield points[0], f"has `{points[0]}` alone", right
        if points and self.of.share < 1:
            yield "of", f"{self.of} is a range beside `{points[0]}`", f"write `of: {self.of.node}`"
        known = {"alpha": self.expansion, "bar": self.length}
        lacking = [own for own, given in known.items() if given is None and self.__dict__.get(own, 0.0) is None]
        if "alpha" in lacking:
            yield "of", f"{self.of.node} names no material", "give `expansion`, as in 1.1e-5 1/K"
        if "bar" in lacking:
            yield "of", f"the length of {self.of} is not known", "give `length`"
        elif "bar" in self.__dict__:
            for name in points:
                for text in beyond(getattr(self, name), {}, self.grown):
                    yield name, f"{name}: {text} of {self.of.node}", "name a place on it"

    def remarks(self, u: Mapping[str, Array]) -> Iterator[str]:
        for text in (*beyond(self.fixed, u, self.grown), *beyond(self.at, u, self.grown)):
            yield f"{text} of {self.of.node}; it counts as its end"

    def readings(self) -> tuple[Reading, ...]:
        ends = [i / self.lumps for i in range(self.lumps + 1)]
        pieces = [self.of] if self.fixed is None else [Place(self.of.node, a, b) for a, b in pairwise(ends)]
        return tuple(Reading(piece, "heat" if self.method == "heat" else "mean") for piece in pieces)

    def movement(self, u: Inputs, *readings: Array) -> Array:
        rises = [reading / self.capacity if self.method == "heat" else reading for reading in readings]
        stretched = self.grown * rises[0] if self.fixed is None else self._between(u, rises)
        d: Array = self.direction * choose(self.expansion, self.alpha) * stretched
        return d

    def _between(self, u: Inputs, rises: Sequence[Array]) -> Array:
        """∫ΔT dx from `fixed` to `at` [K m] over pieces of equal length, one for each rise."""
        fixed, at = (metres(where, u, self.grown) for where in (self.fixed, self.at))
        edges = [self.grown * i / len(rises) for i in range(len(rises) + 1)]
        pieces = zip(rises, pairwise(edges), strict=True)
        return np.asarray(sum(rise * (clip(at, *ends) - clip(fixed, *ends)) for rise, ends in pieces))

    def keep_in_merge(self) -> dict[str, Any]:
        alpha = float(choose(self.expansion, self.alpha))
        length = show(float(self.grown), "m", 17)
        return {"length": length, "expansion": show(alpha, "1/K", 17), "method": "temperature"}

    @classmethod
    def subjects(cls, machine: MachineLike, axis: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """Every part, over its length or a typical one."""
        for name, node in machine.nodes.items():
            if node.is_part:
                length = node.length if node.length is not None else cls.params()["length"].proposal()
                yield name, {"of": name, "length": show(float(length), "mm", 17), **steel_unless_known(machine, name)}
