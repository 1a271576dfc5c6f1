from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.fields import Place, param, place
from network.mechanisms.base import Stream
from network.proposals import fresh
from network.suspects.base import Suspect


class CoolantTank(Suspect, kind="thermostat_cooling"):
    """A coolant of held temperature is a tank whose cooler switches: C dT/dt = heat from the machine − P while on.

    The cooler goes on above set + h and off below set − h, as in the entry thermostat_cooling, and the tank exchanges
    heat with the surroundings. With h → 0 and P above the load it is the held coolant again; a finite h lets every
    part that the coolant washes swing with a period that changes with the load.
    """

    host = place("the node of the coolant, held until now")
    heat_capacity = param("kJ/K", 0, 1e5, "heat capacity of the tank: 4.2 kJ/K for a litre of water", typical=50)
    set = param("degC", -50, 100, "set point", typical=21)
    hysteresis = param("K", 0, 50, "half width of the hysteresis", positive=True, typical=0.7)
    power = param("W", 0, 1e6, "heat taken while on", typical=800)
    conductance = param("W/K", 0, 1e5, "conductance between tank and surroundings", typical=20)
    strength = "hysteresis"
    looks_like = ("timed_source", "advection")
    sentence = "{host} is a tank of {heat_capacity}, cooled by {power} on and off around {set} ± {hysteresis}"

    def patch(self, machine: Any) -> Mapping[str, Any]:
        tank = self.host.node
        cooler = {"kind": "thermostat_cooling", "into": {tank: 1}, "watches": tank}
        cooler |= self.written("set", "hysteresis", "power")
        around = {"kind": "convection", "between": [tank, _surroundings(machine, tank)], **self.written("conductance")}
        links = {fresh(f"{tank} to surroundings", machine.links): around}
        return {
            "nodes": {tank: self.written("heat_capacity")},
            "links": {**links, **_closed_streams(machine, tank)},
            "sources": {fresh(f"{tank} cooler", machine.sources): cooler},
        }

    @classmethod
    def suspected(cls, machine: Any) -> Iterator[Self]:
        """Every node held at a constant that is linked to a part, where another held node remains as surroundings."""
        held = [name for name, node in machine.nodes.items() if node.is_held]
        for name in held:
            constant = not isinstance(machine.nodes[name].temperature, str)
            if constant and len(held) > 1 and _degree(machine, name):
                yield cls.typical(host=Place(name), set=float(machine.nodes[name].temperature))


def _degree(machine: Any, name: str) -> int:
    return sum(place.node == name for link in machine.links.values() for place in _places(link))


def _places(link: Any) -> tuple[Place, ...]:
    places: tuple[Place, ...] = link.through if isinstance(link, Stream) else link.between
    return places


def _surroundings(machine: Any, tank: str) -> str:
    """The other held node that most links lead to."""
    others = [name for name, node in machine.nodes.items() if node.is_held and name != tank]
    return str(max(others, key=lambda name: _degree(machine, name)))


def _closed_streams(machine: Any, tank: str) -> dict[str, Any]:
    """Streams that came from the held coolant, led back into the tank: now it loses what they bring."""
    streams = {name: link for name, link in machine.links.items() if isinstance(link, Stream)}
    return {
        name: {**link.to_plain(), "through": [*map(str, link.through), tank]}
        for name, link in streams.items()
        if link.through[0].node == tank and link.through[-1].node != tank
    }
