"""Assembly of a machine into its network: lumps numbered, entries laid out as elementary flows and stacked by class."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np

from network.catalogue.declaration.declare import Array, Declared, Indices
from network.catalogue.declaration.fields import Place
from network.catalogue.mechanisms.base import Link, Source, Stream
from network.catalogue.mechanisms.conduction import Conduction
from network.catalogue.mechanisms.contact import Contact
from network.catalogue.mechanisms.mechanism import Mechanism, Relay
from network.catalogue.nodes import Node
from network.catalogue.warm_capacity import USUAL
from network.engine.entry_groups import Flows, Guards, Heats, Rates, group_by_structure
from network.engine.network import Held, Network
from network.machine.lumps import weights
from network.machine.machine import Machine

Law = TypeVar("Law", bound=Mechanism)
Into = TypeVar("Into", bound=Source)
Entry = TypeVar("Entry", bound=Declared)


def build(machine: Machine, only: Container[str] | None = None) -> Network:
    """The network of a machine. only: the entries, like 'links.skin', whose heat flows are wanted; all by default."""
    return _Builder(machine, only).network()


class _Element(NamedTuple):
    law: Link | Stream
    a: int
    b: int
    w: float
    entry: int


class _Builder:
    """Numbers the lumps, then lays the entries out as elementary flows."""

    def __init__(self, machine: Machine, only: Container[str] | None = None) -> None:
        self.machine, self.only = machine, only
        self.parts: dict[str, slice] = {}
        self.capacity: list[float] = []
        self.names: list[str] = []
        self.held: dict[int, Held] = {}

    def network(self) -> Network:
        for name, node in self.machine.nodes.items():
            self._add(name, node)
        flows = [*self._links(), *self._bars(), *self._streams()]
        states = dict(self._states())
        sources = [s for name, s in self.machine.sources.items() if self._is_wanted(f"sources.{name}")]
        links = [s for name, s in self.machine.links.items() if self._is_wanted(f"links.{name}")]
        plain = [s for s in sources if not isinstance(s, Relay)]
        relays = [s for s in sources if isinstance(s, Relay)]
        heats: tuple[Heats[Mechanism], ...] = tuple(self._heats(plain))
        switched: tuple[Heats[Relay], ...] = tuple(self._heats(relays))
        heats += tuple(self._rates([s for s in (*sources, *links) if s.states]))
        switched += tuple(self._guards([s for s in links if isinstance(s, Relay)]))
        grouped = tuple(self._group_flows(flows, [int(i) for group in switched for i in group.entry]))
        return Network(
            self.machine, self.parts, np.array(self.capacity), self.held, tuple(self.names), grouped, heats, switched,
            states,
        )  # fmt: skip

    def _add(self, name: str, node: Node) -> None:
        first, count = len(self.capacity), node.lumps
        self.parts[name] = slice(first, first + count)
        if node.is_held:
            self.held[first] = Held(node.temperature, node.drifts)
        each = np.inf if node.is_held else node.capacity / count
        self.capacity.extend([each] * count)

    def _is_wanted(self, entry: str) -> bool:
        return self.only is None or entry in self.only

    def _name(self, name: str) -> int:
        self.names.append(name)
        return len(self.names) - 1

    def _places(self, place: Place) -> list[tuple[int, float]]:
        part = self.parts[place.node]
        share = weights(place, part.stop - part.start)
        return [(part.start + i, float(w)) for i, w in enumerate(share) if w > 0]

    def _links(self) -> Iterator[_Element]:
        for name, link in self.machine.links.items():
            if not isinstance(link, Link):
                continue
            index = self._name(f"links.{name}")
            if not self._is_wanted(f"links.{name}"):
                continue
            a, b = self._places(link.between[0]), list(self._list_far_lumps(link))
            yield from (_Element(law, i, j, w * v, index) for i, w in a for j, v, law in b if i != j)

    def _list_far_lumps(self, link: Link) -> Iterator[tuple[int, float, Link]]:
        """The lumps of a link's second place, each with its weight and law."""
        place, part = link.between[1], self.parts[link.between[1].node]
        if not link.moves:
            yield from ((j, v, link) for j, v in self._places(place))
            return
        ends = np.linspace(0, 1, part.stop - part.start + 1).tolist()
        yield from ((part.start + i, 1.0, link.over(*piece)) for i, piece in enumerate(pairwise(ends)))

    def _bars(self) -> Iterator[_Element]:
        for name, node in self.machine.nodes.items():
            if node.lumps > 1:
                law = _conduct_along(name, node)
                index, part = self._name(f"nodes.{name}"), self.parts[name]
                lumps = range(part.start, part.stop - 1) if self._is_wanted(f"nodes.{name}") else ()
                yield from (_Element(law, i, i + 1, 1.0, index) for i in lumps)

    def _streams(self) -> Iterator[_Element]:
        for name, stream in self.machine.links.items():
            if isinstance(stream, Stream):
                index, path = self._name(f"links.{name}"), list(self._path(name, stream))
                pairs = pairwise(path) if self._is_wanted(f"links.{name}") else ()
                yield from (_Element(stream, i, j, 1.0, index) for i, j in pairs if i != j)

    def _path(self, name: str, stream: Stream) -> Iterator[int]:
        """The lumps a fluid passes, with the cells that make its transport delay."""
        delay, capacity_flow = stream.transport()
        each = int(stream.cells)
        cells = each * (len(stream.through) - 1) if delay > 0 and capacity_flow > 0 else 0
        first = len(self.capacity)
        if cells:
            self.parts[f"{name} (fluid on the way)"] = slice(first, first + cells)
            self.capacity.extend([capacity_flow * delay / cells] * cells)
        for leg, place in enumerate(stream.through):
            if leg and cells:
                yield from range(first + (leg - 1) * each, first + leg * each)
            yield from (i for i, _ in self._places(place))

    def _states(self) -> Iterator[tuple[str, int]]:
        """A lump of capacity 1 for every state of an entry."""
        for name in self.machine.states:
            at = len(self.capacity)
            self.parts[name] = slice(at, at + 1)
            self.capacity.append(1.0)
            yield name, at

    def _group_flows(self, elements: Iterable[_Element], relays: Sequence[int]) -> Iterator[Flows]:
        """The flows by class; relays: the entry of every relay."""
        for members in group_by_structure(elements, lambda element: element.law):
            law = _stack_entries([member.law for member in members])
            columns = zip(*((m.a, m.b, m.w, m.entry) for m in members), strict=True)
            a, b, w, entry = (np.array(column) for column in columns)
            reads = tuple(self._reads([member.law for member in members]))
            relay = np.array([relays.index(i) for i in entry.tolist()]) if isinstance(law, Relay) else None
            yield Flows(law, a, b, w, entry, isinstance(law, Stream), len(self.capacity), reads, relay)

    def _heats(self, sources: Sequence[Into]) -> Iterator[Heats[Into]]:
        for members in group_by_structure(sources, lambda source: source):
            law = type(members[0]).stack(members)
            entry = np.array([self._name(f"sources.{m.name}") for m in members])
            into = np.zeros((len(self.capacity), len(members)))
            for column, member in enumerate(members):
                for place, share in member.into:
                    for i, w in self._places(place):
                        into[i, column] += share * w
            yield Heats(law, into, tuple(self._reads(members)), entry)

    def _rates(self, entries: Sequence[Mechanism]) -> Iterator[Heats[Mechanism]]:
        for members in group_by_structure(entries, lambda entry: entry):
            law, reads, entry = _stack_entries(members), tuple(self._reads(members)), self._entries(members)
            for i, state in enumerate(law.states):
                into = np.zeros((len(self.capacity), len(members)))
                for column, member in enumerate(members):
                    into[self._state(member, state), column] = 1.0
                yield Rates(law, into, reads, entry, i)

    def _guards(self, entries: Sequence[Law]) -> Iterator[Heats[Law]]:
        for members in group_by_structure(entries, lambda entry: entry):
            into = np.zeros((len(self.capacity), len(members)))
            yield Guards(_stack_entries(members), into, tuple(self._reads(members)), self._entries(members))

    def _entries(self, members: Sequence[Mechanism]) -> Indices:
        """Where entries that have a name stand among the mechanisms."""
        return np.array([self.names.index(f"{member.section}.{member.name}") for member in members])

    def _state(self, entry: Mechanism, state: str) -> int:
        return int(self.parts[f"{entry.section}.{entry.name}.{state}"].start)

    def _reads(self, members: Sequence[Mechanism]) -> Iterator[Array]:
        for reading in members[0].readings():
            matrix = np.zeros((len(members), len(self.capacity)))
            for line, member in enumerate(members):
                if reading in member.states:
                    matrix[line, self._state(member, reading)] = 1.0
                    continue
                for i, w in self._places(getattr(member, reading)):
                    matrix[line, i] += w
            yield matrix


def _conduct_along(name: str, node: Node) -> Link:
    """The law between neighbouring lumps of a bar."""
    if not node.conductivity_slope:
        return Conduction(name, conductance=node.bar_conductance)
    joint = Contact(name, conductance=node.bar_conductance, slope=node.conductivity_slope)
    return joint.replaced(cold=USUAL)


def _stack_entries(entries: Sequence[Entry]) -> Entry:
    return type(entries[0]).stack(entries)
