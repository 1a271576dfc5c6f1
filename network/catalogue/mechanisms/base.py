"""Heat flows: the conventions of sign and spreading, stated once.

Link: heat goes from a to b, −1 for a and +1 for b. Source: +1 for the places it goes into. Stream: 0 for the place
it comes from and +1 for the one it enters. Equations work on arrays of temperatures [°C] and give watts.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any, ClassVar, Self, TypeAlias, cast

import numpy as np

from network.catalogue.declaration.declare import Array, Effect, typical_body
from network.catalogue.declaration.fields import ANY, Place, PlaceField, channel, places, shares
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike, NodeLike
from network.catalogue.declaration.proposals import fresh
from network.catalogue.typical_values import size_body

Inputs: TypeAlias = Mapping[str, Array]
"""Input channels by name at one instant, in SI (speed in rad/s); `time` in s is among them."""

ZERO_CELSIUS = 273.15
STEP = 1e-30


def add_imaginary_step(x: Array, step: complex | Array) -> Array:
    """x with an imaginary step, for a complex-step derivative; typed as the real array it stands for."""
    return cast(Array, x + step)


def magnitude(x: Array) -> Array:
    """|x| that a complex step passes through."""
    return np.where(np.real(x) < 0, -x, x)


def raise_to_power(x: Array, exponent: Array) -> Array:
    """x^p for x ≥ 0, and 0 at x = 0 also where a complex step is in x or p."""
    there = np.real(x) > 0
    return np.where(there, np.where(there, x, 1.0) ** exponent, 0.0)


def not_below_zero(x: Array) -> Array:
    """max(x, 0) that a complex step passes through."""
    return np.where(np.real(x) > 0, x, 0.0)


@dataclass(frozen=True)
class State:
    """A number of its own that an entry carries through a run, like an integral. Its unit is one of SI."""

    unit: str
    meaning: str


def beyond(mode: Array, T: Array, middle: Array, half_width: Array) -> Array:
    """The guard of a hysteresis: on above its middle + half width, off below its middle − half width."""
    return np.asarray(np.where(mode > 0, -1.0, 1.0) * (T - middle) - half_width)


def complex_steps(f: Callable[..., Array], *x: Array) -> tuple[Array, ...]:
    """∂f/∂x for each argument."""
    values = (f(*x[:i], add_imaginary_step(x[i], 1j * STEP), *x[i + 1 :]) for i in range(len(x)))
    return tuple(np.imag(value) / STEP for value in values)


class Mechanism(Effect):
    """A heat flow, in watts.

    states: the states of its own that it keeps, by name; affine: with the inputs given, the heat, and the rates of its
    states, are linear functions of what it reads plus a constant; follows_time: between its edges the heat still
    changes with `time` by itself.
    """

    states: ClassVar[Mapping[str, State]] = {}
    affine: ClassVar[bool] = True
    follows_time: ClassVar[bool] = False
    gate = channel(None, ANY, "an input: it is there only while that is not zero", key="while")

    def let_pass(self, value: Array, u: Inputs) -> Array:
        """A heat, a slope or a rate of it while it is there, else zero."""
        return value if self.gate is None else np.asarray(value * (u[self.gate] != 0))

    def said(self, **more: str) -> str:
        return super().said(**more) + (f", while {self.gate} is not zero" if self.gate is not None else "")

    def is_affine(self) -> bool:
        return bool(self.affine)

    @classmethod
    def is_searched(cls) -> bool:
        """Not with states of its own, nor where a guard switches a conductance: no quick look shows what they do."""
        return cls.searched and not cls.states and (cls.section == "sources" or not issubclass(cls, Relay))

    @classmethod
    def places_read(cls) -> tuple[str, ...]:
        """The fields that name places whose mean temperature it depends on."""
        return tuple(name for name, field in cls.fields.items() if isinstance(field, PlaceField))

    @classmethod
    def readings(cls) -> tuple[str, ...]:
        """What it depends on beside inputs and the temperatures it joins: places that it reads, then its states."""
        return (*cls.places_read(), *cls.states)

    def rate(self, u: Inputs, *own: Array) -> tuple[Array, ...]:
        """How fast each of its states grows [unit/s], with the temperatures [°C] and states of `readings`."""
        return ()

    def begin(self, u: Inputs, *T: Array) -> tuple[Array, ...]:
        """What its states begin a run with, at the temperatures of `places_read`: zero."""
        return tuple(np.zeros(()) for _ in self.states)

    def edges(self, duration: float) -> Array:
        """Instants in 0 < t < duration at which the heat jumps or kinks by itself; integration restarts there."""
        return np.empty(0)

    @classmethod
    def proposes(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """In the place of every entry it could replace; what replaces none, wherever it could stand besides."""
        if not cls.replaces:
            yield from cls.besides(machine)
        for _, entry in machine.entries():
            patch = cls.in_place_of(entry, machine) if entry.kind in cls.replaces else None
            if patch is not None:
                yield patch

    @classmethod
    def reading(cls, node: str) -> dict[str, str]:
        """The keys of a proposal that let it read one node."""
        return {cls.fields[field].key: node for field in cls.places_read()}

    @classmethod
    @abstractmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Patches that add it to what is there."""

    @classmethod
    def in_place_of(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """The patch that puts it in the place of an entry, keeping its places and the numbers that `replaces` names;
        None where it cannot stand there."""
        given = cls.take_over(entry, machine)
        if given is None:
            return None
        kept, numbers = entry.to_plain(), cls.replaces[entry.kind]
        own = {cls.fields[ours].key: kept[theirs] for theirs, ours in numbers.items() if theirs in kept}
        keys = {field.key for field in cls.fields.values()} & {"between", "through", "into", "input", "while"}
        where = {key: kept[key] for key in kept if key in keys}
        return {entry.section: {entry.name: {**typical_body(cls), **own, **where, **given}}}

    @classmethod
    def take_over(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """What else it takes from an entry that it could replace; None where it could not."""
        return {}


class Relay(Mechanism):
    """A source, link or stream with two modes, switched by guards. Its heat is the one while it is on; it is zero
    while off."""

    @abstractmethod
    def guard(self, mode: Array, u: Inputs, *own: Array) -> Array:
        """Above zero: time to leave this mode (0 off, 1 on). With the temperatures and states of `readings`."""

    @abstractmethod
    def pause(self) -> Array:
        """Time between the guard and the switching [s]."""

    def levels(self) -> tuple[Place, float, float] | None:
        """The place whose temperature alone switches it, and the levels [°C] at which it goes on and off; None where
        more than that switches it."""
        return None

    def follow(self, mode: str) -> Mapping[str, Any] | None:
        """Its entry in the file were it an input, 0 or 1, that switched it; None where none says that."""
        return None


class Flow(Mechanism):
    """Heat driven by two temperatures."""

    section = "links"

    @property
    @abstractmethod
    def places(self) -> tuple[Place, ...]:
        """The places it joins or passes, in order."""

    @abstractmethod
    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        """Heat from a to b [W], with the temperatures and states in the order of `readings`."""

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, ...]:
        """∂Q/∂T_a and ∂Q/∂T_b [W/K], then by each of its readings; complex step unless an entry knows better."""
        return complex_steps(lambda a, b, *more: self.heat_flow(a, b, u, *more), T_a, T_b, *own)


class Link(Flow):
    """Heat between two places: what one loses, the other gets.

    moves: it reaches the lumps of its second place in shares that its inputs decide; `over` gives the law of each.
    """

    moves: ClassVar[bool] = False
    changed = {"conductance": ("a path that lets more heat through", "a path that lets less heat through")}
    between = places("the two places it joins")

    @property
    def places(self) -> tuple[Place, ...]:
        return self.between

    def over(self, start: float, stop: float) -> Self:
        """What of it goes into the piece of its second place from one fraction to the other."""
        return self

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Between every pair of nodes where it could be missing."""
        for a, b in cls.candidates(machine):
            body = size_body(cls, machine, between=[a, b], **cls.reading(a))
            yield {"links": {fresh(f"{cls.kind} {a} {b}", machine.links): body}}

    @classmethod
    def candidates(cls, machine: MachineLike) -> Iterator[tuple[str, str]]:
        """Pairs of unheld nodes that no such link joins yet; beside a link of any kind an affine one adds nothing
        that the other's conductance could not take over."""
        links = [e for e in machine.links.values() if isinstance(e, Link) and (cls.affine or e.kind == cls.kind)]
        joined = {frozenset(place.node for place in link.between) for link in links}
        for pair in combinations(machine.nodes, 2):
            if frozenset(pair) not in joined and cls.suits(*(machine.nodes[name] for name in pair)):
                yield pair

    @classmethod
    def suits(cls, a: NodeLike, b: NodeLike) -> bool:
        return not (a.is_held or b.is_held)


class SurfaceLink(Link):
    """Heat between a part's surface, named first, and its surroundings."""

    changed = dict.fromkeys(
        ("conductance", "coefficient", "gain"),
        (
            "a surface that is cooled better: more air or coolant passes it",
            "a surface that is cooled worse: a fan or a channel that clogged, or a cover on it",
        ),
    )

    @classmethod
    def candidates(cls, machine: MachineLike) -> Iterator[tuple[str, str]]:
        for a, b in super().candidates(machine):
            yield (b, a) if machine.nodes[a].is_held else (a, b)

    @classmethod
    def suits(cls, a: NodeLike, b: NodeLike) -> bool:
        return bool((a.is_part and b.is_held) or (a.is_held and b.is_part))


class Source(Mechanism):
    """Heat into places by shares; it may read temperatures at places of its own."""

    section = "sources"
    changed = {"power": ("a source that gives more heat", "a source that gives less heat")}
    into = shares("where the heat goes: places with shares that add up to 1")

    @abstractmethod
    def heat(self, u: Inputs, *T: Array) -> Array:
        """Heat delivered [W], with the temperatures [°C] and states in the order of `readings`."""

    def slopes(self, u: Inputs, *T: Array) -> tuple[Array, ...]:
        """∂heat/∂T for each reading [W/K]."""
        return complex_steps(lambda *x: self.heat(u, *x), *T)

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Into every part that has a heat capacity."""
        for name in cls.hosts(machine):
            body = size_body(cls, machine, into={name: 1}, **cls.reading(name))
            yield {"sources": {fresh(f"{cls.kind} {name}", machine.sources): body}}

    @classmethod
    def hosts(cls, machine: MachineLike) -> Iterator[str]:
        return (name for name, node in machine.nodes.items() if node.is_part)


class Stream(Flow):
    """A one-way flow of fluid through places in the order given: each receives from the one before (a), which does not
    lose it.

    cells: well-mixed cells on each leg of it where it has a transport delay."""

    cells: int = 8
    through = places("the places the fluid passes, in that order", None)

    @property
    def places(self) -> tuple[Place, ...]:
        return self.through

    @abstractmethod
    def transport(self) -> tuple[float, float]:
        """Transport delay of the whole stream [s] and capacity flow [W/K]: they make the fluid cells on the way."""

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """From every held node into every part that no stream passes yet."""
        passed = {p.node for e in machine.links.values() if isinstance(e, Stream) for p in e.through}
        for held in (n for n, node in machine.nodes.items() if node.is_held):
            for part in (n for n, node in machine.nodes.items() if node.is_part and n not in passed):
                name = fresh(f"{cls.kind} {held} {part}", machine.links)
                yield {"links": {name: size_body(cls, machine, through=[held, part], **cls.reading(part))}}
