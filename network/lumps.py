"""Lumps: places → weights, and simplification levels (named patches, merged nodes)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from network.declare import Array, Declared
from network.fields import Place, PlaceField, PlacesField, SharesField
from network.patch import merged, set_lumps
from network.refusal import Spot, likely, refuse
from network.units import show
from network.yamlfile import Branch, Items, plain, tree_of

if TYPE_CHECKING:
    from network.machine import Machine


def weights(place: Place, lumps: int) -> Array:
    """Share of each lump in a place: overlap / length of the range; a point is the lump that contains it. Sum 1."""
    if lumps == 1:
        return np.ones(1)
    if place.start == place.stop:
        point = np.zeros(lumps)
        point[min(int(place.start * lumps), lumps - 1)] = 1.0
        return point
    edges = np.linspace(0, 1, lumps + 1)
    overlap = np.minimum(edges[1:], place.stop) - np.maximum(edges[:-1], place.start)
    share = np.clip(overlap, 0, None)
    return share / share.sum()


def level_patch(machine: Machine, name: str) -> Branch:
    """The machine's tree at one of its named levels. Raises Refused for an unknown level."""
    levels = machine.tree.items.get("levels")
    known = levels.items if isinstance(levels, Branch) else {}
    level = known.get(name)
    if not isinstance(level, Branch):
        raise refuse(Spot(machine.file), f"there is no level '{name}'", likely(name, known))
    patch = Branch({k: v for k, v in level.items.items() if k not in ("lumps", "merge")}, level.spot, level.keys)
    tree = merged(machine.tree, patch)
    tree = _merged_nodes(machine, tree, level)
    lumps = level.items.get("lumps")
    wishes = (
        [f"{node}={plain(count)}" for node, count in lumps.items.items()] if isinstance(lumps, Branch)
        else [str(plain(lumps))] if lumps is not None else []
    )  # fmt: skip
    for wish in wishes:
        tree = set_lumps(tree, wish)
    return tree


def _merged_nodes(machine: Machine, tree: Branch, level: Branch) -> Branch:
    groups = level.items.get("merge")
    if groups is None:
        return tree
    if not isinstance(groups, Branch):
        raise refuse(groups.spot, "merge is not a mapping", "write `merge: {new name: [node, node]}`")
    for new, members in groups.items.items():
        names = plain(members) if isinstance(members, Items) else []
        if len(names) < 2:
            raise refuse(members.spot, f"merge.{new} is not a list of nodes", "write `merge: {new name: [node, node]}`")
        for name in names:
            if name not in machine.nodes or not machine.nodes[name].is_part:
                raise refuse(members.spot, f"merge.{new}: '{name}' is no part of the machine", likely(name, machine.nodes))
        patch = tree_of(merge_patch(type(machine).read(tree, machine.file), new, names), members.spot)
        assert isinstance(patch, Branch)
        tree = merged(tree, patch)
    return tree


def merge_patch(machine: Machine, new: str, members: list[str]) -> dict[str, Any]:
    """The patch that makes one lump of several parts: capacities add, links between them go, places follow.

    What a part's length and material decided (how far it stretches) is kept as numbers.
    """
    total = sum(machine.nodes[m].capacity for m in members)
    rotates = {"rotates": True} if any(machine.nodes[m].rotates for m in members) else {}
    nodes: dict[str, Any] = {m: None for m in members if m != new}
    nodes[new] = {"heat_capacity": show(total, "J/K", 17), **rotates}
    links = {n: _followed(e, new, members) for n, e in machine.links.items() if _touches(e, members)}
    sources = {n: _followed(e, new, members) for n, e in machine.sources.items() if _touches(e, members)}
    sensors = {n: _followed(e, new, members) for n, e in machine.sensors.items() if _touches(e, members)}
    tcp: dict[str, Any] = {}
    for (axis, name), entry in machine.expansions.items():
        if _touches(entry, members):
            body = _followed(entry, new, members)
            tcp.setdefault(axis, {})[name] = body and body | entry.kept_when_merged()
    return {"nodes": nodes, "links": links, "sources": sources, "sensors": sensors, "tcp": tcp}


def _touches(entry: Declared, members: Iterable[str]) -> bool:
    from network.checks import places_of

    return any(place.node in members for _, place in places_of(entry))


def _followed(entry: Declared, new: str, members: list[str]) -> Any:
    """The entry's YAML with its places moved to the merged node; None for a link, a tilt or a bending that joined only
    members: it is zero in one lump."""
    body = entry.to_plain()
    for attribute, field in entry.fields.items():
        value = entry.__dict__[attribute]
        if value is None:
            continue
        if isinstance(field, PlaceField) or isinstance(value, Place):
            body[field.key] = new if value.node in members else str(value)
        elif isinstance(field, PlacesField):
            moved = [new if place.node in members else str(place) for place in value]
            if len(set(moved)) == 1:
                return None
            body[field.key] = moved
        elif isinstance(field, SharesField):
            body[field.key] = _moved_shares(value, new, members)
    return body


def _moved_shares(shares: Iterable[tuple[Place, float]], new: str, members: list[str]) -> Mapping[str, float]:
    total: dict[str, float] = {}
    for place, share in shares:
        key = new if place.node in members else str(place)
        total[key] = total.get(key, 0.0) + share
    return total
