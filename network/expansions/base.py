"""How a part's temperatures move the tool centre point: the conventions, stated once.

An expansion takes readings (scalars got from the lumps' temperatures) and gives a displacement [m] on x, y, z or an
angle [rad] on a, b, c; at the machine's reference temperature both are zero. `direction` is 1 or −1.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from network.declare import Array, Effect, typical_body
from network.fields import Place, whole
from network.mechanisms.base import STEP, Inputs, stepped

LINEAR_AXES = ("x", "y", "z")
ANGULAR_AXES = ("a", "b", "c")
AXES = LINEAR_AXES + ANGULAR_AXES

How = Literal["mean", "gradient", "heat"]


@dataclass(frozen=True)
class Reading:
    """A scalar taken from a place: mean rise over the reference [K]; gradient of the rise along the bar, as first
    moment Σ ΔT_i y_i / Σ y_i² about the middle of the range [K/m]; heat absorbed above the reference [J]."""

    place: Place
    how: How = "mean"


class Expansion(Effect):
    """Readings → displacement of the tool centre point."""

    section = "tcp"
    axes: ClassVar[tuple[str, ...]] = LINEAR_AXES
    axis: str = ""

    direction = whole("which way it moves the tool centre point: 1 or −1", -1, 1, allowed=(1, -1))

    @abstractmethod
    def readings(self) -> tuple[Reading, ...]:
        """What it reads from the machine."""

    @abstractmethod
    def displacement(self, u: Inputs, *readings: Array) -> Array:
        """Displacement [m] or angle [rad]."""

    def slopes(self, u: Inputs, *readings: Array) -> tuple[Array, ...]:
        """∂displacement/∂reading, by complex step."""
        steps = np.eye(len(readings)) * STEP * 1j
        return tuple(
            np.imag(self.displacement(u, *(stepped(r, s) for r, s in zip(readings, row, strict=True)))) / STEP for row in steps
        )

    def kept_when_merged(self) -> dict[str, Any]:
        """The YAML keys that keep this entry what it is when its part loses length and material in a merge."""
        return {}

    @classmethod
    def proposes(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """On every axis the machine has, for everything it could read."""
        for axis in (a for a in machine.tcp if a in cls.axes):
            for label, given in cls.subjects(machine):
                body = typical_body(cls, direction=1, **given)
                yield {"tcp": {axis: {f"{cls.kind} {label}".strip(): body}}}

    @classmethod
    @abstractmethod
    def subjects(cls, machine: Any) -> Iterator[tuple[str, dict[str, Any]]]:
        """What it could act on: a label and the YAML keys that say so."""


def own_expansion(expansion: Array | None, machine: Any, place: Place) -> float | None:
    """The expansion given, or the material's."""
    return float(expansion) if expansion is not None else machine.nodes[place.node].expansion


def own_length(length: Array | None, machine: Any, place: Place) -> float | None:
    """The length given, or the range's share of the bar."""
    if length is not None:
        return float(length)
    bar = machine.nodes[place.node].length
    return float(bar) * place.share if bar is not None and place.share else None
