"""Lumps: places → weights, and simplification levels (named patches, merged nodes)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from network.catalogue.declaration.declare import Array, Declared
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.declaration.fields import Place, PlacesField, SharesField
from network.catalogue.declaration.patch import Patch, overlay
from network.catalogue.declaration.sections import section
from network.catalogue.expansions.base import Expansion
from network.catalogue.nodes import CAPACITIES, Node
from network.machine.checks import places_of
from network.machine.overrides import set_lumps
from network.platform.quantities.units import Number
from network.platform.refusal import Complaints, Refused, Spot, likely, refuse, short
from network.platform.yaml.document import Branch, Items, plain

if TYPE_CHECKING:
    from network.machine.entries import Entries


def weights(place: Place, lumps: int) -> Array:
    """Share of each lump in a place: overlap / length of the range; a point is the lump that contains it. Sum 1."""
    return _weights(place.start, place.stop, lumps)


@lru_cache(maxsize=4096)
def _weights(start: float, stop: float, lumps: int) -> Array:
    edges = np.linspace(0, 1, lumps + 1)
    overlap = np.clip(np.minimum(edges[1:], stop) - np.maximum(edges[:-1], start), 0, None)
    if start == stop:
        overlap[min(int(start * lumps), lumps - 1)] = 1.0
    weight: Array = overlap / overlap.sum()
    weight.setflags(write=False)
    return weight


def level_patch(machine: Entries, name: str) -> Branch:
    """The machine's tree at one of its named levels. Raises Refused for an unknown or faulty level."""
    levels = section(machine.tree, "levels")
    level = levels.items.get(name)
    if not isinstance(level, Branch):
        known = [other for other, patch in levels.items.items() if isinstance(patch, Branch)]
        raise refuse(Spot(machine.file), f"there is no level '{short(name)}'", likely(name, known))
    patch = Branch({k: v for k, v in level.items.items() if k not in ("lumps", "merge")}, level.spot, level.keys)
    tree = _merge_nodes(machine, overlay(machine.tree, patch), level)
    for wish, spot in _lump_wishes(level):
        tree = set_lumps(tree, wish, spot)
    return tree


def check_levels(machine: Entries, complaints: Complaints) -> None:
    """Reads the machine at each of its named levels; what is wrong with one goes to `complaints`."""
    for name, level in section(machine.tree, "levels").items.items():
        if isinstance(level, Branch):
            try:
                type(machine).read(level_patch(machine, name), machine.file)
            except Refused as refused:
                complaints.absorb(refused)


def _lump_wishes(level: Branch) -> Iterator[tuple[str, Spot]]:
    lumps = level.items.get("lumps")
    if isinstance(lumps, Branch):
        for node, count in lumps.items.items():
            yield f"{node}={plain(count)}", lumps.key_spot(node)
    elif lumps is not None:
        yield str(plain(lumps)), lumps.spot


def _merge_nodes(machine: Entries, tree: Branch, level: Branch) -> Branch:
    groups = level.items.get("merge")
    if groups is None:
        return tree
    if not isinstance(groups, Branch):
        raise refuse(groups.spot, "merge is not a mapping", "write `merge: {new name: [node, node]}`")
    for new, members in groups.items.items():
        machine = type(machine).read(tree, machine.file)
        names = plain(members) if isinstance(members, Items) else []
        _check_group(machine, new, names, members.spot)
        tree = merge_patch(machine, new, names).over(tree, members.spot)
    return tree


def _check_group(machine: Entries, new: str, names: list[Any], spot: Spot) -> None:
    parts = [name for name, node in machine.nodes.items() if node.is_part]
    if len({str(name) for name in names}) < max(2, len(names)):
        raise refuse(spot, f"merge.{new} is not a list of different nodes", "write `merge: {new name: [node, node]}`")
    for name in map(str, names):
        if name not in parts:
            raise refuse(spot, f"merge.{new}: '{short(name)}' is no part of the machine", likely(name, parts))
    if new in machine.nodes and new not in names:
        raise refuse(spot, f"merge.{new}: there is another node '{new}'", "give the merged part a name of its own")
    if sum(machine.nodes[name].melts is not None for name in names) > 1:
        raise refuse(spot, f"merge.{new}: several of these parts melt", "merge only one that melts")


def merge_patch(machine: Entries, new: str, members: list[str]) -> Patch:
    """The patch that makes one lump of several parts: capacities add, links between them go, places follow.

    What a part's length and material decided (how far it stretches) is kept as numbers.
    """
    sections = Patch.of(_merge_entries(machine, new, members)).to_plain()
    roles = {role: new if node in members else node for role, node in machine.closed_form.items()}
    return Patch(sections | ({"closed_form": roles} if roles else {}))


def _merge_entries(machine: Entries, new: str, members: list[str]) -> Iterator[tuple[EntryPath, Any]]:
    for name in members:
        if name != new:
            yield EntryPath("nodes", "", name), None
    yield EntryPath("nodes", "", new), _one_lump([machine.nodes[name] for name in members])
    for path, entry in machine.by_path.items():
        if not path.inner and _touches(entry, members):
            body = _move_places(entry, new, members)
            yield path, body and body | entry.keep_in_merge() if isinstance(entry, Expansion) else body


def _one_lump(nodes: list[Node]) -> dict[str, Any]:
    """The YAML of one mass for several parts: capacities with what is uncertain about them, what melts or turns."""
    total = sum(node.capacity for node in nodes)
    numbers = [n for node in nodes for key, n in node.uncertain().items() if key in CAPACITIES]
    capacity = Number(total)
    if any(n.prior == "unknown" for n in numbers):
        low, high = (total + sum(end - n.value for n, end in _ends(numbers, i)) for i in (0, 1))
        capacity = Number(total, "unknown", 0.0, low, high)
    elif numbers:
        capacity = Number(total, "log", math.hypot(*(n.value * n.spread for n in numbers)) / total)
    rotates = {"rotates": True} if any(node.rotates for node in nodes) else {}
    melts = [{"melts": node.melts.to_plain()} for node in nodes if node.melts is not None]
    return {"heat_capacity": Node.fields["heat_capacity"].write(capacity), **rotates, **(melts[0] if melts else {})}


def _ends(numbers: list[Number], i: int) -> Iterator[tuple[Number, float]]:
    return ((n, (n.low, n.high)[i] if n.prior == "unknown" else n.value) for n in numbers)


def _touches(entry: Declared, members: Iterable[str]) -> bool:
    return any(place.node in members for _, place in places_of(entry))


def _move_places(entry: Declared, new: str, members: list[str]) -> Any:
    """The entry's YAML with its places moved to the merged node; None for a link, a tilt or a bending that joined only
    members: it is zero in one lump."""
    body = entry.to_plain()
    for attribute, field in entry.fields.items():
        value = entry.__dict__[attribute]
        if isinstance(value, Place):
            body[field.key] = new if value.node in members else str(value)
        elif value is not None and isinstance(field, PlacesField):
            moved = [new if place.node in members else str(place) for place in value]
            body[field.key] = [place for place, _ in groupby(moved)]
            if len(body[field.key]) == 1:
                return None
        elif value is not None and isinstance(field, SharesField):
            body[field.key] = _move_shares(value, new, members)
    return body


def _move_shares(shares: Iterable[tuple[Place, float]], new: str, members: list[str]) -> Mapping[str, float]:
    total: dict[str, float] = {}
    for place, share in shares:
        key = new if place.node in members else str(place)
        total[key] = round(total.get(key, 0.0) + share, 12)
    return total
