"""Flows and sources of one class side by side: what a network is made of. Entries of equal structure share one call."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import ClassVar, Generic, TypeVar, cast

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.base import Link, Source, Stream, complex_steps
from network.catalogue.mechanisms.mechanism import Inputs, Mechanism

Law_co = TypeVar("Law_co", bound=Mechanism, covariant=True)
Item = TypeVar("Item")


@dataclass(frozen=True)
class Flows:
    """Elementary flows of one class, side by side: E flows of weight w[e] from lump a[e] to lump b[e].

    one_way: a stream; the lump a does not lose what b gets. entry[e]: index into Network.mechanisms; reads: what the
    law depends on besides (one E×N matrix for each reading); relay[e]: the relay in whose modes it flows, if any.
    """

    law: Link | Stream
    a: Indices
    b: Indices
    w: Array
    entry: Indices
    one_way: bool
    size: int
    reads: tuple[Array, ...] = ()
    relay: Indices | None = None

    def heat_flow(self, T: Array, u: Inputs) -> Array:
        """Heat of every flow by its law, with the temperatures of all lumps (…, N), before its weight."""
        heat = self.law.heat_flow(T[..., self.a], T[..., self.b], u, *(T @ R.T for R in self.reads))
        return self.law.let_pass(heat, u)

    def slopes(self, T: Array, u: Inputs) -> tuple[Array, ...]:
        """Slopes of its law by both temperatures and every reading, before its weight."""
        slopes = self.law.slopes(T[..., self.a], T[..., self.b], u, *(T @ R.T for R in self.reads))
        return tuple(self.law.let_pass(slope, u) for slope in slopes)

    def some(self, members: Indices) -> Flows:
        """Some of them."""
        return replace(
            self, law=self.law.some(members), a=self.a[members], b=self.b[members], w=self.w[members],
            entry=self.entry[members], reads=tuple(R[members] for R in self.reads),
            relay=None if self.relay is None else self.relay[members],
        )  # fmt: skip

    @cached_property
    def spread(self) -> Array:
        """E×N: what a watt of each flow does to every lump: −1 at a (0 for a stream), +1 at b."""
        matrix = np.zeros((len(self.a), self.size))
        matrix[np.arange(len(self.b)), self.b] = 1.0
        if not self.one_way:
            matrix[np.arange(len(self.a)), self.a] = -1.0
        return matrix


@dataclass(frozen=True)
class Heats(Generic[Law_co]):
    """Sources of one class, side by side: n entries, their heat spread by `into` (N×n), their readings by `reads`
    (one n×N matrix for each reading field)."""

    law: Law_co
    into: Array
    reads: tuple[Array, ...]
    entry: Indices
    is_heat: ClassVar[bool] = True

    def heat(self, u: Inputs, *own: Array) -> Array:
        """What every entry gives, with what it reads."""
        return self.law.let_pass(cast(Source, self.law).heat(u, *own), u)

    def slopes(self, u: Inputs, *own: Array) -> tuple[Array, ...]:
        return tuple(self.law.let_pass(slope, u) for slope in cast(Source, self.law).slopes(u, *own))


@dataclass(frozen=True)
class Rates(Heats[Law_co]):
    """How fast a state of some entries grows: a heat into a lump of capacity 1 that stands for the state."""

    state: int = 0
    is_heat: ClassVar[bool] = False

    def heat(self, u: Inputs, *own: Array) -> Array:
        return self.law.let_pass(self.law.rate(u, *own)[self.state], u)

    def slopes(self, u: Inputs, *own: Array) -> tuple[Array, ...]:
        return complex_steps(lambda *x: self.heat(u, *x), *own)

    def first(self, u: Inputs, T: Array) -> tuple[Indices, Array]:
        """The lumps of the state, and what it begins with at the temperatures of all lumps."""
        seen = self.reads[: len(self.law.places_read())]
        return np.argmax(self.into, axis=0), self.law.begin(u, *(R @ T for R in seen))[self.state]


@dataclass(frozen=True)
class Guards(Heats[Law_co]):
    """What switches some links or streams: relays that give no heat of their own, their flows do."""

    is_heat: ClassVar[bool] = False

    def heat(self, u: Inputs, *own: Array) -> Array:
        return np.zeros(self.into.shape[1])

    def slopes(self, u: Inputs, *own: Array) -> tuple[Array, ...]:
        return tuple(np.zeros(self.into.shape[1]) for _ in own)


def group_by_structure(items: Iterable[Item], law_of: object) -> Iterator[list[Item]]:
    """Items whose laws have equal structure, in the order of the structures' names."""
    assert callable(law_of)
    told: dict[int, str] = {}  # the lumps of a link share its law
    keyed = [(_tell_structure(law_of(item), told), item) for item in items]
    for _, members in groupby(sorted(keyed, key=lambda pair: pair[0]), key=lambda pair: pair[0]):
        yield [item for _, item in members]


def _tell_structure(law: Mechanism, told: dict[int, str]) -> str:
    if id(law) not in told:
        told[id(law)] = repr(law.structure())
    return told[id(law)]
