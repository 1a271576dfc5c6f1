"""From a layout and numbers to a meshed system: cells, places as weights over cells, and what sensors read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from proof.exchanges import Flow, between, buoyancy, radiation, to_air, to_held
from proof.laws import RPM, motor_loss
from proof.layout import FED, NUMBER, Cooler, Heat, Joint, Layout, Stream, split
from proof.system import Array, Burst, Exchange, Film, Law, Loss, Relay, System

SEAT = 5.0
"""J/K of what the file takes for massless."""

Weights = dict[int, float]
Touch = Callable[[Array, Array, Array, Array], Array]
"""(t [s], rpm, air [°C], reading) → reading, for what happens behind the temperatures."""


def cells_of(layout: Layout, fine: bool) -> dict[str, int]:
    """One cell for each part, or cells of some 15 mm: 14 at the least, 40 at the most, and no more than that makes
    some 300 in all: 8 at the least.

    The ends of places and of sensors' ranges do not fall on the edges of cells.
    """
    if not fine:
        return dict.fromkeys(layout.parts, 1)
    most = max(8, min(40, 300 // len(layout.parts)))
    return {name: int(np.clip(round(part.length / 0.015), min(14, most), most)) for name, part in layout.parts.items()}


@dataclass
class Assembly:
    """What has been put together so far; effects add to it before it is frozen."""

    layout: Layout
    numbers: Mapping[str, float]
    counts: Mapping[str, int]
    capacity: list[float] = field(default_factory=list)
    owner: list[str] = field(default_factory=list)
    cells: dict[str, list[int]] = field(default_factory=dict)
    paths: list[tuple[Weights, Weights, float]] = field(default_factory=list)
    sinks: list[tuple[Weights, str, float]] = field(default_factory=list)
    rows: list[tuple[int, Weights]] = field(default_factory=list)
    films: list[tuple[Weights, str, Callable[[float], float]]] = field(default_factory=list)
    losses: dict[str, tuple[Weights, Callable[[float], float]]] = field(default_factory=dict)
    laws: list[tuple[Weights, Weights, Callable[[float, float, float], float]]] = field(default_factory=list)
    bursts: list[tuple[float, float, Weights, float]] = field(default_factory=list)
    relays: list[tuple[Weights, Weights, dict[str, float]]] = field(default_factory=list)
    fed: list[tuple[Weights, Callable[[float], float]]] = field(default_factory=list)
    exchanges: list[Callable[[], Exchange]] = field(default_factory=list)
    radiating: list[tuple[Weights, float]] = field(default_factory=list)
    buoyant: list[tuple[Weights, float]] = field(default_factory=list)
    airs: list[Callable[[float], float]] = field(default_factory=list)
    one_way: list[tuple[Weights, str | Weights, float]] = field(default_factory=list)
    held: dict[str, float] = field(default_factory=dict)
    readings: dict[str, Weights] = field(default_factory=dict)
    touches: dict[str, list[Touch]] = field(default_factory=dict)

    def add(self, name: str, capacity: float, cells: int = 1) -> None:
        """A chain of cells that share a heat capacity [J/K]; nothing joins them yet."""
        self.cells[name] = list(range(len(self.capacity), len(self.capacity) + cells))
        self.capacity += [capacity / cells] * cells
        self.owner += [name] * cells

    def at(self, place: str) -> Weights:
        """Share of the place's range in every cell; the shares add up to 1."""
        name, a, b = split(place)
        cells = self.cells[name]
        if a == b:
            return {cells[min(int(a * len(cells)), len(cells) - 1)]: 1.0}
        edges = np.linspace(0, 1, len(cells) + 1)
        lap = np.clip(np.minimum(b, edges[1:]) - np.maximum(a, edges[:-1]), 0, None) / (b - a)
        return {cell: float(w) for cell, w in zip(cells, lap, strict=True) if w > 1e-12}

    def join(self, a: str | Weights, b: str, G: float) -> None:
        """A conductance [W/K] between places, or from a place to a held node."""
        one = self.at(a) if isinstance(a, str) else a
        if split(b)[0] in self.cells:
            self.paths.append((one, self.at(b), G))
        else:
            self.sinks.append((one, b, G))

    def bend(self, a: str, b: str, flow: Flow) -> None:
        """A path of any law between two places, or from a place to a held node."""
        to = split(b)[0]
        if to in self.cells:
            self.exchanges.append(lambda: between(self.dense(self.at(a)), self.dense(self.at(b)), flow))
        elif to in self.held:
            self.exchanges.append(lambda: to_held(self.dense(self.at(a)), self.held[to], flow))
        else:
            self.exchanges.append(lambda: to_air(self.dense(self.at(a)), flow))

    def dense(self, weights: Weights) -> Array:
        w = np.zeros(len(self.capacity))
        w[list(weights)] = list(weights.values())
        return w

    def conductances(self) -> tuple[Array, dict[str, Array]]:
        """L with every path between cells and to held nodes, and the latter once more by name."""
        n = len(self.capacity)
        L, held = np.zeros((n, n)), {name: np.zeros(n) for name in ("ambient", *self.held)}
        for a, b, G in self.paths:
            u, v = self.dense(a), self.dense(b)
            L += G * (np.diag(u + v) - np.outer(u, v) - np.outer(v, u))
        for a, name, G in self.sinks:
            held[name] += G * self.dense(a)
        for into, origin, W in self.one_way:
            if isinstance(origin, str):
                held[origin] += W * self.dense(into)
            else:
                L += W * (np.diag(self.dense(into)) - np.outer(self.dense(into), self.dense(origin)))
        L += np.diag(np.asarray(sum(held.values())))
        for row, weights in self.rows:
            L[row] = -self.dense(weights)
            L[row, row] += 1
        return L, held

    def freeze(self) -> System:
        """The system as it stands now."""
        L, held = self.conductances()
        return System(
            np.array(self.capacity), L, held, dict(self.held),
            tuple(Film(self.dense(w), to, growth) for w, to, growth in self.films),
            tuple(Loss(self.dense(w), power) for w, power in self.losses.values()),
            tuple(Law(self.dense(w), self.dense(r), power) for w, r, power in self.laws),
            tuple(Burst(begin, end, P * self.dense(w)) for begin, end, w, P in self.bursts),
            tuple(Relay(self.dense(w), self.dense(r), **numbers) for w, r, numbers in self.relays),
            tuple(Loss(self.dense(w), power) for w, power in self.fed),
            (*self.skins(), *(make() for make in self.exchanges)), tuple(self.airs),
        )  # fmt: skip

    def skins(self) -> Iterator[Exchange]:
        """All radiation and all buoyancy to the air at once."""
        for skins, law in ((self.radiating, radiation(1.0)), (self.buoyant, buoyancy(1.0))):
            if skins:
                yield to_air(np.asarray(sum(size * self.dense(w) for w, size in skins)), law)


