"""Nodes: bars with material and size, plain heat capacities, massless junctions, and held temperatures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

import numpy as np

from network.declare import Advice, Array, Declared
from network.fields import Field, flag, nested, param, whole, word, word_of
from network.materials import Material
from network.units import BadNumber, Number, in_unit, show, split_number
from network.yamlfile import Tree

MOST_LUMPS = 2000


class HeldField(Field):
    """A held temperature: a constant with its unit, or the name of an input channel."""

    def parse(self, tree: Tree) -> Number | str:
        text = word_of(tree, "a temperature or the name of an input")
        try:
            split_number(text)
        except BadNumber:
            if text[:1].isdigit() or text[:1] in "+-.":
                raise
            if "nan" in text.lower().split() or "inf" in text.lower().split():
                raise BadNumber(f"'{text}' is not a number", "give a temperature or the name of an input") from None
            return text
        return Number(in_unit(text, "degC"))

    def write(self, value: Any) -> Any:
        return value if isinstance(value, str) else show(value.value if isinstance(value, Number) else value, "degC", 17)


class Melting(Declared):
    """A melting range: latent heat taken up between at − over/2 and at + over/2.

    Apparent heat capacity: the heat taken up per kelvin is (L/over)(1 + cos 2π(T − at)/over), which is smooth and sums
    to L. Source: the apparent-heat-capacity method, Voller, Int. J. Numer. Methods Eng. 30 (1990) 875; unverified.
    """

    section = "melts"
    at = param("degC", -50, 1000, "middle of the melting range", typical=28)
    over = param("K", 0, 200, "width of the melting range", positive=True, typical=2)
    latent_heat = param("J", 0, 1e10, "latent heat", positive=True, typical=1e5)

    def absorbed(self, T: Array) -> Array:
        """Latent heat taken up at T [J]."""
        x = np.clip((T - self.at) / self.over, -0.5, 0.5)
        return self.latent_heat * (0.5 + x + np.sin(2 * np.pi * x) / (2 * np.pi))

    def apparent_capacity(self, T: Array) -> Array:
        """Derivative of `absorbed` [J/K]."""
        x = (T - self.at) / self.over
        return self.latent_heat / self.over * (1 + np.cos(2 * np.pi * x)) * (np.abs(x) < 0.5)


class Node(Declared):
    """A part of the machine, or its surroundings.

    bar: material + length + area (+ extra_heat_capacity), C = ρ c S L, cut into `lumps` along its length;
    mass: heat_capacity (a material may be named for its expansion); massless: `{}`; held: temperature.
    """

    section = "nodes"
    material = word("the name of a material", default=None)
    length = param("m", 0, 1000, "length", positive=True, default=None)
    area = param("m^2", 0, 1000, "cross-section", positive=True, default=None)
    extra_heat_capacity = param("J/K", 0, 1e12, "heat capacity besides the bar's, spread evenly", default=0)
    lumps = whole("number of lumps along the length", 1, MOST_LUMPS, default=1)
    heat_capacity = param("J/K", 0, 1e12, "heat capacity", positive=True, default=None)
    rotates = flag("whether it turns with the spindle", default=None)
    temperature: Any = HeldField("a held temperature: a constant or the name of an input", default=None)
    melts: Melting | None = nested("a melting range", lambda: Melting)
    stuff: Material | None = None

    def resolved(self, machine: Any) -> Self:
        return self.replaced(stuff=machine.material(self.material) if self.material else None)

    @property
    def is_held(self) -> bool:
        return self.temperature is not None

    @property
    def is_bar(self) -> bool:
        return self.area is not None

    @property
    def is_massless(self) -> bool:
        return not (self.is_held or self.is_bar or self.heat_capacity is not None)

    @property
    def is_part(self) -> bool:
        """Has a heat capacity."""
        return self.is_bar or self.heat_capacity is not None

    @property
    def capacity(self) -> float:
        """Heat capacity of the whole part [J/K]."""
        if self.is_bar and self.stuff is not None:
            per_volume = self.stuff.density * self.stuff.specific_heat
            return float(per_volume * self.area * self.length + self.extra_heat_capacity)
        return float(self.heat_capacity or 0.0)

    @property
    def expansion(self) -> float | None:
        return None if self.stuff is None else float(self.stuff.expansion)

    @property
    def bar_conductance(self) -> float:
        """λ S / Δx between neighbouring lumps [W/K]."""
        if self.stuff is None:
            return 0.0
        return float(self.stuff.conductivity * self.area / self.length * self.lumps)

    def faults(self) -> Iterator[Advice]:
        bar_needs = {"material": self.material, "length": self.length, "area": self.area}
        lacking = [key for key, value in bar_needs.items() if value is None]
        if self.is_held and (self.is_bar or self.heat_capacity is not None or self.material):
            yield "temperature", "is held and has a heat capacity too", "drop `temperature`, or the rest"
        elif self.area is not None and lacking:
            yield "area", f"is a bar but lacks {' and '.join(lacking)}", "a bar has material, length and area"
        elif self.area is not None and self.heat_capacity is not None:
            yield "heat_capacity", "has heat_capacity beside a bar's size", "use extra_heat_capacity, or drop the area"
        elif self.material and self.length is not None and self.area is None and self.heat_capacity is None:
            yield "length", "is a bar but lacks area", "a bar has material, length and area"
        elif self.material and self.heat_capacity is None and self.area is None and not self.is_held:
            yield "material", "has a material but no size", "give length and area, or heat_capacity"
        if self.lumps > 1 and not self.is_bar:
            yield "lumps", "has lumps but is no bar", "lumps need material, length and area"
        if self.extra_heat_capacity and not self.is_bar:
            yield "extra_heat_capacity", "has extra_heat_capacity but is no bar", "write heat_capacity"
        if self.melts is not None and not self.is_part:
            yield "melts", "melts but has no heat capacity", "give heat_capacity"


