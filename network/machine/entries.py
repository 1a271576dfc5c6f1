"""What a machine file says: nodes, links, sources, how temperature moves the tool centre point, sensors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Self

from network.catalogue.declaration.declare import Declared, Effect
from network.catalogue.declaration.entry_path import NESTED, EntryPath
from network.catalogue.declaration.input_field import merge_inputs
from network.catalogue.declaration.sections import TCP
from network.catalogue.expansions.base import Expansion
from network.catalogue.materials import BUILT_IN, Material
from network.catalogue.mechanisms.base import Link, Source, Stream
from network.catalogue.mechanisms.mechanism import State
from network.catalogue.nodes import Node
from network.catalogue.sensors.sensor import Sensor
from network.machine.validity import Validity
from network.platform.quantities.units import Number
from network.platform.refusal import Complaints, Refusal
from network.platform.yaml.document import Branch, plain

SECTIONS = ("materials", "nodes", "links", "sources", TCP, "sensors")
"""That hold entries, in their order."""


@dataclass(frozen=True, repr=False)
class Entries(ABC):
    """Everything a machine file says, with materials, lengths and the reference filled in.

    reference: temperature of zero displacement [°C]; tcp: axis → name → entry; tree: the file as merged, from which
    patches start; warnings: what was doubtful in it; calibrated: what its file says of a calibration.
    """

    name: str
    reference: float
    nodes: Mapping[str, Node]
    links: Mapping[str, Link | Stream]
    sources: Mapping[str, Source]
    tcp: Mapping[str, Mapping[str, Expansion]]
    sensors: Mapping[str, Sensor]
    materials: Mapping[str, Material]
    closed_form: Mapping[str, str]
    tree: Branch
    file: str
    warnings: tuple[Refusal, ...] = field(default=())
    calibrated: Validity | None = None

    @classmethod
    @abstractmethod
    def read(cls, tree: Branch, file: str, complaints: Complaints | None = None) -> Self:
        """The machine of a merged tree. Raises Refused with every fault found, those already in `complaints` too."""

    def material(self, name: str) -> Material | None:
        return self.materials.get(name)

    @property
    def lumps(self) -> int:
        """How many there are, in all parts."""
        return sum(node.lumps for node in self.nodes.values() if node.is_part)

    def list_joined_parts(self) -> Iterator[tuple[str, str]]:
        """Pairs of different parts that some link joins, each pair once."""
        seen = set()
        for link in self.links.values():
            places = link.between if isinstance(link, Link) else ()
            pair = tuple(p.node for p in places if self.nodes[p.node].is_part)
            if len(set(pair)) == 2 and frozenset(pair) not in seen:
                seen.add(frozenset(pair))
                yield pair[0], pair[1]

    def joins_as(self, link: Link | Stream) -> bool:
        """Whether a link joins what one of its name does, or there is none."""
        old = self.links.get(link.name)
        return old is None or [p.node for p in old.places] == [p.node for p in link.places]

    @cached_property
    def expansions(self) -> Mapping[tuple[str, str], Expansion]:
        """(axis, name) → entry."""
        return {(axis, name): entry for axis, entries in self.tcp.items() for name, entry in entries.items()}

    @cached_property
    def exchanged_by(self) -> Mapping[str, str]:
        """Sensor → the first one that says to be exchanged with it."""
        return {sensor.exchanged: name for name, sensor in reversed([*self.sensors.items()]) if sensor.exchanged}

    def entries(self) -> Iterator[tuple[EntryPath, Declared]]:
        """Every entry with its path in the file, behind each entry those that it holds."""
        yield from self.by_path.items()

    def list_section(self, section: str) -> dict[EntryPath, Declared]:
        """Every entry of a section with its path in the file, behind each entry those that it holds."""
        found: dict[EntryPath, Declared] = {}
        for axis, name, entry in self._by_name(section):
            path = EntryPath(section, axis, name)
            found[path] = entry
            if section in NESTED:
                found.update(path.list_inner(entry.__dict__))
        return found

    def _by_name(self, section: str) -> Iterator[tuple[str, str, Declared]]:
        if section == TCP:
            yield from ((axis, name, entry) for (axis, name), entry in self.expansions.items())
        else:
            named: Mapping[str, Declared] = getattr(self, section)
            is_own = section != "materials"
            yield from (("", name, e) for name, e in named.items() if is_own or e is not BUILT_IN.get(name))

    @cached_property
    def by_section(self) -> Mapping[str, Mapping[EntryPath, Declared]]:
        return {section: self.list_section(section) for section in SECTIONS}

    @cached_property
    def by_path(self) -> Mapping[EntryPath, Declared]:
        found: dict[EntryPath, Declared] = {}
        for entries in self.by_section.values():
            found.update(entries)
        return found

    @cached_property
    def paths(self) -> Mapping[str, EntryPath]:
        """Every entry's path by its text."""
        return {str(path): path for path in self.by_path}

    @cached_property
    def states(self) -> Mapping[str, State]:
        """The states that entries keep, by path: links.<name>.<state>."""
        entries = (*self.links.values(), *self.sources.values())
        return {f"{e.section}.{e.name}.{name}": state for e in entries for name, state in e.states.items()}

    @cached_property
    def uncertain(self) -> Mapping[str, Number]:
        """Path, as its user writes it → number with ± or `unknown`."""
        return {f"{path}.{key}": n for path, entry in self.by_path.items() for key, n in entry.uncertain().items()}

    @cached_property
    def validity(self) -> Validity | None:
        """What its calibration says of it; None where a number that this speaks of is no uncertain one any more."""
        stated = self.calibrated
        return stated if stated is not None and set(stated.root) <= set(self.uncertain) else None

    @cached_property
    def inputs(self) -> Mapping[str, str]:
        """The input channels this machine reads, each with a unit of the kind it must have."""
        counts = (pair for sensor in self.sensors.values() for pair in sensor.needs().items())
        return merge_inputs([*self.drives.items(), *counts])

    @cached_property
    def drives(self) -> Mapping[str, str]:
        """Those of the inputs that a run depends on: all but what only says when readings count."""
        effects = (entry for entry in self.by_path.values() if isinstance(entry, Effect))
        return merge_inputs(pair for entry in (*self.nodes.values(), *effects) for pair in entry.needs().items())

    @cached_property
    def switches(self) -> frozenset[str]:
        """The inputs that say whether an entry is there, or a reading counts."""
        gated = (*self.links.values(), *self.sources.values(), *self.sensors.values())
        return frozenset(e.gate for e in gated if e.gate is not None)

    def to_plain(self) -> dict[str, Any]:
        """The machine as a mapping that reads back as the same machine."""
        return dict(plain(self.tree))