def assemble(layout: Layout, numbers: Mapping[str, float], fine: bool = False) -> Assembly:
    """The machine as its layout has it, with these numbers."""
    build = Assembly(layout, numbers, cells_of(layout, fine))
    build.held = {name: T for name, T in layout.held.items() if T is not None}
    for name in layout.parts:
        add_part(build, name)
    for name in layout.vessels:
        build.add(name, numbers[f"nodes.{name}.heat_capacity"])
    for name in layout.seats:
        build.add(name, SEAT)
    for name, joint in layout.joints.items():
        add_joint(build, name, joint)
    for name, stream in layout.streams.items():
        add_stream(build, stream, numbers[f"links.{name}.capacity_flow"])
    for name, heat in layout.heats.items():
        add_heat(build, name, heat)
    for name, cooler in layout.coolers.items():
        add_cooler(build, cooler, numbers[f"sources.{name}.power"])
    for name, place in layout.sensors.items():
        build.readings[name] = {} if place.startswith("tcp.") else build.at(place)
    return build


def add_part(build: Assembly, name: str) -> None:
    """A bar: ρ c S L and what comes on top, and λ S/Δx between neighbours."""
    part, n = build.layout.parts[name], build.counts[name]
    stuff = build.layout.materials[part.material]
    own = stuff.density * stuff.specific_heat * part.area * part.length
    build.add(name, own + build.numbers.get(f"nodes.{name}.extra_heat_capacity", 0.0), n)
    for a, b in pairwise(build.cells[name]):
        build.paths.append(({a: 1.0}, {b: 1.0}, stuff.conductivity * part.area * n / part.length))


def add_joint(build: Assembly, name: str, joint: Joint) -> None:
    """A path by its law; a film that grows with speed is a path and what comes on top of it."""
    size = build.numbers[f"links.{name}.{NUMBER.get(joint.kind, 'conductance')}"]
    if joint.kind == "radiation":
        build.radiating.append((build.at(joint.a), size))
    elif joint.kind == "natural_convection":
        build.buoyant.append((build.at(joint.a), size * joint.more["area"]))
    else:
        build.join(joint.a, joint.b, size)
    if joint.kind == "forced_convection":
        gain, top = build.numbers[f"links.{name}.gain"], build.layout.top_speed
        losses = {cell: w * size for cell, w in build.at(joint.a).items()}
        build.films.append((losses, joint.b, lambda rpm: gain * (abs(rpm) / top) ** 0.8))


def add_stream(build: Assembly, stream: Stream, W: float) -> None:
    """Each vessel receives from the one before, which does not lose it."""
    for origin, into in pairwise(stream.through):
        build.one_way.append((build.at(into), build.at(origin) if origin in build.cells else origin, W))


def add_cooler(build: Assembly, cooler: Cooler, power: float) -> None:
    """A relay that watches the vessel it cools."""
    upper, lower = cooler.set + cooler.hysteresis, cooler.set - cooler.hysteresis
    at = build.at(cooler.at)
    build.relays.append((at, at, {"power": power, "upper": upper, "lower": lower}))


def add_heat(build: Assembly, name: str, heat: Heat) -> None:
    """A loss [W] as a function of speed [rpm]."""
    into: Weights = {}
    for place, share in heat.into.items():
        into |= {cell: share * w for cell, w in build.at(place).items()}
    x = {key: build.numbers[f"sources.{name}.{key}"] for key in heat.numbers}
    if heat.kind in FED:
        build.fed.append((into, lambda feed: x["power_per_feed"] * abs(feed)))
        return
    top = build.layout.top_speed
    powers: dict[str, Callable[[float], float]] = {
        "bearing_friction": lambda rpm: RPM * abs(rpm) * x["torque"],
        "motor_loss": lambda rpm: motor_loss(rpm / top, x["copper"], x["iron"]),
        "heat_source": lambda rpm: x["power"],
    }
    build.losses[name] = (into, powers[heat.kind])
