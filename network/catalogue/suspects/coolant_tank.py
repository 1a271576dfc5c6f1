from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self, TypeVar

from network.catalogue.declaration.fields import Place, param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import fresh
from network.catalogue.mechanisms.base import Stream
from network.catalogue.suspects.base import Suspect
from network.catalogue.typical_values import links_to, size_value, usual_surroundings

Tank = TypeVar("Tank", bound=Suspect)


class CoolantTank(Suspect, kind="thermostat_cooling"):
    """A coolant of held temperature is a tank whose cooler switches: C dT/dt = heat from the machine − P while on.

    The cooler goes on above set + h and off below set − h, as in the entry thermostat_cooling, and the tank exchanges
    heat with the surroundings. With h → 0 and P above the load it is the held coolant again; a finite h lets every
    part that the coolant washes swing with a period that changes with the load.
    """

    host = place("the node of the coolant, held until now")
    heat_capacity = param("kJ/K", 0, 1e5, "heat capacity: 4.2 kJ/K for a litre of water", positive=True, typical=50)
    set = param("degC", -50, 100, "set point", typical=21)
    hysteresis = param("K", 0, 50, "half width of the hysteresis", positive=True, typical=0.7)
    power = param("W", 0, 1e6, "heat taken while on", typical=800)
    conductance = param("W/K", 0, 1e5, "conductance between tank and surroundings", typical=20)
    strength = "hysteresis"
    shapes = ("set", "power", "heat_capacity", "conductance")
    sentence = "{host} is a tank of {heat_capacity}, cooled by {power} on and off around {set} ± {hysteresis}"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        return put_tank(self, machine, self.host.node, "cooler", self.write_numbers("set", "hysteresis", "power"))

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        yield from suspect_tanks(cls, machine, "power")


def put_tank(of: Suspect, machine: MachineLike, tank: str, title: str, cooler: Mapping[str, Any]) -> dict[str, Any]:
    """The patch that makes a tank of a held node, with surroundings and a cooler of the kind of the suspect."""
    between = [tank, usual_surroundings(machine, besides=tank)]
    around = {"kind": "convection", "between": between, **of.write_numbers("conductance")}
    into = {"kind": of.kind, "into": {tank: 1}, "watches": tank}
    return {
        "nodes": {tank: of.write_numbers("heat_capacity")},
        "links": {fresh(f"{tank} to surroundings", machine.links): around, **_close_streams(machine, tank)},
        "sources": {fresh(f"{tank} {title}", machine.sources): {**into, **cooler}},
    }


def suspect_tanks(cls: type[Tank], machine: MachineLike, cooler: str) -> Iterator[Tank]:
    """Every node held at a constant that is linked to a part, where another held node remains as surroundings; cooler:
    the number that is sized after the machine."""
    held = [name for name, node in machine.nodes.items() if node.is_held]
    for name in held if len(held) > 1 else ():
        temperature = machine.nodes[name].temperature
        if not isinstance(temperature, str) and links_to(machine, name):
            sized = {key: size_value(cls, key, machine) for key in ("heat_capacity", cooler, "conductance")}
            yield cls.typical(host=Place(name), set=float(temperature), **sized)


def _close_streams(machine: MachineLike, tank: str) -> dict[str, Any]:
    """Streams that came from the held coolant, led back into the tank: now it loses what they bring."""
    streams = {name: link for name, link in machine.links.items() if isinstance(link, Stream)}
    return {
        name: {**link.to_plain(), "through": [*map(str, link.through), tank]}
        for name, link in streams.items()
        if link.through[0].node == tank and link.through[-1].node != tank
    }
