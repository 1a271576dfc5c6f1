"""A heat flow: what every kind of it may declare, what it reads, and where it could be missing; relays among them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, TypeAlias

import numpy as np

from network.catalogue.declaration.declare import Array, Effect, typical_body
from network.catalogue.declaration.fields import ANY, Place, PlaceField, channel
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike

Inputs: TypeAlias = Mapping[str, Array]
"""Input channels by name at one instant, in SI (speed in rad/s); `time` in s is among them."""


@dataclass(frozen=True)
class State:
    """A number of its own that an entry carries through a run, like an integral. Its unit is one of SI."""

    unit: str
    meaning: str


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
    @cache
    def places_read(cls) -> tuple[str, ...]:
        """The fields that name places whose mean temperature it depends on."""
        return tuple(name for name, field in cls.fields.items() if isinstance(field, PlaceField))

    @classmethod
    @cache
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
    def has_edges(cls) -> bool:
        """Whether its law has such instants."""
        return cls.edges is not Mechanism.edges

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


def beyond(mode: Array, T: Array, middle: Array, half_width: Array) -> Array:
    """The guard of a hysteresis: on above its middle + half width, off below its middle − half width."""
    return np.asarray(np.where(mode > 0, -1.0, 1.0) * (T - middle) - half_width)


class Relay(Mechanism):
    """A source, link or stream with two modes, switched by guards. Its heat is the one while it is on; it is zero
    while off. drawn: whether a diagnosis looks for it at levels it draws, too, where nothing tells its instants."""

    drawn: ClassVar[bool] = True

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

    def keep_between(self, low: float, high: float) -> Mapping[str, Any]:
        """The keys of its entry that keep what it watches between two temperatures [°C]; none where none do."""
        return {}

    def follow(self, mode: str) -> Mapping[str, Any] | None:
        """Its entry in the file were it an input, 0 or 1, that switched it; None where none says that."""
        return None
