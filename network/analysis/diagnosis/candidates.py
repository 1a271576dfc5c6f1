"""What could be missing: every patch that the catalogue proposes for a machine, with the numbers that come along.

No physics is named here. A kind declares its strength and shapes, where it could sit, and what it replaces; the rest
follows from the patch.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from operator import itemgetter
from typing import Any

from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.declare import Declared, Effect, list_kinds
from network.catalogue.declaration.discovery import open_rooms
from network.catalogue.declaration.entry_path import NumberPath, displacement
from network.catalogue.declaration.many_units import ManyUnitsField
from network.catalogue.declaration.number_fields import ParamField
from network.catalogue.declaration.patch import Patch
from network.catalogue.declaration.places import Place
from network.catalogue.declaration.proposals import Runs
from network.catalogue.declaration.registry import sections
from network.catalogue.declaration.sections import TCP
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Mechanism, Relay
from network.engine.response.parameters import Parameter, parameter
from network.machine.checks import places_of
from network.machine.machine import Machine
from network.platform.quantities.units import Number
from network.platform.refusal import Refused

STRETCHES = ((0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1.0))
"""Of a bar, in shares of its length, at which a candidate is looked at besides."""
AROUND, FARTHEST = 2.0, 4.0
"""Times as far from the machine's as other temperatures (prior 1σ) that of surroundings that a proposal brings may be:
a floor, an oven, a wall in the sun; and how many of these 1σ it goes at most."""


NO_RUNS = Runs()


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
        """The candidate at another place of a bar that it names; None where it does not fit there."""
        there = candidate(self.base, self.kind, self.patch.move_place(place, other))
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

    @property
    def is_signed(self) -> bool:
        """Whether its strength may be negative; heat not, for what takes heat away has kinds of its own."""
        return self.own[0].field.may_be_negative and self.own[0].field.unit != "W"

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
        laws = [type(e) for e in self._entries if isinstance(e, Mechanism)]
        return len(self.own) > 1 and any(law.edges is not Mechanism.edges for law in laws)

    @cached_property
    def is_steady(self) -> bool:
        """Whether it is a heat that nothing drives or changes."""
        laws = [e for e in self._entries if isinstance(e, Source)]
        is_alone = len(laws) == len(self._entries) == 1
        return is_alone and not (self.is_searched_apart or laws[0].needs() or laws[0].places_read())

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


def kinds() -> Iterator[type[Effect]]:
    """Every kind that can be missing and is looked for."""
    open_rooms()
    for section in sections():
        for kind in list_kinds(section).values():
            if issubclass(kind, Effect) and kind.strength and kind.is_searched():
                yield kind


def candidates(
    machine: Machine, known: Iterable[str], structural: bool = False, among: Iterable[type[Effect]] | None = None,
    runs: Runs = NO_RUNS,
) -> tuple[Candidate, ...]:  # fmt: skip
    """All that is proposed for a machine and can be computed with the inputs known: what has a strength to be fitted,
    or what is structural. among: the kinds in question, if not all; runs: what the recordings bring."""
    known_kinds = kinds() if among is None else among
    wanted = [k for k in known_kinds if isinstance(k.fields[k.strength], ParamField) != structural]
    patches = ((kind, patch) for kind in wanted for patch in kind.proposes_on(machine, runs))
    found = (c for kind, patch in patches if (c := candidate(machine, kind, patch)))
    have = {*known}
    return tuple(c for c in found if have.issuperset(c.machine.inputs))


def candidate(machine: Machine, kind: type[Effect], patch: Mapping[str, Any]) -> Candidate | None:
    """A proposal laid over a machine; None where it does not fit together with what is there."""
    try:
        spelled = _spell_out(kind, Patch(patch))
        patched = machine.patched(spelled, kind.kind)
    except Refused:
        return None
    return Candidate(kind, spelled, machine, patched, own_parameters(patched, kind, spelled))


def lay_over(machine: Machine, found: Iterable[Candidate]) -> tuple[Machine, tuple[Candidate, ...]] | None:
    """Another machine with findings laid over it, one on the other, and these; None where one does not fit, where two
    have one number, or where the numbers of an earlier one do not stand any more: an effect of a sensor moves those
    behind it."""
    laid: list[Candidate] = []
    for c in found:
        again = candidate(machine, c.kind, c.patch)
        if again is None:
            return None
        laid.append(replace(again, proposed=c.proposed))
        machine = again.machine
    own = {p.path: p for c in laid for p in c.own}
    is_once = len(own) == sum(len(c.own) for c in laid)
    return (machine, tuple(laid)) if is_once and has_numbers(machine, own.values()) else None


def has_numbers(machine: Machine, own: Iterable[Parameter]) -> bool:
    """Whether the numbers of earlier findings still stand in a machine."""
    pairs = ((machine.by_path.get(p.entry), p.attribute) for p in own)
    return all(entry is not None and entry.__dict__.get(attribute) is not None for entry, attribute in pairs)


def _spell_out(kind: type[Effect], patch: Patch) -> Patch:
    """The patch with every number that will be fitted written down, also where it has a default."""
    given = {number for number, _ in patch.numbers()}
    for field in (kind.fields[name] for name in (kind.strength, *kind.shapes)):
        if isinstance(field, ParamField) and _stands(kind, field, patch):
            path = kind.path_to(field.attribute, patch)
            if path not in given:
                value = field.initial
                patch = patch.with_value(path, field.write(field.proposal() if value is None else value))
    return patch


def own_parameters(machine: Machine, kind: type[Effect], patch: Patch) -> tuple[Parameter, ...]:
    """Strength and shapes of a patch, with priors of engineering size."""
    strength = kind.fields[kind.strength]
    if not isinstance(strength, ParamField):
        return ()
    fields = [strength, *(f for name in kind.shapes if isinstance(f := kind.fields[name], ParamField))]
    paths = {f.attribute: kind.path_to(f.attribute, patch) for f in fields if _stands(kind, f, patch)}
    return tuple(_own(machine, paths[f.attribute], f, f is strength) for f in fields if f.attribute in paths)


def _stands(kind: type[Effect], field: ParamField, patch: Patch) -> bool:
    """Whether the patch has a place for the number."""
    try:
        kind.path_to(field.attribute, patch)
    except StopIteration:
        return False
    return True


def _own(machine: Machine, path: NumberPath, field: ParamField, is_strength: bool) -> Parameter:
    value = _value(machine, path, field)
    if isinstance(field, ManyUnitsField):
        field = parameter(machine, path).field
    if field.unit == "degC":
        return _own_degrees(machine, path, value)
    if value <= 0 or field.may_be_negative:
        size = max(abs(value), abs(field.proposal()))
        return parameter(machine, path, Number(value, "normal", SETTINGS.signed * size))
    if is_strength:
        return parameter(machine, path, Number(value, "log", SETTINGS.strength))
    has_default = isinstance(field.default, int | float)
    return parameter(machine, path, Number(value, "log", SETTINGS.exponent if has_default else SETTINGS.shape))


def _own_degrees(machine: Machine, path: NumberPath, value: float) -> Parameter:
    """A temperature that a proposal brings: of surroundings, or at which something switches."""
    if path.entry.section != "nodes":
        return parameter(machine, path, Number(value, "normal", SETTINGS.degrees))
    spread = AROUND * SETTINGS.degrees
    own = parameter(machine, path, Number(value, "normal", spread))
    return replace(own, low=value - FARTHEST * spread, high=value + FARTHEST * spread)


def _value(machine: Machine, path: NumberPath, field: ParamField) -> float:
    """The number as the patch has it, its default, or a typical one."""
    entry = machine.by_path[path.entry]
    own = next(name for name, f in entry.fields.items() if f.key == path.key)
    value = entry.__dict__[own]
    return float(value) if isinstance(value, int | float) else field.proposal()
