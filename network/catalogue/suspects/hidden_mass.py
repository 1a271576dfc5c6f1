from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.fields import Place, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import fresh
from network.catalogue.suspects.base import Suspect

SHARE = 0.3
"""Of the host's heat capacity: a mass that shows and was still left out."""
LAG = 900.0
"""s: a time constant that a warm-up of some hours shows."""


class HiddenMass(Suspect, kind="hidden_mass"):
    """A heat capacity behind a conductance that the file does not know: C dT_h/dt = G (T − T_h).

    A clamped fixture, a cover, the fluid in a jacket. It slows its host down and answers late, with the time constant
    C/G. Nothing at G = 0; for C/G short beside the process it only adds C to its host.
    """

    host = place("the part it hides behind")
    heat_capacity = param("kJ/K", 0, 1e6, "its heat capacity", positive=True, typical=10)
    conductance = param("W/K", 0, 1e6, "conductance between it and its host", typical=10)
    strength = "conductance"
    shapes = ("heat_capacity",)
    sentence = "a mass of {heat_capacity} that is not in the file takes part behind {host}, joined by {conductance}"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        name = fresh(f"hidden mass at {self.host.node}", {*machine.nodes, *machine.links})
        link = {"kind": "conduction", "between": [str(self.host), name], **self.write_numbers("conductance")}
        return {"nodes": {name: self.write_numbers("heat_capacity")}, "links": {name: link}}

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """Behind every part, sized after it."""
        for name, node in machine.nodes.items():
            if node.is_part:
                C = SHARE * node.capacity
                yield cls(host=Place(name), heat_capacity=C, conductance=C / LAG)
