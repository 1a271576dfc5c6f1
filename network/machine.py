"""A machine: nodes, links, sources, how temperature moves the tool centre point, sensors. Read from YAML, patched."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self, TypeVar

from network import materials
from network.checks import check_machine, check_places
from network.declare import Declared
from network.expansions.base import AXES, Expansion
from network.fields import read_kind
from network.lumps import level_patch
from network.mechanisms.base import Link, Source, Stream
from network.nodes import Node
from network.patch import check_sections, load_tree, merged, set_lumps, set_value
from network.refusal import Complaints, Refusal, Spot, likely
from network.rooms import kinds
from network.sensors.sensor import Sensor
from network.units import BadNumber, Number, in_unit
from network.yamlfile import Branch, Leaf, Tree, plain, tree_of

Entry = TypeVar("Entry", bound=Declared)


@dataclass(frozen=True)
class Machine:
    """Everything a machine file says, with materials, lengths and the reference filled in.

    reference: temperature of zero displacement [°C]; tcp: axis → name → entry; tree: the file as merged, from which
    patches start; warnings: what was doubtful in it.
    """

    name: str
    reference: float
    nodes: Mapping[str, Node]
    links: Mapping[str, Link | Stream]
    sources: Mapping[str, Source]
    tcp: Mapping[str, Mapping[str, Expansion]]
    sensors: Mapping[str, Sensor]
    materials: Mapping[str, materials.Material]
    closed_form: Mapping[str, str]
    tree: Branch
    file: str
    warnings: tuple[Refusal, ...] = field(default=())

    @classmethod
    def load(
        cls, path: str | Path, *, level: str | None = None, lumps: Sequence[str | int] = (), sets: Sequence[str] = ()
    ) -> Self:
        """The machine of a YAML file, patched by a named level, lump counts and `path=value` settings, in that order.

        Raises Refused with every fault of the file.
        """
        machine = cls.read(load_tree(Path(path)), str(path))
        if level is not None:
            machine = cls.read(level_patch(machine, level), str(path))
        tree = machine.tree
        for wish in lumps:
            tree = set_lumps(tree, str(wish))
        for assignment in sets:
            tree = set_value(tree, assignment)
        return machine if tree is machine.tree else cls.read(tree, str(path))

    @classmethod
    def read(cls, tree: Branch, file: str) -> Self:
        """The machine of a merged tree. Raises Refused with every fault found."""
        complaints = Complaints()
        check_sections(tree, complaints)
        machine = _Reader(tree, file, complaints).machine(cls)
        complaints.raise_if_any()
        check_machine(machine, complaints)
        complaints.raise_if_any()
        object.__setattr__(machine, "warnings", tuple(complaints.warnings))
        return machine

    def patched(self, patch: Mapping[str, Any] | Branch, origin: str = "patch") -> Self:
        """This machine with a patch laid over it."""
        laid = patch if isinstance(patch, Branch) else tree_of(patch, Spot(origin))
        assert isinstance(laid, Branch)
        return self.read(merged(self.tree, laid), self.file)

    def material(self, name: str) -> materials.Material | None:
        return self.materials.get(name)

    def joined_parts(self) -> Iterator[tuple[str, str]]:
        """Pairs of different parts that some link joins, each pair once."""
        seen = set()
        for link in self.links.values():
            places = link.between if isinstance(link, Link) else ()
            pair = tuple(p.node for p in places if self.nodes[p.node].is_part)
            if len(set(pair)) == 2 and frozenset(pair) not in seen:
                seen.add(frozenset(pair))
                yield pair[0], pair[1]

    @cached_property
    def expansions(self) -> Mapping[tuple[str, str], Expansion]:
        """(axis, name) → entry."""
        return {(axis, name): entry for axis, entries in self.tcp.items() for name, entry in entries.items()}

    def entries(self) -> Iterator[tuple[str, Declared]]:
        """Every entry with its path in the file, like ('links.skin', …)."""
        own = {name: m for name, m in self.materials.items() if m is not materials.BUILT_IN.get(name)}
        for section, named in {"materials": own, "nodes": self.nodes, "links": self.links, "sources": self.sources}.items():
            for name, entry in named.items():
                yield f"{section}.{name}", entry
        for (axis, name), entry in self.expansions.items():
            yield f"tcp.{axis}.{name}", entry
        for name, sensor in self.sensors.items():
            yield f"sensors.{name}", sensor
            for i, effect in enumerate(sensor.effects):
                yield f"sensors.{name}.effects.{i}", effect

    @cached_property
    def uncertain(self) -> Mapping[str, Number]:
        """Path → number with ± or `unknown`."""
        return {f"{path}.{key}": n for path, entry in self.entries() for key, n in entry.uncertain().items()}

    @cached_property
    def inputs(self) -> Mapping[str, str]:
        """The input channels this machine reads, each with a unit of the kind it must have."""
        needed = {n.temperature: "degC" for n in self.nodes.values() if isinstance(n.temperature, str)}
        for _, entry in self.entries():
            needed |= getattr(entry, "needs", dict)()
        return needed

    def to_plain(self) -> dict[str, Any]:
        """The machine as a mapping that reads back as the same machine."""
        return dict(plain(self.tree))

    def __str__(self) -> str:
        from network.report.words import describe

        return describe(self)


def _each_resolved(entries: Mapping[str, Entry], machine: Machine) -> dict[str, Entry]:
    return {name: entry.resolved(machine) for name, entry in entries.items()}


class _Reader:
    """Reads the sections of a merged tree; faults go to `complaints`."""

    def __init__(self, tree: Branch, file: str, complaints: Complaints) -> None:
        self.tree, self.file, self.complaints = tree, file, complaints

    def machine(self, cls: type[Machine]) -> Any:
        named = {name: self._named(name) for name in ("materials", "nodes", "links", "sources", "sensors")}
        stuffs = {**materials.BUILT_IN, **self._plain_entries(materials.Material, named["materials"])}
        nodes = self._plain_entries(Node, named["nodes"])
        machine = cls(
            name=self._text("machine"), reference=self._reference(), nodes=nodes,
            links=self._kinds("links", named["links"]), sources=self._kinds("sources", named["sources"]),
            tcp=self._tcp(), sensors=self._plain_entries(Sensor, named["sensors"]), materials=stuffs,
            closed_form=self._closed_form(), tree=self.tree, file=self.file,
        )  # fmt: skip
        return machine if self.complaints.refusals else self._resolved(machine)

    def _resolved(self, machine: Machine) -> Machine:
        """Fills in what only the whole machine knows; nodes first, the others look at them."""
        self._check_names(machine)
        if self.complaints.refusals:
            return machine
        with_nodes = replace(machine, nodes=_each_resolved(machine.nodes, machine))
        return replace(
            with_nodes,
            links=_each_resolved(machine.links, with_nodes),
            sources=_each_resolved(machine.sources, with_nodes),
            tcp={axis: _each_resolved(entries, with_nodes) for axis, entries in machine.tcp.items()},
        )

    def _check_names(self, machine: Machine) -> None:
        """Materials and nodes that are named must be there before anything can be resolved."""
        for name, node in machine.nodes.items():
            if node.material and node.material not in machine.materials:
                wrong = f"nodes.{name}: there is no material '{node.material}'"
                self.complaints.refuse(node.spot_of("material"), wrong, likely(node.material, machine.materials))
        check_places(machine, self.complaints)

    def _named(self, section: str) -> Branch:
        tree = self.tree.items.get(section)
        return tree if isinstance(tree, Branch) else Branch({}, self.tree.spot)

    def _text(self, key: str) -> str:
        tree = self.tree.items.get(key)
        if isinstance(tree, Leaf) and not tree.is_null:
            return tree.text
        spot = tree.spot if tree is not None else self.tree.spot
        self.complaints.refuse(spot, f"'{key}' is missing", f"begin with `{key}: a name`")
        return ""

    def _reference(self) -> float:
        tree = self.tree.items.get("reference")
        if not isinstance(tree, Leaf) or tree.is_null:
            self.complaints.refuse(self.tree.spot, "'reference' is missing", "give `reference: 22 degC`")
            return 20.0
        try:
            value = in_unit(tree.text, "degC")
            if not -100 <= value <= 300:
                raise BadNumber(f"'{tree.text}' is {value:.4g} degC", "a machine's reference lies between -100 and 300 degC")
            return value
        except BadNumber as error:
            self.complaints.refuse(tree.spot, f"reference {error.wrong}", error.right)
            return 20.0

    def _plain_entries(self, cls: type[Entry], branch: Branch) -> dict[str, Entry]:
        read = {name: cls.read(name, child, self.complaints) for name, child in branch.items.items()}
        for name in read:
            self._check_name(cls.section, name, branch)
        return {name: entry for name, entry in read.items() if entry is not None}

    def _check_name(self, section: str, name: str, branch: Branch) -> None:
        if "@" in name or "," in name or "[" in name or not name.strip():
            self.complaints.refuse(branch.key_spot(name), f"{section}: the name '{name}' has @ , or [ in it", "rename it")

    def _kinds(self, section: str, branch: Branch) -> dict[str, Any]:
        known = kinds(section)
        read = {n: read_kind(known, f"{section}.{n}", child, self.complaints) for n, child in branch.items.items()}
        return {name: entry for name, entry in read.items() if entry is not None}

    def _tcp(self) -> dict[str, dict[str, Any]]:
        result: dict[str, dict[str, Any]] = {}
        branch, known = self._named("tcp"), kinds("tcp")
        for axis, child in branch.items.items():
            if axis not in AXES:
                self.complaints.refuse(branch.key_spot(axis), f"tcp has no axis '{axis}'", "the axes are " + ", ".join(AXES))
            elif not isinstance(child, Branch):
                self.complaints.refuse(child.spot, f"tcp.{axis} is not a mapping", "write `name: {kind: …}` lines below it")
            else:
                result[axis] = {n: e for n, t in child.items.items() if (e := self._expansion(axis, n, t)) is not None}
        return result

    def _expansion(self, axis: str, name: str, tree: Tree) -> Any:
        known: Any = kinds("tcp")
        entry = read_kind(known, f"tcp.{axis}.{name}", tree, self.complaints)
        if entry is None:
            return None
        if axis not in entry.axes:  # type: ignore[attr-defined]
            right = "it acts on " + ", ".join(entry.axes)  # type: ignore[attr-defined]
            self.complaints.refuse(entry.spot, f"tcp.{axis}.{name}: {entry.kind} does not act on {axis}", right)
        return entry.replaced(axis=axis, name=name)

    def _closed_form(self) -> dict[str, str]:
        tree = self.tree.items.get("closed_form")
        result = {}
        for role, child in tree.items.items() if isinstance(tree, Branch) else ():
            if role not in ("spindle", "beam"):
                assert isinstance(tree, Branch)
                self.complaints.refuse(tree.key_spot(role), f"closed_form has no role '{role}'", likely(role, ["spindle", "beam"]))
            elif isinstance(child, Leaf):
                result[role] = child.text
        return result
