"""Random networks by their number: trees and meshes of 1 to 300 parts, streams, junctions, held inputs, relays,
radiation and laws that follow a temperature, with time constants that lie up to a million apart."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any

import numpy as np
from build import RPM, machine, schedule

from network import Machine
from network.recordings.inputs import Schedule, hold, linear

KINDS = ("linear", "stream", "stiff", "relay", "bent")
SIZES = (1, 2, 3, 4, 6, 8, 12, 20, 40, 100, 300)


@dataclass(frozen=True)
class Drawn:
    """kind: what is special about it, one of KINDS."""

    kind: str
    machine: Machine
    schedule: Schedule


def draw_network(seed: int, number: int) -> Drawn:
    """The same for the same seed and number. Streams and relays are kept to sizes that every method solves."""
    chance = random.Random(f"network {seed}/{number}")
    kind = chance.choices(KINDS, (4, 2, 2, 1, 1))[0]
    size = chance.choices(SIZES, (2, 4, 6, 8, 8, 6, 4, 3, 2, 0.5, 0.2))[0]
    size = min(size, 12) if kind in ("relay", "bent") else size
    return Drawn(kind, _machine(kind, size, chance), _schedule(chance))


def _machine(kind: str, size: int, chance: random.Random) -> Machine:
    names = [f"n{i}" for i in range(size)]
    spread = 3.0 if kind == "stiff" else 0.9
    nodes: dict[str, Any] = {name: {"heat_capacity": f"{10 ** (4 + chance.uniform(-spread, spread)):.5g} J/K"}
                             for name in names}  # fmt: skip
    nodes |= {"ambient": {"temperature": "ambient"}, "floor": {"temperature": "18 degC"}}
    links = _tree(names, nodes, chance) | _mesh(names, chance) | _skins(names, chance)
    if kind == "stream":
        through = ["ambient", *chance.sample(names, min(size, chance.randint(1, 4)))]
        links["stream"] = {"kind": "advection", "through": through, "capacity_flow": _conductance(chance)}
    if kind == "bent":
        links["glow"] = {"kind": "radiation", "between": [chance.choice(names), "ambient"],
                         "emissivity_area": f"{chance.uniform(0.05, 2):.3g} m^2"}  # fmt: skip
        links["draught"] = {"kind": "natural_convection", "between": [chance.choice(names), "floor"],
                            "coefficient": "2 W/(m^2 K^1.25)", "area": f"{chance.uniform(0.1, 1):.3g} m^2"}  # fmt: skip
    return machine(nodes, links=links, sources=_sources(kind, names, chance), sensors=_sensors(nodes))


def _conductance(chance: random.Random) -> str:
    return f"{10 ** chance.uniform(-0.3, 1.9):.4g} W/K"


def _tree(names: list[str], nodes: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    links = {}
    for i in range(1, len(names)):
        parent = names[chance.randrange(i)]
        if chance.random() < 0.3:
            nodes[f"j{i}"] = {}
            links[f"seat {i}"] = _conduction(parent, f"j{i}", chance)
            parent = f"j{i}"
        links[f"tree {i}"] = _conduction(parent, names[i], chance)
    return links


def _conduction(a: str, b: str, chance: random.Random) -> dict[str, Any]:
    return {"kind": "conduction", "between": [a, b], "conductance": _conductance(chance)}


def _mesh(names: list[str], chance: random.Random) -> dict[str, Any]:
    more = chance.choice((0, 0, 1, 3, len(names))) if len(names) > 1 else 0
    return {f"mesh {i}": _conduction(*chance.sample(names, 2), chance) for i in range(more)}


def _skins(names: list[str], chance: random.Random) -> dict[str, Any]:
    wet = chance.sample(names, chance.randint(1, min(len(names), 6)))
    return {
        f"skin {name}": {"kind": "convection", "between": [name, chance.choice(("ambient", "floor"))],
                         "conductance": _conductance(chance)}
        for name in wet
    }  # fmt: skip


def _sources(kind: str, names: list[str], chance: random.Random) -> dict[str, Any]:
    rubs = {"kind": "bearing_friction", "into": {chance.choice(names): 1}, "torque": "400 N mm"}
    sources: dict[str, Any] = {"bearing": rubs}
    if kind == "relay":
        place = chance.choice(names)
        sources["cooler"] = {"kind": "thermostat_cooling", "into": {place: 1}, "watches": place, "set": "22 degC",
                             "hysteresis": f"{chance.uniform(0.3, 2):.3g} K",
                             "power": f"{chance.uniform(50, 900):.4g} W"}  # fmt: skip
    if kind == "bent":
        sources["oil"] = {"kind": "viscous_friction", "into": {names[0]: 1}, "torque": "250 N mm",
                          "thinning": "0.03 1/K", "reads": names[0]}  # fmt: skip
    return sources


def _sensors(nodes: dict[str, Any]) -> dict[str, Any]:
    return {name: {"measures": name, "noise": "0.1 K"} for name in nodes if name not in ("ambient", "floor")}


def _schedule(chance: random.Random) -> Schedule:
    knots = np.cumsum([chance.uniform(5, 900) for _ in range(chance.randint(2, 6))])
    speeds = np.array([chance.choice((0, 3000, -6000, 9000)) for _ in knots]) * RPM
    room = np.array([chance.uniform(15, 28) for _ in knots])
    t, begins = np.linspace(0, float(knots[-1]), chance.randint(2, 40)), knots - knots[0]
    return schedule(t, hold("speed", "rpm", begins, speeds), linear("ambient", "degC", begins, room))
