from __future__ import annotations

from collections.abc import Iterator

from network.catalogue.declaration.fields import param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.places import Place
from network.catalogue.mechanisms.base import Link
from network.catalogue.mechanisms.friction import Jointed, Sliding


class ScrewFriction(Sliding, Jointed, kind="screw_friction"):
    """Friction of a ball screw's nut and bearings: q = p |v|, v the feed, p = 2π M/lead for a friction torque M.

    Constant torque: no influence of speed, load or temperature. Source: Tian & He 2004, q = 0.12 π n M in kJ/h with n
    in 1/min and M in N m, which is 2π/60 n M in W, as quoted in eq. 1 of Machines 11 (2023) 408.
    """

    power_per_feed = param("W/(m/min)", 0, 1e5, "heat for each unit of feed", typical=12)
    sentence = "a screw rubs and heats {into} with {power_per_feed} of feed"

    @classmethod
    def list_joints(cls, machine: MachineLike) -> Iterator[tuple[Place, ...]]:
        """Where a nut moves along a bar, that is the screw, and where this lies in its bearings."""
        contacts = [*Link.list_moving(machine)]
        yield from dict.fromkeys((a,) if machine.nodes[a.node].is_massless else (a, bar) for a, bar in contacts)
        screws = {bar.node for _, bar in contacts}
        yield from (places for places in super().list_joints(machine) if screws & {place.node for place in places})
