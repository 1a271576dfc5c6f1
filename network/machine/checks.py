"""What can only be checked over a whole machine: parts without heat, parts that never settle, inputs of two kinds.

A machine may come here with faulty entries left out (they have been told already); then only what cannot be a
consequence of that is told.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING

from network.catalogue.declaration.declare import Declared
from network.catalogue.declaration.entry_path import EntryPath, displacement
from network.catalogue.declaration.fields import Place, PlacesField, SharesField
from network.catalogue.declaration.sections import CALIBRATED, TCP, is_empty, section
from network.catalogue.expansions.base import AXES
from network.catalogue.mechanisms.base import Link, Source, Stream
from network.catalogue.nodes import Node
from network.catalogue.sensors.sensor import Sensor
from network.machine.size_checks import check_sizes, is_far_from_limits
from network.platform.quantities.units import unit
from network.platform.refusal import Complaints, likely, list_first, short
from network.platform.yaml.tree import Branch, Items, Leaf, Tree

if TYPE_CHECKING:
    from network.machine.entries import Entries


def places_of(entry: Declared) -> Iterator[tuple[str, Place]]:
    """(field, place) for every place an entry names."""
    for attribute, has_places, has_shares in _list_fields(type(entry)):
        value = entry.__dict__[attribute]
        if isinstance(value, Place):
            yield attribute, value
        elif value is not None and has_places:
            yield from ((attribute, place) for place in value)
        elif value is not None and has_shares:
            yield from ((attribute, place) for place, _ in value)


@cache
def _list_fields(kind: type[Declared]) -> tuple[tuple[str, bool, bool], ...]:
    """Fields of a kind, and whether they hold several places, or shares of these."""
    return tuple((name, isinstance(f, PlacesField), isinstance(f, SharesField)) for name, f in kind.fields.items())


def check_machine(machine: Entries, complaints: Complaints) -> None:
    """All checks over the whole machine; refusals and warnings go to `complaints`."""
    given = machine.tree.items.get("nodes")
    faulty = len(machine.nodes) < len(given.items) if isinstance(given, Branch) else not is_empty(given)
    if not faulty and not any(node.is_part for node in machine.nodes.values()):
        spot = machine.tree.key_spot("nodes")
        complaints.refuse(spot, "the machine has no part with a heat capacity", "give at least one node with one")
        return
    if not check_sizes(machine, complaints):
        return
    _check_entries(machine, machine.by_path, complaints)
    _check_links(machine, machine.links, complaints)
    _check_sources(machine, machine.sources, complaints)
    _check_sensors(machine, complaints)
    _check_inputs(machine, complaints)
    _check_connections(machine, complaints)
    _check_validity(machine, complaints)


def check_added(before: Entries, machine: Entries, added: Mapping[EntryPath, Declared], complaints: Complaints) -> None:
    """The same of entries put into a machine that has no faults, as far as these could be at fault."""
    if not (is_far_from_limits(before, machine, added) or check_sizes(machine, complaints)):
        return
    links = {path.name: machine.links[path.name] for path in added if path.section == "links"}
    sources = {path.name: machine.sources[path.name] for path in added if path.section == "sources"}
    sections, read = {path.section for path in added}, [pair for e in added.values() for pair in e.needs().items()]
    has_nodes, is_read = Node.section in sections, any(before.inputs.get(name) != text for name, text in read)
    _check_entries(machine, machine.by_path if has_nodes else added, complaints)
    _check_links(machine, links, complaints)
    _check_sources(machine, sources, complaints)
    if has_nodes or is_read or Sensor.section in sections:
        _check_sensors(machine, complaints)
        _check_inputs(machine, complaints)
    if has_nodes or not sources.keys().isdisjoint(before.sources) or not all(map(before.joins_as, links.values())):
        _check_connections(machine, complaints)


def _check_entries(machine: Entries, entries: Mapping[EntryPath, Declared], complaints: Complaints) -> None:
    """What the entries say against themselves; expansions know the machine by now and are asked again."""
    for path, entry in entries.items():
        for field, wrong, right in entry.faults() if path.section == TCP else ():
            complaints.refuse(entry.spot_of(field), f"{path}: {wrong}", right)
        for field, wrong, right in entry.doubts():
            complaints.warn(entry.spot_of(field), f"{path}: {wrong}", right)
        held = entry.temperature if isinstance(entry, Node) else None
        if isinstance(held, str) and held in machine.nodes and held != entry.name:
            wrong = f"{path}: its temperature is the input '{held}', and a node has that name too"
            complaints.warn(entry.spot_of("temperature"), wrong, "an input is meant here; link nodes to join them")


def _check_links(machine: Entries, links: Mapping[str, Link | Stream], complaints: Complaints) -> None:
    for name, link in links.items():
        places = link.places
        field = "through" if isinstance(link, Stream) else "between"
        for a, b in pairwise(places):
            if a == b:
                wrong = f"links.{name}: joins {a} with itself"
                complaints.refuse(link.spot_of(field), wrong, "name two different places")
        if all(machine.nodes[place.node].is_held for place in places):
            wrong = f"links.{name}: joins only nodes whose temperature is held"
            complaints.warn(link.spot_of(field), wrong, "it changes nothing; link a part, or take it out")


def _check_sources(machine: Entries, sources: Mapping[str, Source], complaints: Complaints) -> None:
    for name, source in sources.items():
        for place, _ in source.into:
            if machine.nodes[place.node].is_held:
                wrong = f"sources.{name}: heats {place.node}, whose temperature is held"
                complaints.refuse(source.spot_of("into"), wrong, "heat a part, or give that node a heat capacity")


def _check_sensors(machine: Entries, complaints: Complaints) -> None:
    tcp = section(machine.tree, TCP)
    unmoved = [axis for axis in tcp.items if isinstance(tcp.items[axis], Branch) and not section(tcp, axis).items]
    moved = [axis for axis, entries in tcp.items.items() if not is_empty(entries) and axis not in unmoved]
    for name, sensor in machine.sensors.items():
        _check_exchange(machine, name, sensor, complaints)
        for effect in sensor.effects:
            if effect.follows and sensor.find_followed(machine, effect) is None:
                wrong = f"sensors.{name}: {effect.kind} with '{short(effect.follows)}', which has none of its own"
                complaints.refuse(sensor.spot_of("effects"), wrong, "name a sensor that has one with a number")
        if sensor.place is not None and machine.nodes[sensor.place.node].is_held:
            wrong = f"sensors.{name}: measures {sensor.place.node}, whose temperature is held: it tells nothing of the"
            complaints.warn(sensor.spot_of("measures"), f"{wrong} machine", "measure a part, or take it out")
        if sensor.axis is not None and sensor.axis not in moved and set(moved) <= set(AXES):
            wrong = f"sensors.{name}: measures {displacement(sensor.axis)}, and nothing moves that axis"
            others = " or ".join(displacement(axis) for axis in moved)
            right = f"add an entry below {displacement(sensor.axis)}" + (f", or measure {others}" if others else "")
            complaints.refuse(sensor.spot_of("measures"), wrong, right)
        if name in machine.inputs or name == "time":
            what = "an input" if name != "time" else "the time column"
            complaints.refuse(sensor.spot, f"sensors.{name} has the name of {what}", "rename the sensor")


def _check_exchange(machine: Entries, name: str, sensor: Sensor, complaints: Complaints) -> None:
    """Two sensors that are exchanged are there, measure the same kind of thing, and neither has a third partner."""
    with_whom = sensor.exchanged
    if not with_whom:
        return
    spot, other = sensor.spot_of("effects"), machine.sensors.get(with_whom)
    if other is None or other is sensor:
        if with_whom == name or with_whom not in section(machine.tree, "sensors").items:
            wrong = f"sensors.{name}: is exchanged with '{short(with_whom)}', which is no other sensor"
            others = [one for one in machine.sensors if one != name]
            complaints.refuse(spot, wrong, likely(with_whom, others))
    elif other.quantity != sensor.quantity:
        wrong = f"sensors.{name}: measures a {sensor.quantity} and is exchanged with a {other.quantity}"
        complaints.refuse(spot, wrong, "exchange two thermometers, or two probes of one kind")
    elif others := [n for n, s in machine.sensors.items() if n not in (name, with_whom) and s.exchanged == with_whom]:
        wrong = f"sensors.{name}: is exchanged with {with_whom}, and so is {others[0]}"
        complaints.refuse(spot, wrong, "exchange two at a time")
    elif other.exchanged not in ("", name):
        wrong = f"sensors.{name}: is exchanged with {with_whom}, which is exchanged with {other.exchanged}"
        complaints.refuse(spot, wrong, "exchange two at a time")


def _check_inputs(machine: Entries, complaints: Complaints) -> None:
    """One input cannot be a temperature here and a speed there."""
    seen: dict[str, tuple[EntryPath, str]] = {}
    for path, entry in machine.by_path.items():
        for name, unit_text in entry.needs().items():
            first_path, first_unit = seen.setdefault(name, (path, unit_text)) if unit_text else (path, unit_text)
            if unit(first_unit).dimension != unit(unit_text).dimension:
                wrong = f"{path} reads the input '{name}' in {unit_text}, {first_path} in {first_unit}"
                complaints.refuse(entry.spot, wrong, "one input has one kind of unit")
            if name == "time":
                complaints.refuse(entry.spot, f"{path} reads an input named 'time'", "give it another name")


def _check_validity(machine: Entries, complaints: Complaints) -> None:
    """Ranges are in the units of the inputs, and the numbers spoken of are still uncertain."""
    stated = machine.calibrated
    if stated is None:
        return
    spot = machine.tree.key_spot(CALIBRATED)
    for name, r in stated.ranges.items():
        wanted = machine.inputs.get(name)
        if wanted and unit(r.unit).dimension != unit(wanted).dimension:  # nothing: in any unit
            wrong = f"{CALIBRATED}.ranges.{name} is in {r.unit}, and the machine reads it in {wanted}"
            complaints.refuse(spot, wrong, f"give it in a unit like {wanted}")
    gone = [path for path in stated.root if path not in machine.uncertain]
    if gone and not complaints.refusals:
        several = f" and {len(gone) - 1} more" if len(gone) > 1 else ""
        wrong = f"{CALIBRATED} speaks of {gone[0]}{several}, no uncertain number of this machine: it is left aside"
        complaints.warn(spot, wrong, "there are no bands and no ranges until it is calibrated again")


# -- who is connected with whom -------------------------------------------------------------------------------------
def _check_connections(machine: Entries, complaints: Complaints) -> None:
    linked = _list_mentioned(section(machine.tree, "links"))
    heated = _list_mentioned(section(machine.tree, "sources"))
    for name in machine.nodes:
        if name not in linked and "@" not in name:
            _check_unlinked(machine, name, name in heated, complaints)
    if complaints.refusals:
        return
    for group in _groups(machine):
        parts = [name for name in group if machine.nodes[name].is_part]
        if parts and not any(machine.nodes[name].is_held for name in group):
            wrong = f"nodes.{parts[0]}: no path from {list_first(parts)} to a held node"
            complaints.warn(machine.nodes[parts[0]].spot, wrong, "it never settles; link it to ambient")


def _list_mentioned(branch: Branch) -> set[str]:
    """Every text before an @ in a section: the nodes that its entries name, faulty entries too."""
    return {text.partition("@")[0].strip() for entry in branch.items.values() for text in _texts(entry)}


def _texts(tree: Tree) -> Iterator[str]:
    if isinstance(tree, Leaf):
        yield tree.text
    elif isinstance(tree, Items):
        for child in tree.entries:
            yield from _texts(child)
    else:
        yield from tree.items
        for child in tree.items.values():
            yield from _texts(child)


def _check_unlinked(machine: Entries, name: str, heated: bool, complaints: Complaints) -> None:
    node = machine.nodes[name]
    if node.is_held:
        complaints.warn(node.spot, f"nodes.{name} is held and no link reaches it", "link it, or take it out")
    elif not heated:
        complaints.refuse(node.spot, f"nodes.{name} is isolated: no link and no source", "link it, or take it out")
    elif node.is_massless:
        wrong = f"nodes.{name} is heated, and has no heat capacity and no link"
        complaints.refuse(node.spot, wrong, "link it, or give heat_capacity")


def _groups(machine: Entries) -> Iterator[list[str]]:
    """The nodes that links and streams join, directly or over others, each group in the order of the file."""
    near: dict[str, list[str]] = {name: [] for name in machine.nodes}
    for link in machine.links.values():
        for a, b in pairwise(place.node for place in link.places):
            near[a].append(b)
            near[b].append(a)
    seen, order = set[str](), {name: k for k, name in enumerate(machine.nodes)}
    for first in machine.nodes:
        if first in seen:
            continue
        group, waiting = {first}, [first]
        while waiting:
            more = {name for name in near[waiting.pop()] if name not in group}
            group |= more
            waiting += more
        seen |= group
        yield sorted(group, key=order.__getitem__)
