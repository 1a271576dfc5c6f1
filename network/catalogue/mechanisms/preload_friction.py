from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import Place, param, place
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike
from network.catalogue.mechanisms.base import not_below_zero
from network.catalogue.mechanisms.bearing_friction import BearingFriction
from network.catalogue.mechanisms.friction import Friction, turning
from network.catalogue.mechanisms.mechanism import Inputs
from network.platform.quantities.number_format import per_kelvin


class PreloadFriction(Friction, kind="preload_friction"):
    """Friction of a bearing whose preload grows with its rings' difference: q = |ω| M max(0, 1 + κ (T_i − T_o)).

    A warmer inner ring grows into the outer one: κ > 0. As the heat feeds the difference, it runs away once
    |ω| M κ exceeds what the bearing conducts; an arrangement that relaxes as it warms has κ < 0. Linear in the
    difference for some 10 K. Source: the coupling of preload and heat in Bossmanns & Tu, Int. J. Mach. Tools Manuf. 39
    (1999) 1345 (the linear form is a simplification; unverified).
    """

    torque = param("N m", 0, 1e5, "friction torque with both rings at one temperature", typical=0.3)
    growth = param("1/K", -0.5, 0.5, "growth of the torque per kelvin between the rings", typical=0.04)
    inner = place("where the inner ring's temperature is read")
    outer = place("where the outer ring's temperature is read")
    affine = False
    strength = "growth"
    replaces = {"bearing_friction": {"torque": "torque"}}
    sentence = "the friction that heats {into} grows by {percent} as {inner} becomes warmer than {outer}"

    @property
    def percent(self) -> str:
        """The growth in words."""
        return per_kelvin(float(self.growth))

    def moment(self, u: Inputs, *T: Array) -> Array:
        M: Array = self.torque * not_below_zero(1 + self.growth * (T[0] - T[1]))
        return M

    def slopes(self, u: Inputs, *T: Array) -> tuple[Array, ...]:
        rubs = 1 + self.growth * (T[0] - T[1]) > 0
        slope: Array = np.abs(u[self.input]) * self.torque * self.growth * rubs
        return slope, -slope

    @classmethod
    def take_over(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """Of a constant torque whose two rings can be told: where they are."""
        rings = _rings(entry, machine) if isinstance(entry, BearingFriction) and entry.is_constant else None
        return dict(zip(("inner", "outer"), map(str, rings), strict=True)) if rings else None


def _rings(entry: BearingFriction, machine: MachineLike) -> tuple[Place, Place] | None:
    """Inner and outer ring: the two parts that the bearing heats, or that one and a part linked to it; the one that
    turns is inside."""
    first = entry.into[0][0]
    neighbours = (Place(b if a == first.node else a) for a, b in machine.list_joined_parts() if first.node in (a, b))
    others = [p for p, _ in entry.into if p.node != first.node] or list(neighbours)
    if not others:
        return None
    return (others[0], first) if others[0].node in {*turning(machine)} - {first.node} else (first, others[0])
