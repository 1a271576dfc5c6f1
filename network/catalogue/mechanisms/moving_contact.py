from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Advice, Array
from network.catalogue.declaration.fields import along, param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.positions import Along, beyond, clip, list_inputs, metres
from network.catalogue.declaration.proposals import fresh_entry
from network.catalogue.mechanisms.base import Link
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.typical_values import size_body


class MovingContact(Link, kind="moving_contact"):
    """A joint that moves along a bar, named last: Q = G w (T_a − T_b) for each lump, w its share of the joint, Σ w = 1.

    The joint is `width` long, its middle where `at` says (a nut on a screw, a carriage on a beam); at an end of the bar
    it stays on it. Where it moves to and fro faster than heat follows, the stroke counts to the width and `at` is the
    middle of the stroke. What enters the bar goes into the lumps under the joint, so it takes lumps to see it. Heat
    that arises in the joint goes into a massless node between two of these links. Source: conduction through a joint,
    its area shared among the lumps it covers.
    """

    conductance = param("W/K", 0, 1e6, "conductance of the whole joint", typical=20)
    at = along("where on the bar the middle of the joint is")
    width = param("m", 0, 1000, "length of the joint along the bar", positive=True, typical=0.1)
    strength = "conductance"
    derived = ("span", "start", "stop")
    moves = True
    span: Array | None
    start: Array
    stop: Array
    sentence = "{between[0]} exchanges heat with {between[1]} at {at} by {conductance} over {width}"

    def resolve(self, machine: MachineLike) -> Self:
        return self.replaced(span=machine.nodes[self.between[1].node].length, start=0.0, stop=1.0)

    def over(self, start: float, stop: float) -> Self:
        return self.replaced(start=start, stop=stop)

    def needs(self) -> Mapping[str, str]:
        return {**super().needs(), **list_inputs(self.at)}

    def faults(self) -> Iterator[Advice]:
        bar = self.between[1]
        if bar.share < 1:
            yield "between", f"{bar} is a part of the bar", f"write {bar.node}: `at` and `width` say where on it"

    def doubts(self) -> Iterator[Advice]:
        for text in self.remarks({}):
            yield "at", text, "name a place on it"

    def remarks(self, u: Mapping[str, Array]) -> Iterator[str]:
        for text in beyond(self.at, u, self.span) if self.span is not None else ():
            yield f"{text} of {self.between[1].node}; the joint stays at its end"

    def _share(self, u: Inputs) -> Array:
        """What of the joint lies over the piece from `start` to `stop`."""
        if self.span is None:
            return np.ones_like(self.conductance)
        width = clip(self.width, 0.0, self.span)
        first = clip(metres(self.at, u, self.span), width / 2, self.span - width / 2) - width / 2
        begin, end = (clip((x * self.span - first) / width, 0.0, 1.0) for x in (self.start, self.stop))
        return np.asarray(end - begin)

    def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
        Q: Array = self.conductance * self._share(u) * (T_a - T_b)
        return Q

    def slopes(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> tuple[Array, Array]:
        G = self.conductance * self._share(u)
        return G, -G

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """Between a bar along which the machine knows something to move, and every part that is not joined with it."""
        known = _moving(machine)
        for pair in cls.candidates(machine):
            for a, bar in (pair, pair[::-1]):
                if bar in known:
                    body = size_body(cls, machine, between=[a, bar], at=known[bar])
                    yield {"links": {fresh_entry(cls.kind, f"{a} {bar}", machine.links): body}}


def _moving(machine: MachineLike) -> dict[str, str]:
    """Bars on which an entry follows a position, and how it is written there."""
    known: dict[str, str] = {}
    for _, entry in machine.entries():
        for name in ("at", "fixed"):
            where = entry.__dict__.get(name)
            if isinstance(where, Along) and where.input:
                place = entry.between[1] if isinstance(entry, Link) else entry.__dict__["of"]
                known.setdefault(place.node, str(where))
    return {bar: where for bar, where in known.items() if machine.nodes[bar].is_bar}
