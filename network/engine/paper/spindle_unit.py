"""The spindle unit of the paper's closed form: which parts belong to it, what it loses heat through, what heats it.

The roles of `closed_form:` name the spindle and the beam. The unit is every part and junction that links join to the
spindle without passing the beam, a held node, or a part that a stream carries heat away from (coolant). All its parts
have one temperature T̄; the beam, held nodes and coolant have given ones. Junctions are eliminated exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.base import Link, Source, Stream
from network.catalogue.mechanisms.mechanism import Inputs, Mechanism, Relay
from network.machine.machine import Machine
from network.platform.refusal import Spot, refuse, short

EXCESS = 10.0
"""K over the reference: where the conductance of a link is taken that is not linear in temperature."""


@dataclass(frozen=True, eq=False)
class SpindleUnit:
    """The parts that play the roles. beam: None where the machine names none; parts, junctions: of the unit."""

    machine: Machine
    spindle: str
    beam: str | None
    parts: tuple[str, ...]
    junctions: tuple[str, ...]

    @classmethod
    def of(cls, machine: Machine) -> SpindleUnit:
        """Raises Refused where the machine does not say which parts play the roles."""
        spot, roles = Spot(machine.file), machine.closed_form
        if "spindle" not in roles:
            wrong = "the paper's closed form needs to know which part is the spindle"
            names = ", ".join(name for name, node in machine.nodes.items() if node.is_part)
            right = f"write `closed_form: {{spindle: …, beam: …}}`; the parts are {short(names, 200)}"
            raise refuse(spot, wrong, right)
        for role, name in roles.items():
            if not machine.nodes[name].is_part:
                raise refuse(spot, f"closed_form.{role}: {name} has no heat capacity", "name a part")
        if roles.get("beam") == roles["spindle"]:
            raise refuse(spot, f"closed_form: {roles['spindle']} is both spindle and beam", "name two parts")
        spindle, beam = roles["spindle"], roles.get("beam")
        inside = _find_connected(machine, spindle, beam)
        unit = {name: node.is_part for name, node in machine.nodes.items() if name in inside}
        return cls(machine, spindle, beam, *(tuple(n for n in unit if unit[n] is part) for part in (True, False)))

    @cached_property
    def heat_capacity(self) -> float:
        """C₁ of eq. 14 [J/K]."""
        return sum(self.machine.nodes[name].capacity for name in self.parts)

    @property
    def sources(self) -> Mapping[str, Source]:
        """Sources that heat the unit or the beam; relays, which the paper leaves out, are not among them."""
        near = {*self.parts, *self.junctions, self.beam}
        entries = self.machine.sources.items()
        return {n: s for n, s in entries if not isinstance(s, Relay) and any(p.node in near for p, _ in s.into)}

    def heats(self, u: Inputs) -> Array:
        """Heat of the sources into every node at K instants, (K, nodes); what depends on temperature is taken at the
        reference."""
        q, index = np.zeros((len(u["time"]), len(self.machine.nodes))), _index(self.machine)
        for source in self.sources.values():
            heat = source.heat(u, *_at_reference(self.machine, source))
            for place, share in source.into:
                q[:, index[place.node]] += share * heat
        return q

    def conductances(self, u: Inputs) -> tuple[Array, Indices]:
        """Heat into node i is Σ K_ij T_j + q_i: the distinct K (regimes, nodes, nodes) over links and streams that
        touch the unit, and which of them holds at each of K instants."""
        index, touched = _index(self.machine), {*self.parts, *self.junctions}
        always = (pair for pair in _pairs(self.machine) if not isinstance(pair[0], Relay))
        pairs = [pair for pair in always if {pair[1], pair[2]} & touched]
        rows = [_conductance(self.machine, entry, u) * np.ones(len(u["time"])) for entry, _, _ in pairs]
        G = np.array(rows).reshape(len(pairs), len(u["time"])).T
        if np.ptp(G, axis=0).any():
            distinct, regime_of = np.unique(G, axis=0, return_inverse=True)
        else:
            distinct, regime_of = G[:1], np.zeros(len(G), int)
        K = np.zeros((len(distinct), len(index), len(index)))
        for (entry, a, b), g in zip(pairs, distinct.T, strict=True):
            i, j = index[a], index[b]
            K[:, j, i] += g
            K[:, j, j] -= g
            if isinstance(entry, Link):
                K[:, i, j] += g
                K[:, i, i] -= g
        return K, np.ravel(regime_of)

    def list_linearised(self) -> Iterator[str]:
        """Entries of the unit that are not linear in temperature, and what is taken instead."""
        touched = {*self.parts, *self.junctions}
        for entry, a, b in _pairs(self.machine):
            if {a, b} & touched and not entry.is_affine():
                yield f"links.{entry.name}: conductance at {EXCESS:g} K over the reference"
        for name, source in self.sources.items():
            if source.readings():
                yield f"sources.{name}: heat at the reference"


def _index(machine: Machine) -> dict[str, int]:
    return {name: i for i, name in enumerate(machine.nodes)}


def _pairs(machine: Machine) -> Iterator[tuple[Link | Stream, str, str]]:
    """Every link, and every leg of a stream, with the nodes it runs between."""
    for link in machine.links.values():
        yield from ((link, a.node, b.node) for a, b in pairwise(link.places) if a.node != b.node)


def _find_connected(machine: Machine, first: str, beam: str | None) -> set[str]:
    """The nodes that links join to the first one, not passing the beam, a held node or a part in a stream."""
    coolant = {name for entry, a, b in _pairs(machine) if isinstance(entry, Stream) for name in (a, b)}
    nodes = machine.nodes.items()
    closed = {beam} | {name for name, node in nodes if node.is_held or (node.is_part and name in coolant)}
    connected, new = {first}, [first]
    while new:
        here = new.pop()
        for entry, a, b in _pairs(machine):
            if isinstance(entry, Link) and here in (a, b):
                beyond = {a, b} - connected - closed
                connected |= beyond
                new.extend(beyond)
    return connected


def _conductance(machine: Machine, entry: Link | Stream, u: Inputs) -> Array:
    """W/K at the inputs; of a link that is not linear, the secant over EXCESS."""
    cold = np.array(machine.reference)
    return np.asarray(entry.heat_flow(cold + EXCESS, cold, u, *_at_reference(machine, entry)) / EXCESS)


def _at_reference(machine: Machine, entry: Mechanism) -> list[Array]:
    """What an entry reads when everything is at the reference and its states are zero."""
    return [np.array(0.0 if name in entry.states else machine.reference) for name in entry.readings()]
