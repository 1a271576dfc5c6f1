"""Nodes: bars with material and size, plain heat capacities, massless junctions, and held temperatures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Advice, Array, Declared
from network.catalogue.declaration.fields import ParamField, flag, nested, param, whole, word, word_of
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.drift import Drift
from network.catalogue.materials import Material
from network.catalogue.warm_capacity import WarmCapacity
from network.platform.quantities.units import BadNumber
from network.platform.refusal import short
from network.platform.yaml.document import Tree

MOST_LUMPS = 2000
MOST_NODES, MOST_IN_ALL = 3000, 100_000
"""Of a machine. A solution of so many lumps in a subspace takes 2.5 GB; what needs a full matrix stops earlier."""
BISECTIONS, ROUNDING = 60, 4e-16
CAPACITIES = ("heat_capacity", "extra_heat_capacity")
_BAR = ("material", "length", "area")


class HeldField(ParamField):
    """A held temperature: a constant with its unit, or the name of an input channel."""

    def parse(self, tree: Tree) -> Any:
        text = word_of(tree, self.meaning)
        if text[0] in "+-.0123456789" or text.startswith("unknown"):
            return super().parse(tree)
        if text.split()[0].lower() in ("nan", "inf", "infinity"):
            raise BadNumber(f"'{short(text)}' is not a number", f"give {self.meaning}")
        return text

    def write(self, value: Any) -> Any:
        return value if isinstance(value, str) else super().write(value)

    def tell(self, value: Any) -> str:
        return value if isinstance(value, str) else super().tell(value)


class Melting(Declared):
    """A melting range: latent heat taken up between at − over/2 and at + over/2.

    Apparent heat capacity: the heat taken up per kelvin is (L/over)(1 + cos 2π(T − at)/over), which is smooth and sums
    to L. Source: the apparent-heat-capacity method, Voller, Int. J. Numer. Methods Eng. 30 (1990) 875; unverified.
    """

    section = "melts"
    manner = "melts"
    at = param("degC", -50, 1000, "middle of the melting range", typical=28)
    over = param("K", 0, 200, "width of the melting range", positive=True, typical=2)
    latent_heat = param("J", 0, 1e10, "latent heat", positive=True, typical=1e5)

    def compute_latent_heat(self, T: Array) -> Array:
        """Latent heat taken up at T [J]."""
        x = np.clip((T - self.at) / self.over, -0.5, 0.5)
        heat: Array = self.latent_heat * (0.5 + x + np.sin(2 * np.pi * x) / (2 * np.pi))
        return heat

    def apparent_capacity(self, T: Array) -> Array:
        """Derivative of `compute_latent_heat` [J/K]."""
        x = (T - self.at) / self.over
        capacity: Array = self.latent_heat / self.over * (1 + np.cos(2 * np.pi * x)) * (np.abs(x) < 0.5)
        return capacity

    def temperature(self, apparent: Array, capacity: float) -> Array:
        """T from the heat in the part over its heat capacity, T + latent heat(T)/capacity [°C], by Newton's method kept
        between bounds; to rounding."""
        more, begin = self.latent_heat / capacity, self.at - self.over / 2
        low, high = apparent - more, np.asarray(apparent, float)
        T = np.clip(begin + (apparent - begin) * self.over / (self.over + more), low, high)
        T = np.where(high <= begin, high, np.where(low >= begin + self.over, low, T))
        for _ in range(BISECTIONS):
            off = T + self.compute_latent_heat(T) / capacity - apparent
            low, high = np.where(off > 0, low, T), np.where(off > 0, T, high)
            new = T - off / (1 + self.apparent_capacity(T) / capacity)
            new = np.where((new < low) | (new > high), (low + high) / 2, new)
            if np.all(np.abs(new - T) <= ROUNDING * (1 + np.abs(T))):
                return np.asarray(new)
            T = new
        return np.asarray(T)


class Node(Declared):
    """A part of the machine, or its surroundings.

    bar: material + length + area (+ extra_heat_capacity), C = ρ c S L, cut into `lumps` along its length;
    mass: heat_capacity (a material may be named for its expansion); massless: `{}`; held: temperature.
    """

    section = "nodes"
    changed = dict.fromkeys(
        ("heat_capacity", "extra_heat_capacity"),
        (
            "a part that stores more heat: something was mounted or filled",
            "a part that stores less heat: something was taken off, or a level that fell",
        ),
    )
    material = word("the name of a material", default=None)
    length = param("m", 0, 1000, "length", positive=True, default=None)
    area = param("m^2", 0, 1000, "cross-section", positive=True, default=None)
    extra_heat_capacity = param("J/K", 0, 1e12, "heat capacity besides the bar's, spread evenly", default=0)
    lumps = whole("number of lumps along the length", 1, MOST_LUMPS, default=1)
    heat_capacity = param("J/K", 0, 1e12, "heat capacity", positive=True, default=None)
    rotates = flag("whether it turns with the spindle", default=None)
    temperature: Any = HeldField("degC", -100, 1000, "a temperature, or the name of an input", default=None)
    melts: Melting | None = nested("a melting range", lambda: Melting)
    drifts: Drift | None = nested("how surroundings differ from what is recorded or stated", lambda: Drift)
    stuff: Material | None = None

    def resolve(self, machine: MachineLike) -> Self:
        return self.replaced(stuff=machine.material(self.material) if self.material else None)

    def needs(self) -> Mapping[str, str]:
        """The input at which it is held."""
        return {self.temperature: "degC"} if isinstance(self.temperature, str) else {}

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
    def stored(self) -> Melting | WarmCapacity | None:
        """What it stores beside C T: by melting, or because its specific heat changes; None where C is constant."""
        if self.melts is not None or not self.is_bar or self.stuff is None or not self.stuff.specific_heat_slope:
            return self.melts
        return WarmCapacity(float((self.capacity - self.extra_heat_capacity) * self.stuff.specific_heat_slope))

    @property
    def expansion(self) -> float | None:
        return None if self.stuff is None else float(self.stuff.expansion)

    @property
    def conductivity_slope(self) -> float:
        """Relative growth of its conductivity per kelvin, over 20 °C [1/K]."""
        return 0.0 if self.stuff is None else float(self.stuff.conductivity_slope)

    @property
    def bar_conductance(self) -> float:
        """λ S / Δx between neighbouring lumps at 20 °C [W/K]."""
        if self.stuff is None:
            return 0.0
        return float(self.stuff.conductivity * self.area / self.length * self.lumps)

    def faults(self) -> Iterator[Advice]:
        if self.is_held:
            yield from self._faults_of_held()
            return
        bar = [key for key in _BAR if self.__dict__[key] is not None]
        lacking = [key for key in _BAR if key not in bar]
        if self.is_bar and self.heat_capacity is not None:
            yield "heat_capacity", "has heat_capacity beside a bar's size", "use extra_heat_capacity, or drop the area"
        elif bar and lacking and (self.is_bar or self.heat_capacity is None):
            wrong = f"has {' and '.join(bar)} but lacks {' and '.join(lacking)}"
            yield bar[0], wrong, "a bar has material, length and area, a mass has heat_capacity"
            return
        if self.lumps > 1 and not self.is_bar:
            yield "lumps", "has lumps but is no bar", "lumps need material, length and area"
        if self.extra_heat_capacity and not self.is_bar:
            yield "extra_heat_capacity", "has extra_heat_capacity but is no bar", "write heat_capacity"
        if self.melts is not None and not self.is_part:
            yield "melts", "melts but has no heat capacity", "give heat_capacity"
        if self.drifts is not None:
            yield "drifts", "drifts but its temperature is not held", "give `temperature`, or drop `drifts`"

    def _faults_of_held(self) -> Iterator[Advice]:
        others = (name for name, field in self.fields.items() if name not in ("temperature", "rotates", "drifts"))
        besides = [name for name in others if self.__dict__[name] != self.fields[name].initial]
        if besides:
            yield "temperature", f"is held and has {' and '.join(besides)} too", "drop `temperature`, or the rest"
