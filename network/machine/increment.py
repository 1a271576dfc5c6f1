"""A machine with a few entries put into it: these are read and checked alone, all others stay as they were read.

Only what is beyond doubt is decided here. Whatever could be refused or warned of, and whatever changes what other
entries look up, is left to a reading of the whole file, which has the words for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar

from network.catalogue.declaration.declare import Declared
from network.catalogue.declaration.entry_path import NESTED, EntryPath
from network.catalogue.declaration.sections import TCP, section
from network.catalogue.nodes import Node
from network.catalogue.sensors.sensor import Sensor
from network.machine.checks import check_added
from network.machine.entries import SECTIONS, Entries
from network.machine.reader import MachineReader
from network.platform.refusal import Complaints
from network.platform.yaml.tree import Branch, Tree

Kind = TypeVar("Kind", bound=Entries)
Added = dict[tuple[str, str], dict[str, Any]]
"""Entries by section and axis."""
OPEN = tuple(name for name in SECTIONS if name != "materials")
"""Sections into which entries may be put."""
AS_READ = "is_as_read"
"""What a machine says of itself that has the numbers of its tree and no faults: one with numbers exchanged has not."""


def extend(machine: Kind, tree: Branch) -> Kind | None:
    """The machine of a tree that has more entries than its own, or others; None where all is to be read again."""
    if AS_READ not in machine.__dict__ or machine.warnings or machine.calibrated is not None:
        return None
    added, complaints = _find_added(machine.tree, tree), Complaints()
    if added is None:
        return None
    reader = MachineReader(tree, machine.file, complaints)
    read = reader.read_added(added)
    before, other = machine, _with_added(machine, tree, read)
    if complaints.refusals or complaints.warnings or not _resolve(reader, other, read):
        return None
    check_added(before, other, _list_entries(read), complaints)
    if complaints.refusals or complaints.warnings:
        return None
    other.__dict__[AS_READ] = True
    changed = {where for where, _ in read}
    other.__dict__["by_section"] = {
        where: other.list_section(where) if where in changed else own for where, own in before.by_section.items()
    }
    return other


def _find_added(before: Branch, now: Branch) -> Branch | None:
    """The sections of a tree with what is new or other in them; None where something else differs or is gone, or a
    node is another."""
    sections: dict[str, Tree] = {}
    for key in {**before.items, **now.items}:
        old, new = before.items.get(key), now.items.get(key)
        if old is new:
            continue
        changed = _find_changed(old, new, 2 if key == TCP else 1) if key in OPEN else None
        if changed is None or (key == Node.section and not changed.items.keys().isdisjoint(section(before, key).items)):
            return None
        sections[key] = changed
    return Branch(sections, now.spot, now.keys)


def _find_changed(old: Tree | None, new: Tree | None, below: int) -> Branch | None:
    """What differs in a section whose entries lie so many keys below; None where something is gone."""
    there = old.items if isinstance(old, Branch) else {}
    if not isinstance(new, Branch) or not there.keys() <= new.items.keys():
        return None
    changed = {name: child for name, child in new.items.items() if child is not there.get(name)}
    if below > 1:
        inner = {name: _find_changed(there.get(name), child, below - 1) for name, child in changed.items()}
        found = {name: child for name, child in inner.items() if child is not None}
        return Branch(dict(found), new.spot, new.keys) if len(found) == len(inner) else None
    return Branch(changed, new.spot, new.keys)


def _with_added(machine: Kind, tree: Branch, read: Added) -> Kind:
    """The machine with other entries beside its own, not resolved yet."""
    tcp = {axis: {**own} for axis, own in machine.tcp.items()}
    for (where, axis), entries in read.items():
        if where == TCP:
            tcp[axis] = {**tcp.get(axis, {}), **entries}
    named = {where: {**getattr(machine, where), **read.get((where, ""), {})} for where in OPEN if where != TCP}
    return replace(
        machine, nodes=named["nodes"], links=named["links"], sources=named["sources"], sensors=named["sensors"],
        tcp=tcp, tree=tree,
    )  # fmt: skip


def _resolve(reader: MachineReader, machine: Entries, read: Added) -> bool:
    """Lets the new entries look up what they need, and sensors that may be theirs; whether all is there."""
    holders: dict[tuple[str, str], Any] = {(where, ""): getattr(machine, where) for where in OPEN if where != TCP}
    holders |= {(TCP, axis): own for axis, own in machine.tcp.items()}
    for where, entries in read.items():
        if not all(reader.finds_all(machine, EntryPath(*where, name), entry) for name, entry in entries.items()):
            return False
        which = machine.sensors if where[0] == Sensor.section else entries
        entries.update({name: holders[where][name].resolve(machine) for name in which})
        holders[where].update(entries)
    return True


def _list_entries(read: Added) -> Mapping[EntryPath, Declared]:
    """All of them, behind each those that it holds."""
    found: dict[EntryPath, Declared] = {}
    for (where, axis), entries in read.items():
        for name, entry in entries.items():
            path = EntryPath(where, axis, name)
            found[path] = entry
            if where in NESTED:
                found.update(path.list_inner(entry.__dict__))
    return found
