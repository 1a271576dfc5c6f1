"""How a part's temperatures move the tool centre point: the conventions, stated once.

An expansion takes readings (scalars got from the lumps' temperatures) and gives a displacement [m] on x, y, z or an
angle [rad] on a, b, c; at the machine's reference temperature both are zero. `direction` is 1 or −1.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, ClassVar, Literal

import numpy as np

from network.catalogue.declaration.declare import Array, Effect, typical_body
from network.catalogue.declaration.fields import Place, whole
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import fresh_entry
from network.catalogue.mechanisms.base import STEP, Link, add_imaginary_step
from network.catalogue.mechanisms.mechanism import Inputs

LINEAR_AXES = ("x", "y", "z")
ANGULAR_AXES = ("a", "b", "c")
AXES = LINEAR_AXES + ANGULAR_AXES

How = Literal["mean", "gradient", "heat"]
SLACK = 1e-9
"""Of a lump: an edge of a place is on an edge of a lump."""


@dataclass(frozen=True)
class Reading:
    """A scalar taken from a place: mean rise over the reference [K]; gradient of the rise along the bar, as first
    moment Σ ΔT_i y_i / Σ y_i² about the middle of the range [K/m]; heat absorbed above the reference [J]."""

    place: Place
    how: How = "mean"


class Expansion(Effect):
    """Readings → displacement of the tool centre point."""

    section = "tcp"
    changed = dict.fromkeys(
        ("length", "expansion"),
        ("a part that moves the tool further for each kelvin", "a part that moves the tool less for each kelvin"),
    )
    axes: ClassVar[tuple[str, ...]] = LINEAR_AXES
    axis: str = ""

    direction = whole("which way it moves the tool centre point: 1 or −1", -1, 1, allowed=(1, -1))

    @abstractmethod
    def readings(self) -> tuple[Reading, ...]:
        """What it reads from the machine."""

    @abstractmethod
    def movement(self, u: Inputs, *readings: Array) -> Array:
        """Displacement [m] or angle [rad]."""

    def slopes(self, u: Inputs, *readings: Array) -> tuple[Array, ...]:
        """∂displacement/∂reading, by complex step."""
        rows = np.eye(len(readings)) * STEP * 1j
        stepped = (map(add_imaginary_step, readings, row) for row in rows)
        return tuple(np.imag(self.movement(u, *own)) / STEP for own in stepped)

    def keep_in_merge(self) -> dict[str, Any]:
        """The YAML keys that keep this entry what it is when its part loses length and material in a merge."""
        return {}

    @property
    def way(self) -> str:
        """The axis with the sign of its direction."""
        return f"{'+' if self.direction > 0 else '-'}{self.axis}"

    @classmethod
    def proposes(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """On every axis the machine has, for everything it could read, each way: a strength has no sign."""
        for axis in (a for a in machine.tcp if a in cls.axes):
            for label, given in cls.subjects(machine, axis):
                name = fresh_entry(cls.kind, label, machine.tcp[axis])
                for direction in (1, -1):
                    yield {"tcp": {axis: {name: typical_body(cls, direction=direction, **given)}}}

    @classmethod
    @abstractmethod
    def subjects(cls, machine: MachineLike, axis: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """What it could act on to move that axis: a label and the YAML keys that say so."""


def choose(given: Array | None, own: Array | None) -> Array:
    """What the entry gives, else what its part has."""
    value = given if given is not None else own
    assert value is not None
    return value


def own_length(machine: MachineLike, place: Place) -> float | None:
    """The range's share of a bar's length; None for a point and for a part without a length."""
    length = machine.nodes[place.node].length
    return float(length) * place.share if length is not None and place.share else None


def own_expansion(machine: MachineLike, place: Place) -> float | None:
    """The coefficient of expansion of a part's material [1/K]; None without one."""
    alpha: float | None = machine.nodes[place.node].expansion
    return alpha


def lie_in_one_lump(places: Sequence[Place], lumps: int) -> bool:
    """Whether places are of one part and in the same of its lumps, so that nothing differs between them."""
    first = int(min(place.start for place in places) * lumps + SLACK)
    last = math.ceil(max(place.stop for place in places) * lumps - SLACK) - 1
    return len({place.node for place in places}) == 1 and max(last, 0) <= min(first, lumps - 1)


def tell_one_lump(place: Place, lumps: int) -> tuple[str, str]:
    """What is wrong there, and what would be right."""
    where = f"all of it lies in one lump of {place.node}" if lumps > 1 else f"{place.node} is one lump"
    right = f"cut it, as in `lumps: 8` at nodes.{place.node}, or name two parts with `between`"
    return f"is 0 whatever happens: {where}, which has one temperature", right


def neighbours(machine: MachineLike) -> Iterator[tuple[str, str]]:
    """Pairs of parts that a link joins, directly or over one massless node, each once."""
    pairs: dict[frozenset[str], tuple[str, str]] = {}
    for a, b in (*machine.list_joined_parts(), *_over_joints(machine)):
        pairs.setdefault(frozenset((a, b)), (a, b))
    yield from pairs.values()


def _over_joints(machine: MachineLike) -> Iterator[tuple[str, str]]:
    links = [[place.node for place in link.between] for link in machine.links.values() if isinstance(link, Link)]
    for joint in (name for name, node in machine.nodes.items() if node.is_massless):
        around = dict.fromkeys(node for nodes in links if joint in nodes for node in nodes)
        yield from combinations((node for node in around if machine.nodes[node].is_part), 2)


def steel_unless_known(machine: MachineLike, *parts: str) -> dict[str, Any]:
    """For a proposal: the expansion of steel where a part names no material."""
    known = all(machine.nodes[part].expansion is not None for part in parts)
    return {} if known else {"expansion": "1.13e-5 1/K"}
