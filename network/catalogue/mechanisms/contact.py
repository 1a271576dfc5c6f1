from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike
from network.catalogue.mechanisms.base import Link, not_below_zero
from network.catalogue.mechanisms.conduction import Conduction
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.number_format import per_kelvin


class Contact(Link, kind="contact"):
    """A joint whose conductance follows its temperature: Q = G₀ max(0, 1 + κ (T_m − T_ref)) (T_a − T_b).

    T_m = (T_a + T_b)/2, T_ref the machine's reference; the conductance never falls below zero. κ > 0: the joint closes
    as the machine warms (a shrink fit inside a part that grows), κ < 0: it opens. Stands for the dependence on contact
    pressure, h ∝ (p/H)^0.95 (Cooper, Mikic & Yovanovich 1969; unverified), where temperature makes the pressure.
    """

    conductance = param("W/K", 0, 1e6, "conductance at the reference temperature", typical=20)
    slope = param("1/K", -0.2, 0.2, "growth of the conductance per kelvin", typical=0.01)
    affine = False
    touches = True
    strength = "slope"
    replaces = {"conduction": {"conductance": "conductance"}}
    derived = ("cold",)
    cold: float
    changed = {"conductance": ("a joint that sits tighter", "a joint that loosened")}
    sentence = "the joint of {between[0]} and {between[1]} changes its {conductance} by {percent} as it warms"

    @property
    def percent(self) -> str:
        """The slope in words."""
        return per_kelvin(float(self.slope))

    def resolve(self, machine: MachineLike) -> Self:
        return self.replaced(cold=machine.reference)

    def _closure(self, T_a: Array, T_b: Array) -> Array:
        closure: Array = 1 + self.slope * ((T_a + T_b) / 2 - self.cold)
        return closure

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.conductance * not_below_zero(self._closure(T_a, T_b)) * (T_a - T_b)
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, Array]:
        closure = self._closure(T_a, T_b)
        G = self.conductance * not_below_zero(closure)
        by_mean = self.conductance * self.slope / 2 * (closure > 0) * (T_a - T_b)
        return by_mean + G, by_mean - G

    @classmethod
    def take_over(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """Nothing more; it stands between parts only."""
        if not isinstance(entry, Conduction) or any(machine.nodes[p.node].is_held for p in entry.places):
            return None
        total = {"conductance": cls.fields["conductance"].write(float(entry.total))}
        return {} if entry.is_given("conductance") else total
