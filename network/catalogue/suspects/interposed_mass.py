from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.fields import Place, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import fresh
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.mechanism import Relay
from network.catalogue.suspects.base import Suspect

SHARE = 0.1
"""Of the heat capacity of what is heated: an element or a sheath."""
LAG = 120.0
"""s: its time constant, which a warm-up shows and the part's own does not hide."""


class InterposedMass(Suspect, kind="interposed_mass"):
    """A part between a source and the part that it heats: C dT_e/dt = q − G (T_e − T), the part gets G (T_e − T).

    The element of a heater, a sheath, a winding in its slot. In the end the part gets all of q, but with a time
    constant C/G, and it goes on getting heat once the source is off; at C = 0 it gets q at once. A hidden_mass takes
    heat from its host instead; a sensor_lag delays the reading alone. `of` names the source, or the part that several
    sources heat. Source: two capacities in series, as in a sheathed thermocouple or heater (Incropera & DeWitt, lumped
    capacitance method; unverified).
    """

    of = place("the source, or the part that sources heat")
    heat_capacity = param("kJ/K", 0, 1e6, "heat capacity of the part in between", positive=True, typical=1)
    conductance = param("W/K", 0, 1e6, "conductance between it and the part it heats", positive=True, typical=10)
    strength = "heat_capacity"
    shapes = ("conductance",)
    sentence = "a part of {heat_capacity} lies between {of} and what it heats, joined by {conductance}"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        """Raises ValueError where `of` names no source that heats one place, and no heated part."""
        sources, to = _find_heated(machine, self.of.node)
        name = fresh(f"part between {self.of.node}", {*machine.nodes, *machine.links})
        link = {"kind": "conduction", "between": [str(to), name], **self.write_numbers("conductance")}
        return {
            "nodes": {name: self.write_numbers("heat_capacity")},
            "links": {name: link},
            "sources": {source.name: _lead_into(source, to, name) for source in sources},
        }

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        """Between every source of one place and its part, and between all sources of a part, where it has several; not
        where one switches, for which instants would have to be searched, nor where nothing changes them: once they
        have been on for long a hidden_mass at the part does the same."""
        for source in _list_sources(machine):
            part = source.into[0][0].node
            is_out = source.is_steady or isinstance(source, Relay)
            if len(source.into) == 1 and machine.nodes[part].is_part and not is_out:
                yield cls._sized(machine, source.name, part)
        for name, node in machine.nodes.items():
            heats = [s for s in _list_sources(machine) if any(p.node == name for p, _ in s.into)]
            is_out = any(isinstance(s, Relay) for s in heats) or all(s.is_steady for s in heats)
            if node.is_part and len(heats) > 1 and name not in machine.sources and not is_out:
                yield cls._sized(machine, name, name)

    @classmethod
    def _sized(cls, machine: MachineLike, of: str, part: str) -> Self:
        C = SHARE * machine.nodes[part].capacity
        return cls(of=Place(of), heat_capacity=C, conductance=C / LAG)

    @classmethod
    def host_in(cls, patch: Mapping[str, Any]) -> Place:
        """The source that is led elsewhere, or the part where these are several."""
        sources = [*patch["sources"]]
        return Place(sources[0]) if len(sources) == 1 else super().host_in(patch)


def _list_sources(machine: MachineLike) -> list[Source]:
    return [source for source in machine.sources.values() if isinstance(source, Source)]


def _find_heated(machine: MachineLike, of: str) -> tuple[list[Source], Place]:
    """The sources that a name means, and the place they heat: a source's own, or all that heat a part."""
    named = machine.sources.get(of)
    if isinstance(named, Source):
        if len(named.into) > 1:
            raise ValueError(f"source {of} heats several places; name the part")
        return [named], named.into[0][0]
    sources = [s for s in _list_sources(machine) if any(p.node == of for p, _ in s.into)]
    if not sources:
        raise ValueError(f"{of} is no source, and no part that a source heats")
    places = {p for s in sources for p, _ in s.into if p.node == of}
    return sources, places.pop() if len(places) == 1 else Place(of)


def _lead_into(source: Source, to: Place, name: str) -> dict[str, Any]:
    """A source whose heat into a part goes into another instead."""
    into: dict[str, float] = {}
    for place_, share in source.into:
        key = name if place_.node == to.node else str(place_)
        into[key] = into.get(key, 0.0) + float(share)
    return {**source.to_plain(), "into": into}
