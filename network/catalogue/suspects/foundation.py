from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.fields import Place, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import fresh
from network.catalogue.mechanisms.friction import turning
from network.catalogue.suspects.base import Suspect

SETTLING = 6 * 3600.0
"""s: the time constant of a part on its feet, from which a typical conductance is taken."""


class Foundation(Suspect, kind="foundation"):
    """A path to a floor, wall or neighbour that keeps its own temperature: Q = G (T − T_floor), T_floor constant.

    The floor counts as a held node, at the machine's reference unless told otherwise: valid for hours, while a slab of
    concrete hardly moves. It looks like a larger loss to air whose temperature does not move with the air's; what is
    only seen, an oven or a wall in the sun, has G = 4 ε A σ T_m³ about the mean T_m of both (Stefan–Boltzmann law: to
    0.3 % for differences up to 30 K, and 1 % for each K of T_m).
    """

    host = place("the part that stands on the floor")
    temperature = param("degC", -50, 100, "temperature of the floor", typical=20)
    conductance = param("W/K", 0, 1e5, "conductance into the floor", typical=10)
    strength = "conductance"
    shapes = ("temperature",)
    sentence = "{host} exchanges heat with something that keeps {temperature}, like a floor or a wall, at {conductance}"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        floor = fresh("foundation", machine.nodes)
        link = {"kind": "conduction", "between": [str(self.host), floor], **self.write_numbers("conductance")}
        name = fresh(f"foundation of {self.host.node}", machine.links)
        return {"nodes": {floor: self.write_numbers("temperature")}, "links": {name: link}}

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """Under every part that does not turn, sized after it."""
        turns = {*turning(machine)}
        for name, node in machine.nodes.items():
            if node.is_part and name not in turns:
                yield cls(host=Place(name), temperature=machine.reference, conductance=node.capacity / SETTLING)
