from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from network.catalogue.declaration.fields import param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.mechanisms.friction import Sliding, halve_heat, list_joints


class GuideFriction(Sliding, kind="guide_friction"):
    """Friction of a guideway: q = F |v|, v the feed, F = μ N the force of Coulomb friction: it is `power_per_feed`.

    60 N, a few carriages with their wipers, are 1 W/(m/min). Viscous drag of a slideway, which grows with v², is left
    out. To be told from screw_friction only by the place.
    """

    power_per_feed = param("W/(m/min)", 0, 1e5, "heat for each unit of feed", typical=4)
    sentence = "a guideway rubs and heats {into} with {power_per_feed} of feed"

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """In every part, and one half in each of two parts that a link joins: a carriage and its rail."""
        yield from super().besides(machine)
        yield from (halve_heat(cls, machine, *places) for places in list_joints(machine))
