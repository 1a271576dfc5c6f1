"""What friction has in common: heat is torque times speed, or force times feed; none at rest, none that cools."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.places import Place
from network.catalogue.declaration.proposals import fresh_entry
from network.catalogue.mechanisms.base import Link, Source
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.typical_values import size_body

KILOWATT_AT = 2 * np.pi / 60 * 3000
"""rad/s: a bearing whose torque makes a kilowatt at 3000 rpm was probably meant in N mm."""


class Rubbing(Source):
    """Friction of what turns with the spindle: q = 2π/60 · |n| · M = |ω| M, M the torque at this moment.

    With n in rpm and M in N mm this is q = 1.047e-4 n M. Zero at rest; the sign of n does not matter.
    """

    input = channel("speed", "rpm")

    @abstractmethod
    def moment(self, u: Inputs, *T: Array) -> Array:
        """Friction torque [N m] at the temperatures read [°C]."""

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = np.abs(u[self.input]) * self.moment(u, *T)
        return q


class Friction(Rubbing):
    """Friction whose torque is a number of its own."""

    changed = {
        "torque": (
            "friction that rose: preload, wear or lubricant",
            "friction that fell: run in, preload lost or lubricant changed",
        )
    }
    torque = param("N m", 0, 1e5, "friction torque", typical=0.3)

    def doubts(self) -> Iterator[Advice]:
        kilowatts = float(self.torque) * KILOWATT_AT / 1e3 if self.torque is not None else 0.0
        if kilowatts > 1:
            yield "torque", f"makes {kilowatts:.3g} kW at 3000 rpm", "was N mm meant instead of N m?"


class Sliding(Source):
    """Friction of what moves with the feed: q = F |v|, F = `power_per_feed` the friction force, v the feed."""

    power_per_feed = param("W/(m/min)", 0, 1e5, "heat for each unit of feed", typical=10)
    input = channel("feed", "m/min")
    strength = "power_per_feed"
    changed = {
        "power_per_feed": ("friction that rose: wear, chips or too little oil", "friction that fell: run in, or oiled")
    }

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = self.power_per_feed * np.abs(u[self.input])
        return q


class Jointed(Source):
    """Friction between two parts that lie on each other: without knowing more, one half of its heat into each, or all
    into a massless node that is the joint."""

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """In every part, and in every joint."""
        yield from super().besides(machine)
        for places in cls.list_joints(machine):
            seats = " ".join(place.node for place in places)
            body = size_body(cls, machine, into={str(place): 1 / len(places) for place in places})
            yield {"sources": {fresh_entry(cls.kind, seats, machine.sources): body}}

    @classmethod
    def list_joints(cls, machine: MachineLike) -> Iterator[tuple[Place, ...]]:
        """The places at which two parts touch, the lighter first; each once."""
        links = (e.between for e in machine.links.values() if isinstance(e, Link) and e.touches)
        pairs = ((a, b) for a, b in links if a.node != b.node)
        for a, b in dict.fromkeys(pairs):
            if all(machine.nodes[place.node].is_part for place in (a, b)):
                is_heavy = machine.nodes[a.node].capacity > machine.nodes[b.node].capacity
                yield (b, a) if is_heavy else (a, b)


def turning(machine: MachineLike) -> Iterator[str]:
    """Parts that turn: marked `rotates: true`, or not marked and the first that some friction heats."""
    first = {entry.into[0][0].node for entry in machine.sources.values() if isinstance(entry, Rubbing)}
    for name, node in machine.nodes.items():
        if node.is_part and (name in first if node.rotates is None else node.rotates):
            yield name
