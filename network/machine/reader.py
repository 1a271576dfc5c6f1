"""From the merged tree of a machine file to its entries; what cannot be read is told and left out.

So that every fault of a file is told at once, reading goes on after a fault with what is left. A name that stands in
the file counts as there even if its entry is faulty.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from network.catalogue import materials
from network.catalogue.declaration.declare import Declared
from network.catalogue.declaration.discovery import kinds, open_rooms
from network.catalogue.declaration.entry_path import EntryPath, axis_of, displacement
from network.catalogue.declaration.fields import read_kind
from network.catalogue.declaration.sections import SECTIONS, TCP, section
from network.catalogue.expansions.base import AXES, Expansion
from network.catalogue.mechanisms.base import Link, Source, Stream
from network.catalogue.nodes import MOST_NODES, Node
from network.catalogue.sensors.sensor import Sensor
from network.machine.checks import places_of
from network.machine.validity import read_validity
from network.platform.quantities.units import BadNumber, in_unit
from network.platform.refusal import Complaints, likely, refuse, short
from network.platform.yaml.tree import Branch, Leaf, Tree

if TYPE_CHECKING:
    from network.machine.entries import Entries

Entry = TypeVar("Entry", bound=Declared)
Kind = TypeVar("Kind", bound="Entries")
ROLES = ("spindle", "beam")
COLDEST, HOTTEST = -100.0, 300.0
MOST_ENTRIES = 10_000
"""Of one section: three for each part that there may be."""
MOST_REMEMBERED = 5000
_READ: dict[tuple[str, str, int], tuple[Tree, Any]] = {}
"""Entries by section, name and piece of tree (kept, so that its id stays its own): patching a machine reads only what
the patch brings."""


class MachineReader:
    """Reads the sections of a tree; faults go to `complaints`."""

    def __init__(self, tree: Branch, file: str, complaints: Complaints) -> None:
        self.tree, self.file, self.complaints = tree, file, complaints

    def machine(self, cls: type[Kind]) -> Kind:
        """Everything that could be read, with what only the whole machine knows filled in. Raises Refused for more
        entries than could be computed with."""
        self._check_size()
        open_rooms()  # a sensor names the kinds of its effects
        stuffs = {**materials.BUILT_IN, **self._plain(materials.Material)}
        nodes, sensors, tcp = self._plain(Node), self._plain(Sensor), self._tcp()
        links = cast("dict[str, Link | Stream]", self._kinds("links"))
        sources = cast("dict[str, Source]", self._kinds("sources"))
        machine = cls(
            name=self._name(), reference=self._reference(), nodes=nodes, links=links, sources=sources, tcp=tcp,
            sensors=sensors, materials=stuffs, closed_form=self._read_closed_form(), tree=self.tree, file=self.file,
            calibrated=read_validity(self.tree, self.complaints),
        )  # fmt: skip
        axes = {(TCP, axis): entries for axis, entries in tcp.items()}
        self._resolve(machine, {("nodes", ""): nodes, ("links", ""): links, ("sources", ""): sources, **axes,
                                ("sensors", ""): sensors})  # fmt: skip
        return machine

    def read_added(self, tree: Branch) -> dict[tuple[str, str], dict[str, Any]]:
        """The entries of a part of the tree, by section and axis, nothing filled in. Raises Refused for too many."""
        self._check_size()
        open_rooms()
        whole, self.tree = self.tree, tree
        found: dict[tuple[str, str], dict[str, Any]] = {("nodes", ""): {**self._plain(Node)}}
        found |= {(where, ""): {**self._kinds(where)} for where in ("links", "sources")}
        found |= {(TCP, axis): {**own} for axis, own in self._tcp().items()}
        found["sensors", ""] = {**self._plain(Sensor)}
        self.tree = whole
        return {where: own for where, own in found.items() if own}

    def _check_size(self) -> None:
        for key in SECTIONS:
            count, most = len(section(self.tree, key).items), MOST_NODES if key == Node.section else MOST_ENTRIES
            if count > most:
                raise refuse(self.tree.key_spot(key), f"{key} has {count} entries", f"give it at most {most}")

    # -- single values ----------------------------------------------------------------------------------------------
    def _value(self, key: str, right: str) -> str | None:
        tree = self.tree.items.get(key)
        if isinstance(tree, Leaf) and tree.text.strip() and not tree.is_null:
            return tree.text.strip()
        if tree is not None and not isinstance(tree, Leaf):
            self.complaints.refuse(tree.spot, f"{key} is not a single value", right)
        elif tree is not None:
            self.complaints.refuse(tree.spot, f"{key} is empty", right)
        elif not any(likely(other, SECTIONS) == f"did you mean '{key}'?" for other in self.tree.items):
            self.complaints.refuse(self.tree.spot, f"'{key}' is missing", right)
        return None

    def _name(self) -> str:
        return self._value("machine", "begin with `machine: a name`") or ""

    def _reference(self) -> float:
        text = self._value("reference", "give the temperature of zero displacement, as in `reference: 22 degC`")
        try:
            value = in_unit(text, "degC") if text is not None else 20.0
            if COLDEST <= value <= HOTTEST:
                return value
            raise BadNumber(f"'{text}' is out of range", f"it lies between {COLDEST:g} and {HOTTEST:g} degC")
        except BadNumber as error:
            self.complaints.refuse(self.tree.items["reference"].spot, f"reference {error.wrong}", error.right)
            return 20.0

    def _read_closed_form(self) -> dict[str, str]:
        branch, result = section(self.tree, "closed_form"), {}
        nodes = section(self.tree, "nodes")
        for role, child in branch.items.items():
            if role not in ROLES:
                wrong = f"closed_form has no role '{short(role)}'"
                self.complaints.refuse(branch.key_spot(role), wrong, "the roles are " + " and ".join(ROLES))
            elif not isinstance(child, Leaf) or child.text not in nodes.items:
                wrong = f"closed_form.{role} names no node"
                right = likely(child.text, nodes.items) if isinstance(child, Leaf) else "give the name of a node"
                self.complaints.refuse(branch.key_spot(role), wrong, right)
            else:
                result[role] = child.text
        return result

    # -- entries ----------------------------------------------------------------------------------------------------
    def _plain(self, cls: type[Entry]) -> dict[str, Entry]:
        branch = section(self.tree, cls.section)
        self._check_names(cls.section, branch)
        read = {name: self._once(cls.section, name, child, lambda n, c, own: cls.read(n, c, own))
                for name, child in branch.items.items()}  # fmt: skip
        return {name: entry for name, entry in read.items() if entry is not None}

    def _once(self, where: str, name: str, child: Tree, read: Callable[[str, Tree, Complaints], Any]) -> Any:
        """The entry of a piece of tree; one that stands in an earlier machine, too, is read only once."""
        known = _READ.get((where, name, id(child)))
        if known is not None:
            return known[1]
        own = Complaints()
        entry = read(name, child, own)
        self.complaints.refusals.extend(own.refusals)
        self.complaints.warnings.extend(own.warnings)
        if entry is not None and not (own.refusals or own.warnings):
            _READ[where, name, id(child)] = (child, entry)
            if len(_READ) > MOST_REMEMBERED:
                _READ.clear()
        return entry

    def _kinds(self, of: str) -> dict[str, Declared]:
        branch, known = section(self.tree, of), kinds(of)
        self._check_names(of, branch)
        read = {n: self._once(of, n, child, lambda n, c, own: read_kind(known, f"{of}.{n}", c, own))
                for n, child in branch.items.items()}  # fmt: skip
        return {name: entry for name, entry in read.items() if entry is not None}

    def _tcp(self) -> dict[str, dict[str, Expansion]]:
        result: dict[str, dict[str, Expansion]] = {}
        tcp = section(self.tree, TCP)
        for axis, child in tcp.items.items():
            if axis not in AXES:
                wrong = f"tcp has no axis '{short(axis)}'"
                self.complaints.refuse(tcp.key_spot(axis), wrong, "the axes are " + ", ".join(AXES))
            elif isinstance(child, Branch):
                self._check_names(displacement(axis), child)
                read = {name: self._expansion(axis, name, tree) for name, tree in child.items.items()}
                result[axis] = {name: entry for name, entry in read.items() if entry is not None}
        return result

    def _expansion(self, axis: str, name: str, tree: Tree) -> Expansion | None:
        known = cast("dict[str, type[Expansion]]", kinds(TCP))
        where = str(EntryPath(TCP, axis, name))
        entry: Expansion | None = self._once(
            displacement(axis), name, tree, lambda n, c, own: read_kind(known, where, c, own)
        )
        if entry is not None and axis not in entry.axes:
            wrong = f"{where}: {entry.kind} does not act on {axis}"
            self.complaints.refuse(entry.spot_of("kind"), wrong, "it acts on " + ", ".join(entry.axes))
            return None
        return entry and entry.replaced(axis=axis, name=name)

    def _check_names(self, where: str, branch: Branch) -> None:
        """Names that places, headers of recordings or paths could not say."""
        forbidden = {"nodes": "@,[", "sensors": ",["}.get(where, "")
        for name in branch.items:
            bad = [sign for sign in forbidden if sign in name]
            if bad:
                wrong = f"{where}: the name '{short(name)}' has {' and '.join(bad)} in it"
                self.complaints.refuse(branch.key_spot(name), wrong, "rename it")
            elif name != " ".join(name.split()) or not name:
                wrong = f"{where}: the name {name[:60]!r} is empty, or has spaces that are not seen"
                self.complaints.refuse(branch.key_spot(name), wrong, "rename it")
            elif where in ("nodes", "sensors") and axis_of(name) is not None:
                wrong = f"{where}: the name '{short(name)}' means a displacement"
                self.complaints.refuse(branch.key_spot(name), wrong, "rename it")

    # -- what only the whole machine knows --------------------------------------------------------------------------
    def _resolve(self, machine: Entries, holders: Mapping[tuple[str, str], dict[str, Any]]) -> None:
        """Entries that name what is not there are told and taken out; the others look up what they need."""
        for (section_name, axis), holder in holders.items():
            for name, entry in list(holder.items()):
                if self.finds_all(machine, EntryPath(section_name, axis, name), entry):
                    holder[name] = entry.resolve(machine)
                else:
                    del holder[name]

    def finds_all(self, machine: Entries, path: EntryPath, entry: Declared) -> bool:
        """Whether all that an entry names is there."""
        material = entry.material if isinstance(entry, Node) else None
        if material is not None and material not in machine.materials:
            self._missing(path, entry, "material", material, "materials", machine.materials)
        gone = [(attribute, place.node) for attribute, place in places_of(entry) if place.node not in machine.nodes]
        for attribute, node in gone:
            self._missing(path, entry, attribute, node, "nodes", machine.nodes)
        return not gone and (material is None or material in machine.materials)

    def _missing(
        self, path: EntryPath, entry: Declared, field: str, name: str, where: str, known: Iterable[str]
    ) -> None:  # fmt: skip
        """Refuses a name that leads nowhere; one that stands in the file has its own fault and is not told again."""
        there = section(self.tree, where)
        if name in there.items:
            return
        wrong = f"{path}: there is no {where[:-1]} '{short(name)}'"
        right = likely(name, dict.fromkeys([*known, *there.items]))
        if where == "materials" and not any(f"'{own}'" in right for own in there.items):
            right = f"{right} `lptn catalogue materials` lists what is built in"
        if name in there.keys:
            wrong, right = f"{wrong} any more ({there.keys[name]} takes it out)", "change or take out this entry too"
        self.complaints.refuse(entry.spot_of(field), wrong, right)
