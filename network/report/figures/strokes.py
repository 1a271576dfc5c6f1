"""What a picture of a network shows: its links with a number each, and what stands at every node."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.fields import Place
from network.catalogue.mechanisms.base import Link, Stream
from network.catalogue.mechanisms.mechanism import Relay
from network.machine.machine import Machine
from network.platform.quantities.number_format import number
from network.report.figures.canvas import shorten

if TYPE_CHECKING:
    from network.engine.trajectory import Trajectory

EXCESS = 10.0
"""K: the difference at which links are compared that have no constant conductance."""


@dataclass(frozen=True)
class Stroke:
    """A line from node a to node b. value: heat flow from a to b [W], or conductance [W/K]; None without a number."""

    name: str
    a: str
    b: str
    value: float | None
    unit: str
    stream: bool = False


@dataclass(frozen=True)
class Note:
    """A line of text at a node. mark: what it is (sensor, source, relay); watches: the node that switches a relay."""

    mark: str
    text: str
    watches: str = ""


def conductance(machine: Machine, link: Link) -> float:
    """Mean conductance of a link around the reference, with all inputs zero [W/K]."""
    u = {name: np.zeros(()) for name in (*machine.inputs, "time")}
    warm, cold = np.array(machine.reference + EXCESS / 2), np.array(machine.reference - EXCESS / 2)
    own = (np.array(machine.reference) for _ in link.readings())
    return float(link.heat_flow(warm, cold, u, *own)) / EXCESS


def duration(run: Trajectory) -> float:
    return float(run.t[-1] - run.t[0]) or 1.0


def strokes(machine: Machine, run: Trajectory | None) -> Iterator[Stroke]:
    """Every link; a stream is one stroke for each of its legs, and the last bears its number."""
    for name, link in machine.links.items():
        if isinstance(link, Stream):
            nodes = [place.node for place in link.through]
            legs = [(a, b) for a, b in pairwise(nodes) if a != b]
            value, unit_text = _stream_value(name, link, run)
            for i, (a, b) in enumerate(legs):
                yield Stroke(name, a, b, value if i == len(legs) - 1 else None, unit_text, stream=True)
        else:
            a, b = (place.node for place in link.between)
            value = conductance(machine, link) if run is None else _mean_flow(machine, f"links.{name}", a, b, run)
            yield Stroke(name, a, b, value, "W/K" if run is None else "W")


def _stream_value(name: str, stream: Stream, run: Trajectory | None) -> tuple[float, str]:
    """What it brought into the parts; its capacity flow without a run, and for a loop, which brings nothing in."""
    if run is None or stream.through[0].node == stream.through[-1].node:
        return stream.transport()[1], "W/K"
    return run.energy.by_mechanism.get(f"links.{name}", 0.0) / duration(run), "W"


def _mean_flow(machine: Machine, path: str, a: str, b: str, run: Trajectory) -> float:
    """From a to b [W]; the account of a link to a held node tells what it brought into the parts."""
    if path in run.energy.carried:
        return run.energy.carried[path] / duration(run)
    sign = -1.0 if machine.nodes[b].is_held and not machine.nodes[a].is_held else 1.0
    return sign * run.energy.by_mechanism.get(path, 0.0) / duration(run)


def notes(machine: Machine, run: Trajectory | None, whole: Collection[str] = ()) -> dict[str, list[Note]]:
    """What stands at every node: sources with their mean heat, relays, sensors. whole: names that are not cut."""
    by_node: dict[str, list[Note]] = {name: [] for name in machine.nodes}
    for name, source in machine.sources.items():
        relay = isinstance(source, Relay)
        heat = None if run is None else run.energy.by_mechanism.get(f"sources.{name}", 0.0) / duration(run)
        for node, share in _shares(source.into).items():
            watched = {getattr(source, field).node for field in source.places_read()} - {node} if relay else set()
            by_node[node].append(
                Note("relay" if relay else "source", _heat(cut(name, whole), share, heat), next(iter(watched), ""))
            )
    for name, sensor in machine.sensors.items():
        if sensor.place is not None:
            by_node[sensor.place.node].append(Note("sensor", shorten(name)))
    return by_node


def _shares(into: tuple[tuple[Place, float], ...]) -> Mapping[str, float]:
    shares: dict[str, float] = {}
    for place, share in into:
        shares[place.node] = shares.get(place.node, 0.0) + share
    return shares


def cut(name: str, whole: Collection[str], most: int = 28) -> str:
    """A name, its middle left out where it is long and not to be told whole."""
    return name if name in whole else shorten(name, most)


def _heat(name: str, share: float, heat: float | None) -> str:
    if heat is None:
        return name + (f" {share:.0%}" if share < 1 else "")
    return f"{name} {watts(share * heat)}"


def watts(value: float) -> str:
    """Three digits are more than a mean heat flow is good for."""
    return number(value, "W", 3) if abs(value) < 10 else f"{value:.0f} W".replace("-", "−")


def capacity_text(machine: Machine, name: str) -> str:
    """Heat capacity of a part, or where a node's temperature is held."""
    node = machine.nodes[name]
    if not node.is_held:
        return number(node.capacity / 1e3, "kJ/K", 3) if node.is_part else ""
    if not isinstance(node.temperature, str):
        return number(float(node.temperature), "degC", 3)
    return "" if node.temperature == name else shorten(node.temperature)
