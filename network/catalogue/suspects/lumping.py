from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.fields import Place, place, whole
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.nodes import MOST_LUMPS
from network.catalogue.suspects.base import Suspect

FEWEST = 10
"""Lumps of a bar that counts as refined: below, profiles of a warm-up are coarse."""


class Lumping(Suspect, kind="lumping"):
    """A part is cut too coarsely: as many lumps as it takes for its profile, λ S/Δx between them.

    One lump answers at once along its whole length; a bar needs Δx well below √(λ t/(ρ c)), some 60 mm for steel after
    five minutes. Not missing physics but a simplification: refine until the answer stops changing, then judge.
    """

    host = place("the bar")
    lumps = whole("number of lumps", 2, MOST_LUMPS)
    strength = "lumps"
    sentence = "{host} needs {lumps} lumps along its length"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        node = machine.nodes[self.host.node]
        return {"nodes": {self.host.node: {**node.to_plain(), "lumps": self.lumps}}}

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """Every bar, one at a time."""
        for name, node in machine.nodes.items():
            if node.is_bar and (more := _more(node.lumps)) > node.lumps:
                yield cls(host=Place(name), lumps=more)


def _more(lumps: int) -> int:
    return min(max(FEWEST, 2 * lumps), MOST_LUMPS)
