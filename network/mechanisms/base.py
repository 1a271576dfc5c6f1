"""Heat flows: the conventions of sign and spreading, stated once.

Link: heat goes from a to b, −1 for a and +1 for b. Source: +1 for the places it goes into. Stream: 0 for the place
it comes from and +1 for the one it enters. Equations work on arrays of temperatures [°C] and give watts.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any, ClassVar, Self, TypeAlias, cast

import numpy as np

from network.declare import Array, Effect, typical_body
from network.fields import PlaceField, places, shares
from network.mechanisms.usual import sized_body
from network.proposals import fresh

Inputs: TypeAlias = Mapping[str, Array]
"""Input channels by name at one instant, in SI (speed in rad/s); `time` in s is among them."""

SPINDLE = {"speed": "rpm"}
FEED = {"feed": "m/min"}
ZERO_CELSIUS = 273.15
STEP = 1e-30


def stepped(x: Array, step: complex | Array) -> Array:
    """x with an imaginary step, for a complex-step derivative; typed as the real array it stands for."""
    return cast(Array, x + step)


def magnitude(x: Array) -> Array:
    """|x| that a complex step passes through."""
    return np.where(np.real(x) < 0, -x, x)


def raised(x: Array, exponent: Array) -> Array:
    """x^p for x ≥ 0, and 0 at x = 0 also where a complex step is in x or p."""
    there = np.real(x) > 0
    return np.where(there, np.where(there, x, 1.0) ** exponent, 0.0)


def not_below_zero(x: Array) -> Array:
    """max(x, 0) that a complex step passes through."""
    return np.where(np.real(x) > 0, x, 0.0)


class Mechanism(Effect):
    """A heat flow. `affine`: with the inputs given, the heat is a linear function of temperatures plus a constant;
    `follows_time`: between its edges the heat still changes with `time` by itself."""

    affine: ClassVar[bool] = True
    follows_time: ClassVar[bool] = False

    def is_affine(self) -> bool:
        return bool(self.affine)

    def edges(self, duration: float) -> Array:
        """Instants in 0 < t < duration at which the heat jumps or kinks by itself; integration restarts there."""
        return np.empty(0)

    @classmethod
    def proposes(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """In the place of every entry it could replace; what replaces none, wherever it could stand besides."""
        if not cls.replaces:
            yield from cls.besides(machine)
        for entry in getattr(machine, cls.section).values():
            patch = cls.in_place_of(entry, machine) if entry.kind in cls.replaces else None
            if patch is not None:
                yield patch

    @classmethod
    @abstractmethod
    def besides(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """Patches that add it to what is there."""

    @classmethod
    def in_place_of(cls, entry: Any, machine: Any) -> Mapping[str, Any] | None:
        """The patch that puts it in the place of an entry, keeping its places and the numbers that `replaces` names;
        None where it cannot stand there."""
        given = cls.taken_from(entry, machine)
        if given is None:
            return None
        kept, numbers = entry.to_plain(), cls.replaces[entry.kind]
        own = {cls.fields[ours].key: kept[theirs] for theirs, ours in numbers.items() if theirs in kept}
        where = {key: kept[key] for key in ("between", "through", "into") if key in kept}
        return {entry.section: {entry.name: {**typical_body(cls), **own, **where, **given}}}

    @classmethod
    def taken_from(cls, entry: Any, machine: Any) -> Mapping[str, Any] | None:
        """What else it takes from an entry that it could replace; None where it could not."""
        return {}


class Flow(Mechanism):
    """Heat driven by two temperatures."""

    section = "links"

    @abstractmethod
    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs) -> Array:
        """Heat from a to b [W]."""

    def slopes(self, T_a: Array, T_b: Array, u: Inputs) -> tuple[Array, Array]:
        """∂Q/∂T_a and ∂Q/∂T_b [W/K]; complex step unless an entry knows better."""
        by_a = np.imag(self.heat_flow(stepped(T_a, 1j * STEP), T_b, u)) / STEP
        by_b = np.imag(self.heat_flow(T_a, stepped(T_b, 1j * STEP), u)) / STEP
        return by_a, by_b


class Link(Flow):
    """Heat between two places: what one loses, the other gets.

    moves: it reaches the lumps of its second place in shares that its inputs decide; `over` gives the law of each.
    """

    moves: ClassVar[bool] = False
    between = places("the two places it joins")

    def over(self, start: float, stop: float) -> Self:
        """What of it goes into the piece of its second place from one fraction to the other."""
        return self

    @classmethod
    def besides(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """Between every pair of nodes where it could be missing."""
        for a, b in cls.candidates(machine):
            body = sized_body(cls, machine, between=[a, b])
            yield {"links": {fresh(f"{cls.kind} {a} {b}", machine.links): body}}

    @classmethod
    def candidates(cls, machine: Any) -> Iterator[tuple[str, str]]:
        """Pairs of unheld nodes that no such link joins yet; beside a link of any kind an affine one adds nothing
        that the other's conductance could not take over."""
        links = [e for e in machine.links.values() if isinstance(e, Link) and (cls.affine or e.kind == cls.kind)]
        joined = {frozenset(place.node for place in link.between) for link in links}
        for pair in combinations(machine.nodes, 2):
            if frozenset(pair) not in joined and cls.suits(*(machine.nodes[name] for name in pair)):
                yield pair

    @classmethod
    def suits(cls, a: Any, b: Any) -> bool:
        return not (a.is_held or b.is_held)


