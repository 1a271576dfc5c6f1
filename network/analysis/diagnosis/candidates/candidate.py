"""A candidate for what is missing: one patch laid over a machine, with the numbers that come along.

No physics is named here. A kind declares its strength and shapes, where it could sit, and what it replaces; the rest
follows from the patch.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from operator import itemgetter
from typing import Any

from network.analysis.diagnosis.candidates.own_parameters import own_parameters, spell_out
from network.catalogue.declaration.declare import Declared, Effect
from network.catalogue.declaration.entry_path import displacement
from network.catalogue.declaration.patch import Patch
from network.catalogue.declaration.places import Place
from network.catalogue.declaration.sections import TCP
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Mechanism, Relay
from network.engine.response.parameters import Parameter
from network.machine.checks import places_of
from network.machine.machine import Machine
from network.platform.refusal import Refused

STRETCHES = ((0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1.0))
"""Of a bar, in shares of its length, at which a candidate is looked at besides."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """One patch over a machine `base`. own: its strength (first) and shapes as free parameters; none where its strength
    is a count and no number to be fitted; proposed: the patch as its kind proposes it, where it was moved since."""

    kind: type[Effect]
    patch: Patch
    base: Machine
    machine: Machine
    own: tuple[Parameter, ...]
    proposed: Patch | None = None

    def move_place(self, place: str, other: str) -> Candidate | None:
        """The candidate at another place of a bar that it names; None where it does not fit there, or names
        a piece of it."""
        moved = self.patch.move_place(place, other)
        there = None if moved == self.patch else candidate(self.base, self.kind, moved)
        return there and replace(there, proposed=self.proposed or self.patch)

    @property
    def back(self) -> Candidate | None:
        """The candidate where its kind proposes it."""
        return self if self.proposed is None else candidate(self.base, self.kind, self.proposed)

    @property
    def usual(self) -> dict[str, float]:
        """Its numbers at the middle of their priors, by path."""
        return {p.path: p.value(p.centre) for p in self.own}

    @property
    def is_structural(self) -> bool:
        return not self.own

    @cached_property
    def is_signed(self) -> bool:
        """Whether its strength may be negative; that of heat only where a recorded column drives it, for what else
        takes heat away has kinds of its own."""
        first, sources = self.own[0].field, [e for e in self._entries if isinstance(e, Source)]
        return first.may_be_negative and (first.unit != "W" or any(source.may_cool for source in sources))

    @cached_property
    def _entries(self) -> tuple[Declared | None, ...]:
        """What its patch writes or changes, as it stands in the machine."""
        return tuple(self.machine.by_path.get(path) for path, _ in self.patch.entries())

    @cached_property
    def switches(self) -> bool:
        """Whether it brings a relay, whose instants have to be searched for."""
        return any(isinstance(entry, Relay) for entry in self._entries)

    @cached_property
    def is_timed(self) -> bool:
        """Whether it brings instants of its own, which have no slope that a fit could follow."""
        laws = [e for e in self._entries if isinstance(e, Mechanism)]
        return len(self.own) > 1 and any(law.has_edges() for law in laws)

    @cached_property
    def is_steady(self) -> bool:
        """Whether it is a heat that nothing drives or changes."""
        laws = [e for e in self._entries if isinstance(e, Source)]
        is_alone = len(laws) == len(self._entries) == 1
        return is_alone and laws[0].is_steady

    @property
    def is_searched_apart(self) -> bool:
        """Whether its numbers are drawn and not screened, so that no linear score speaks for it."""
        return self.switches or self.is_timed

    @cached_property
    def name(self) -> str:
        """Kind and places, as a label."""
        return f"{self.kind.kind} ({', '.join(self.places or self.channels)})"

    @cached_property
    def key(self) -> tuple[str, ...]:
        """What tells it from the others of its machine."""
        return (self.kind.kind, *self.places, *self.channels, *(p.path for p in self.own[:1]))

    @cached_property
    def stretches(self) -> tuple[Candidate, ...]:
        """The same at stretches of the bars that it names as a whole, one bar after the other: where along a bar heat
        enters counts as soon as the bar has lumps."""
        moved = (self.move_place(name, str(Place(name, *ends))) for name in self.bars for ends in STRETCHES)
        return tuple(c for c in moved if c is not None and c.places == self.places)

    @property
    def section(self) -> str:
        return "sensors" if self.channels else self.kind.section

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """The channels it changes without touching the machine."""
        return tuple(self.patch.get("sensors", {}))

    @cached_property
    def places(self) -> tuple[str, ...]:
        """Where it sits: the axes it moves, then the nodes it names that were there before."""
        if self.channels:
            return ()
        named = [place.node for place in self._named]
        nodes = dict.fromkeys(n for n in (*named, *self.patch.get("nodes", {})) if n in self.base.nodes)
        return (*map(displacement, self.patch.get(TCP, {})), *nodes)

    @property
    def _named(self) -> Iterator[Place]:
        """The places that its entries name, in the order of the patch."""
        for path, body in self.patch.entries():
            entry = self.machine.by_path[path]
            places = {key: [place for _, place in group] for key, group in groupby(places_of(entry), itemgetter(0))}
            fields = {field.key: attribute for attribute, field in entry.fields.items()}
            yield from (place for key in body for place in places.get(fields.get(key, ""), ()))

    @cached_property
    def parts(self) -> frozenset[str]:
        """Those of the places that store heat."""
        return frozenset(n for n in self.places if n in self.base.nodes and self.base.nodes[n].is_part)

    @property
    def bars(self) -> tuple[str, ...]:
        """Those of the places that are cut into lumps."""
        return tuple(n for n in self.places if n in self.base.nodes and self.base.nodes[n].lumps > 1)

    @property
    def seats(self) -> tuple[Place, ...]:
        """The bars, each with the stretch of it that the patch names."""
        named = {place.node: place for place in self._named if 0 < place.share < 1}
        return tuple(named.get(name, Place(name)) for name in self.bars)


def candidate(machine: Machine, kind: type[Effect], patch: Mapping[str, Any]) -> Candidate | None:
    """A proposal laid over a machine; None where it does not fit together with what is there."""
    try:
        spelled = spell_out(kind, Patch(patch))
        patched = machine.patched(spelled, kind.kind)
    except Refused:
        return None
    return Candidate(kind, spelled, machine, patched, own_parameters(patched, kind, spelled))
