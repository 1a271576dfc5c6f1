"""What a machine consists of, as plain data: the truth is meshed from it and the user's file is written from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

FED = ("screw_friction", "guide_friction")
"""Heats that follow the feed instead of the speed."""
NUMBER = {"radiation": "emissivity_area", "natural_convection": "coefficient"}
"""What the number of a joint is called in the file where it is no conductance."""


@dataclass(frozen=True)
class Material:
    """Density [kg/m³], specific heat capacity [J/(kg K)], conductivity [W/(m K)], expansion [1/K]."""

    density: float
    specific_heat: float
    conductivity: float
    expansion: float


@dataclass(frozen=True)
class Part:
    """A bar: length [m], area [m²], and a heat capacity [J/K] that comes on top, spread evenly."""

    material: str
    length: float
    area: float
    extra: float = 0.0
    turns: bool = False


@dataclass(frozen=True)
class Joint:
    """A path between two places, or between a place and a held node.

    conductance: W/K; of radiation emissivity times area [m²], of natural convection the coefficient [W/(m² K^1.25)].
    more: what the law knows besides: `gain` at the top speed of a film that grows with speed, `area` [m²].
    """

    a: str
    b: str
    conductance: float
    kind: str = "conduction"
    more: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Stream:
    """Fluid of a capacity flow [W/K] through vessels, one way, in that order."""

    through: tuple[str, ...]
    capacity_flow: float


@dataclass(frozen=True)
class Cooler:
    """A cooler [W] that the user knows of: it takes heat from a vessel, on above `set` + h, off below `set` − h [°C]."""

    at: str
    power: float
    set: float
    hysteresis: float


@dataclass(frozen=True)
class Heat:
    """A loss: `numbers` are torque [N m], or copper and iron [W] at the layout's reference speed, or power [W], or
    power_per_feed [W/(m/min)]."""

    kind: str
    into: Mapping[str, float]
    numbers: Mapping[str, float]


def bearing(inner: str, outer: str, torque: float) -> Heat:
    """Friction of a constant torque [N m], one half into each ring."""
    return Heat("bearing_friction", {inner: 0.5, outer: 0.5}, {"torque": torque})


@dataclass(frozen=True)
class Growth:
    """A part's range that grows by α times length [m] times its mean rise, along an axis."""

    axis: str
    of: str
    length: float
    direction: int


@dataclass(frozen=True)
class Layout:
    """A kind of machine; `sites` tells where an effect could be concealed in it, by the name of the effect."""

    name: str
    title: str
    reference: float
    top_speed: float
    materials: Mapping[str, Material]
    parts: Mapping[str, Part]
    held: Mapping[str, float | None]
    joints: Mapping[str, Joint]
    heats: Mapping[str, Heat]
    growths: Mapping[str, Growth]
    sensors: Mapping[str, str]
    sites: Mapping[str, tuple[Any, ...]]
    zeroed: bool = False
    vessels: Mapping[str, float] = field(default_factory=dict)
    """Heat capacity [J/K] of fluid that is well mixed."""
    seats: tuple[str, ...] = ()
    """Where paths meet and next to no heat is kept."""
    streams: Mapping[str, Stream] = field(default_factory=dict)
    coolers: Mapping[str, Cooler] = field(default_factory=dict)

    @property
    def feeds(self) -> bool:
        """Whether an axis heats it as it moves."""
        return any(heat.kind in FED for heat in self.heats.values())

    def uncertain(self) -> Iterator[tuple[str, float, float]]:
        """Path in the machine file, nominal value, and spread of every number that carries a ±."""
        for name, part in self.parts.items():
            if part.extra:
                yield f"nodes.{name}.extra_heat_capacity", part.extra, 0.2
        for name, capacity in self.vessels.items():
            yield f"nodes.{name}.heat_capacity", capacity, 0.2
        for name, joint in self.joints.items():
            yield f"links.{name}.{NUMBER.get(joint.kind, 'conductance')}", joint.conductance, 0.3
            if "gain" in joint.more:
                yield f"links.{name}.gain", joint.more["gain"], 0.3
        for name, stream in self.streams.items():
            yield f"links.{name}.capacity_flow", stream.capacity_flow, 0.15
        for name, heat in self.heats.items():
            for number, value in heat.numbers.items():
                yield f"sources.{name}.{number}", value, 0.3
        for name, cooler in self.coolers.items():
            yield f"sources.{name}.power", cooler.power, 0.15

    def nominal(self) -> dict[str, float]:
        return {path: value for path, value, _ in self.uncertain()}

    def channels(self) -> dict[str, float]:
        """Declared noise of every channel: 0.05 K, 0.25 µm."""
        return {name: 0.25 if place.startswith("tcp.") else 0.05 for name, place in self.sensors.items()}


def split(place: str) -> tuple[str, float, float]:
    """Name and range of `part@a..b`, of `part@a` (a point) and of `part` (all of it)."""
    name, _, where = place.partition("@")
    if not where:
        return name, 0.0, 1.0
    first, _, last = where.partition("..")
    return name, float(first), float(last or first)
