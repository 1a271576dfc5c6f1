"""What can only be checked over a whole machine: names that lead nowhere, parts without heat, parts that never settle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import networkx as nx

from network.declare import Declared
from network.fields import Place, PlaceField, PlacesField, SharesField
from network.mechanisms.base import Link, Stream
from network.refusal import Complaints, Spot, likely
from network.units import unit

if TYPE_CHECKING:
    from network.machine import Machine


def places_of(entry: Declared) -> Iterator[tuple[str, Place]]:
    """(field, place) for every place an entry names."""
    for attribute, field in entry.fields.items():
        value = entry.__dict__[attribute]
        if value is None:
            continue
        if isinstance(field, PlaceField) or isinstance(value, Place):
            yield attribute, value
        elif isinstance(field, PlacesField):
            yield from ((attribute, place) for place in value)
        elif isinstance(field, SharesField):
            yield from ((attribute, place) for place, _ in value)


def check_places(machine: Machine, complaints: Complaints) -> None:
    """Every place leads to a node."""
    for path, entry in machine.entries():
        for attribute, place in places_of(entry):
            if place.node not in machine.nodes:
                wrong = f"{path}: there is no node '{place.node}'"
                complaints.refuse(entry.spot_of(attribute), wrong, likely(place.node, machine.nodes))
    for role, name in machine.closed_form.items():
        if name not in machine.nodes:
            spot = machine.tree.key_spot("closed_form")
            complaints.refuse(spot, f"closed_form.{role}: there is no node '{name}'", likely(name, machine.nodes))


def check_machine(machine: Machine, complaints: Complaints) -> None:
    """All checks over the whole machine; refusals and warnings go to `complaints`."""
    if not any(node.is_part for node in machine.nodes.values()):
        complaints.refuse(machine.tree.spot, "the machine has no part with a heat capacity", "give at least one node")
        return
    _check_entries(machine, complaints)
    _check_sensors(machine, complaints)
    _check_inputs(machine, complaints)
    _check_connections(machine, complaints)


def _check_entries(machine: Machine, complaints: Complaints) -> None:
    for path, entry in machine.entries():
        resolved = path.startswith("tcp.")
        for field, wrong, right in entry.faults() if resolved else ():
            complaints.refuse(entry.spot_of(field), f"{path}: {wrong}", right)
        for field, wrong, right in entry.doubts():
            complaints.warn(entry.spot_of(field), f"{path}: {wrong}", right)
    for name, link in machine.links.items():
        if isinstance(link, Link) and link.between[0] == link.between[1]:
            complaints.refuse(link.spot_of("between"), f"links.{name}: joins {link.between[0]} with itself", "name two places")
    for name, source in machine.sources.items():
        for place, _ in source.into:
            if machine.nodes[place.node].is_held:
                wrong = f"sources.{name}: heats {place.node}, whose temperature is held"
                complaints.refuse(source.spot_of("into"), wrong, "heat a part, or give that node a heat capacity")


def _check_sensors(machine: Machine, complaints: Complaints) -> None:
    for name, sensor in machine.sensors.items():
        if sensor.axis is not None and not machine.tcp.get(sensor.axis):
            wrong = f"sensors.{name}: measures tcp.{sensor.axis}, and nothing moves that axis"
            right = f"add an entry below tcp.{sensor.axis}, or measure " + " or ".join(f"tcp.{a}" for a in machine.tcp)
            complaints.refuse(sensor.spot_of("measures"), wrong, right)
        if name in machine.inputs:
            complaints.refuse(sensor.spot, f"sensors.{name} has the name of an input", "rename the sensor")


def _check_inputs(machine: Machine, complaints: Complaints) -> None:
    """One input cannot be a temperature here and a speed there."""
    seen: dict[str, tuple[str, str]] = {}
    for path, entry in machine.entries():
        held = getattr(entry, "temperature", None)
        needs = {held: "degC"} if isinstance(held, str) else getattr(entry, "needs", dict)()
        for name, unit_text in needs.items():
            first_path, first_unit = seen.setdefault(name, (path, unit_text))
            if unit(first_unit).dimension != unit(unit_text).dimension:
                wrong = f"{path} reads the input '{name}' in {unit_text}, {first_path} in {first_unit}"
                complaints.refuse(entry.spot, wrong, "one input has one kind of unit")


def connections(machine: Machine) -> nx.Graph:
    """The parts and held nodes as a graph; links and streams are edges, with their names."""
    graph: nx.Graph = nx.Graph()
    graph.add_nodes_from(machine.nodes)
    for name, link in machine.links.items():
        places = link.through if isinstance(link, Stream) else link.between
        for a, b in zip(places, places[1:], strict=False):
            graph.add_edge(a.node, b.node, link=name)
    return graph


def _check_connections(machine: Machine, complaints: Complaints) -> None:
    graph = connections(machine)
    heated = {place.node for source in machine.sources.values() for place, _ in source.into}
    for name, node in machine.nodes.items():
        _check_node(machine, name, graph.degree(name), name in heated, node.spot, complaints)
    for component in nx.connected_components(graph):
        parts = [n for n in machine.nodes if n in component and machine.nodes[n].is_part]
        if parts and not any(machine.nodes[n].is_held for n in component) and (graph.degree(parts[0]) or parts[0] in heated):
            names = ", ".join(parts)
            spot = machine.nodes[parts[0]].spot
            complaints.warn(spot, f"nodes.{parts[0]}: no path from {names} to a held node", "it never settles; link it to ambient")


def _check_node(machine: Machine, name: str, links: int, heated: bool, spot: Spot, complaints: Complaints) -> None:
    node = machine.nodes[name]
    if links:
        return
    if node.is_held:
        complaints.warn(spot, f"nodes.{name} is held and no link reaches it", "link it, or take it out")
    elif not heated:
        complaints.refuse(spot, f"nodes.{name} is isolated: no link and no source", "link it, or take it out")
    elif node.is_massless:
        complaints.refuse(spot, f"nodes.{name} is heated, has no heat capacity and no link", "link it, or give heat_capacity")
