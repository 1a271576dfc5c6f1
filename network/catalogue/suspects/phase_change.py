from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.fields import Place, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.suspects.base import Suspect

ABOVE, WIDTH = 6.0, 4.0
"""K: how far over the reference a proposal melts, and over how many kelvins: where a warm-up passes through."""


class PhaseChange(Suspect, kind="phase_change"):
    """A part melts: between at − over/2 and at + over/2 it takes up its latent heat L beside C dT, C(T) dT/dt = Q.

    C(T) = C + (L/over)(1 + cos 2π(T − at)/over) within the range: the `melts` of a node (apparent heat capacity). A
    store of paraffin at a ball-screw nut, a compound that softens. The temperature pauses on the way up and again on
    the way down; a larger heat capacity slows it everywhere. Not looked for by a diagnosis: a run in which nothing
    passes the range says nothing, and each proposal takes runs of its own. Source: Voller, Int. J. Numer. Methods Eng.
    30 (1990) 875 (unverified).
    """

    host = place("the part that melts")
    latent_heat = param("J", 0, 1e10, "latent heat", positive=True, typical=1e5)
    at = param("degC", -50, 1000, "middle of the melting range", typical=28)
    over = param("K", 0, 200, "width of the melting range", positive=True, typical=WIDTH)
    strength = "latent_heat"
    searched = False
    shapes = ("at", "over")
    sentence = "{host} melts around {at}, over {over}, and takes up {latent_heat}"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        body = machine.nodes[self.host.node].to_plain()
        return {"nodes": {self.host.node: {**body, "melts": self.write_numbers("at", "over", "latent_heat")}}}

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """In every part that does not melt already, above the reference, doubling its heat capacity there."""
        for name, node in machine.nodes.items():
            if node.is_part and node.to_plain().get("melts") is None:
                latent = node.capacity * WIDTH
                yield cls.typical(host=Place(name), at=machine.reference + ABOVE, latent_heat=latent)