class SurfaceLink(Link):
    """Heat between a part's surface, named first, and its surroundings."""

    @classmethod
    def candidates(cls, machine: Any) -> Iterator[tuple[str, str]]:
        for a, b in super().candidates(machine):
            yield (b, a) if machine.nodes[a].is_held else (a, b)

    @classmethod
    def suits(cls, a: Any, b: Any) -> bool:
        return bool((a.is_part and b.is_held) or (a.is_held and b.is_part))


class Source(Mechanism):
    """Heat into places by shares; it may read temperatures at places of its own."""

    section = "sources"
    into = shares("where the heat goes: places with shares that add up to 1")

    @classmethod
    def readings(cls) -> tuple[str, ...]:
        """The fields that name the places whose mean temperature the heat depends on."""
        return tuple(name for name, field in cls.fields.items() if isinstance(field, PlaceField))

    @abstractmethod
    def heat(self, u: Inputs, *T: Array) -> Array:
        """Heat delivered [W], with the temperatures read [°C] in the order of `readings`."""

    def slopes(self, u: Inputs, *T: Array) -> tuple[Array, ...]:
        """∂heat/∂T for each reading [W/K]."""
        rows = np.eye(len(T)) * STEP * 1j
        heats = (self.heat(u, *(stepped(t, s) for t, s in zip(T, row, strict=True))) for row in rows)
        return tuple(np.imag(heat) / STEP for heat in heats)

    @classmethod
    def besides(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """Into every part that has a heat capacity."""
        for name in cls.hosts(machine):
            extra = {cls.fields[r].key: name for r in cls.readings()}
            body = sized_body(cls, machine, into={name: 1}, **extra)
            yield {"sources": {fresh(f"{cls.kind} {name}", machine.sources): body}}

    @classmethod
    def hosts(cls, machine: Any) -> Iterator[str]:
        return (name for name, node in machine.nodes.items() if node.is_part)


class Relay(Source):
    """A source with two modes, switched by guards. `heat` is the heat while it is on; it is zero while off."""

    @abstractmethod
    def guard(self, mode: Array, u: Inputs, *T: Array) -> Array:
        """Above zero: time to leave this mode (0 off, 1 on)."""

    @abstractmethod
    def pause(self) -> Array:
        """Time between the guard and the switching [s]."""


class Stream(Flow):
    """A one-way flow of fluid through places in the order given: each receives from the one before (a), which does not
    lose it."""

    through = places("the places the fluid passes, in that order", None)

    @abstractmethod
    def transport(self) -> tuple[float, float]:
        """Transport delay of the whole stream [s] and capacity flow [W/K]: they make the fluid cells on the way."""

    @classmethod
    def besides(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """From every held node into every part that no stream passes yet."""
        passed = {p.node for e in machine.links.values() if isinstance(e, Stream) for p in e.through}
        for held in (n for n, node in machine.nodes.items() if node.is_held):
            for part in (n for n, node in machine.nodes.items() if node.is_part and n not in passed):
                name = fresh(f"{cls.kind} {held} {part}", machine.links)
                yield {"links": {name: sized_body(cls, machine, through=[held, part])}}
