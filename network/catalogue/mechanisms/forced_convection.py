from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike
from network.catalogue.mechanisms.base import SurfaceLink, raise_to_power
from network.catalogue.mechanisms.convection import Convection
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.typical_values import usual_input, usual_speed


class ForcedConvection(SurfaceLink, kind="forced_convection"):
    """Convection that grows with speed: Q = G (1 + gain (|n|/n_ref)^p) (T_a − T_b); at rest G, the still-air value.

    p is 0.5 over a laminar and 0.8 over a turbulent boundary layer, 2/3 around a rotating cylinder, where Nu =
    0.133 Re^(2/3) Pr^(1/3) (Becker 1963, as in a problem of Incropera & DeWitt; unverified). A fan on the shaft counts
    too. With constant speed it cannot be told from a larger convection: it takes running and standing.
    """

    conductance = param("W/K", 0, 1e6, "conductance at rest", typical=5)
    gain = param("1", 0, 100, "how much the conductance gains at the reference speed", typical=2)
    exponent = param("1", 0.2, 1.5, "exponent over speed", default=0.8)
    reference_speed = param("rpm", 0, 300_000, "speed at which the gain is given", positive=True, typical=10_000)
    input = channel("speed", "rpm")
    strength = "gain"
    shapes = ("exponent",)
    replaces = {"convection": {"conductance": "conductance"}}
    sentence = "{between[0]} loses {conductance} to {between[1]} at rest, {times} times that at {reference_speed}"

    @property
    def times(self) -> str:
        """Its conductance at the reference speed, over that at rest."""
        return f"{1 + float(self.gain):.2g}"

    def _conductance(self, u: Inputs) -> Array:
        speed = np.abs(u[self.input]) / self.reference_speed
        G: Array = self.conductance * (1 + self.gain * raise_to_power(speed, self.exponent))
        return G

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self._conductance(u) * (T_a - T_b)
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, Array]:
        G = self._conductance(u)
        return G, -G

    @classmethod
    def take_over(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """Of a constant coefficient: its conductance, whatever form it has."""
        if not isinstance(entry, Convection) or (total := entry.total) is None:
            return None
        given = {**usual_speed(machine), **usual_input(cls, machine)}
        return {"conductance": cls.fields["conductance"].write(total), **given}
