"""Heat flows: the conventions of sign and spreading, stated once.

Link: heat goes from a to b, −1 for a and +1 for b. Source: +1 for the places it goes into. Stream: 0 for the place
it comes from and +1 for the one it enters. Equations work on arrays of temperatures [°C] and give watts.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from itertools import combinations
from typing import Any, ClassVar, Self, cast

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import Place, places, shares
from network.catalogue.declaration.machine_protocol import MachineLike, NodeLike
from network.catalogue.declaration.proposals import fresh_entry
from network.catalogue.mechanisms.mechanism import Inputs, Mechanism, Relay
from network.catalogue.typical_values import size_body

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


def complex_steps(f: Callable[..., Array], *x: Array) -> tuple[Array, ...]:
    """∂f/∂x for each argument."""
    values = (f(*x[:i], add_imaginary_step(x[i], 1j * STEP), *x[i + 1 :]) for i in range(len(x)))
    return tuple(np.imag(value) / STEP for value in values)


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
    touches: it is where two parts lie on each other, and may rub.
    """

    moves: ClassVar[bool] = False
    touches: ClassVar[bool] = False
    changed = {"conductance": ("a path that lets more heat through", "a path that lets less heat through")}
    between = places("the two places it joins")

    @property
    def places(self) -> tuple[Place, ...]:
        return self.between

    def over(self, start: float, stop: float) -> Self:
        """What of it goes into the piece of its second place from one fraction to the other."""
        return self

    @staticmethod
    def list_moving(machine: MachineLike) -> Iterator[tuple[Place, Place]]:
        """What moves along a bar, and the bar."""
        for link in machine.links.values():
            if isinstance(link, Link) and link.moves:
                moved, bar = link.between
                yield moved, bar

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Between every pair of nodes where it could be missing."""
        for a, b in cls.candidates(machine):
            body = size_body(cls, machine, between=[a, b], **cls.reading(a))
            yield {"links": {fresh_entry(cls.kind, f"{a} {b}", machine.links): body}}

    @classmethod
    def candidates(cls, machine: MachineLike) -> Iterator[tuple[str, str]]:
        """Pairs of unheld nodes that no such link joins yet; beside a link of any kind an affine one adds nothing
        that the other's conductance could not take over."""
        links = [e for e in machine.links.values() if isinstance(e, Link) and (cls.affine or e.kind == cls.kind)]
        joined = {frozenset(place.node for place in link.between) for link in links if cls.takes_all(link)}
        for pair in combinations(machine.nodes, 2):
            if frozenset(pair) not in joined and cls.suits(*(machine.nodes[name] for name in pair)):
                yield pair

    @classmethod
    def takes_all(cls, link: Link) -> bool:
        """Whether a link leaves no room for another one between its parts: a joint is one."""
        return True

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
    def takes_all(cls, link: Link) -> bool:
        """A surface that it covers in part has a rest."""
        return all(place.is_whole for place in link.between)

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

    @property
    def is_steady(self) -> bool:
        """Whether no input, temperature, level or instant of its own changes its heat."""
        return not (isinstance(self, Relay) or self.has_edges() or self.needs() or self.places_read())

    @property
    def may_cool(self) -> bool:
        """Whether it may as well take heat away: where a recorded column drives it, coolant, a valve or a door does."""
        return False

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Into every part that has a heat capacity."""
        for name in cls.hosts(machine):
            body = size_body(cls, machine, into={name: 1}, **cls.reading(name))
            yield {"sources": {fresh_entry(cls.kind, name, machine.sources): body}}

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
        """From every held node that feeds a stream into every part that none passes yet. From another one into a single
        part it would be the law of convection to it, and is proposed as that."""
        streams = [e for e in machine.links.values() if isinstance(e, Stream)]
        passed, feeds = ({p.node for e in streams for p in e.through[:end]} for end in (None, -1))
        for held in (n for n, node in machine.nodes.items() if node.is_held and n in feeds):
            for part in (n for n, node in machine.nodes.items() if node.is_part and n not in passed):
                name = fresh_entry(cls.kind, f"{held} {part}", machine.links)
                yield {"links": {name: size_body(cls, machine, through=[held, part], **cls.reading(part))}}
