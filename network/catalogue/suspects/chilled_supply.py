from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

from network.catalogue.declaration.fields import param, place
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.suspects.base import Suspect
from network.catalogue.suspects.coolant_tank import put_tank, suspect_tanks


class ChilledSupply(Suspect, kind="pi_cooling"):
    """A held supply is a tank under PI control: C dT/dt = heat from the machine − G (e + z), dz/dt = e/t_i.

    e = T − set, as in the entry pi_cooling; the tank exchanges heat with the surroundings. After every step of the load
    the supply leaves its set point by some q/√(C G/t_i) and comes back within about t_i, which a constant coolant never
    does; with t_i → 0 it is the held coolant again. A coolant tank with hysteresis (thermostat_cooling) never rests
    instead. Not looked for by a diagnosis: it keeps a state of its own, whose swing no quick look shows, and beside a
    load that hardly changes it is a constant coolant.
    """

    host = place("the node of the coolant, held until now")
    heat_capacity = param("kJ/K", 0, 1e5, "heat capacity: 4.2 kJ/K for a litre of water", positive=True, typical=50)
    set = param("degC", -50, 100, "set point", typical=21)
    gain = param("W/K", 0, 1e6, "power for each kelvin above the set point", typical=100)
    reset_time = param("s", 0, 36_000, "time in which the integral repeats it", positive=True, typical=600)
    conductance = param("W/K", 0, 1e5, "conductance between tank and surroundings", typical=20)
    strength = "reset_time"
    searched = False
    shapes = ("set", "gain", "heat_capacity", "conductance")
    sentence = "{host} is a tank of {heat_capacity} under PI control at {set}: {gain}, reset time {reset_time}"

    def patch(self, machine: MachineLike) -> Mapping[str, Any]:
        return put_tank(self, machine, self.host.node, "chiller", self.write_numbers("set", "gain", "reset_time"))

    @classmethod
    def suspected(cls, machine: MachineLike) -> Iterator[Self]:
        yield from suspect_tanks(cls, machine, "gain")
