from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param, place, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.proposals import set_in_each
from network.catalogue.mechanisms.base import ZERO_CELSIUS, Source
from network.catalogue.mechanisms.mechanism import Inputs


class Thermoelectric(Source, kind="thermoelectric"):
    """One side of a Peltier module: q = N (I² r/2 − s I T) on its cold side, N (I² r/2 + s I T) on its hot one, T in K.

    N couples in series, each of Seebeck coefficient s and resistance r, half of whose Joule heat goes either way; what
    the module conducts is a conduction between both places, N k. Both sides together bring N (I² r + s I (T_h − T_c)),
    the electric power. A current below zero pumps the other way. For s, r and k constant over the temperatures of the
    module, and no losses in leads. Source: Ioffe's equations (Rowe, CRC Handbook of Thermoelectrics; unverified).
    Bismuth telluride has s = 0.4 mV/K, r = 10 to 20 mohm, k = 4 mW/K a couple. Not looked for by a diagnosis: a
    recorded current is tried as a heat_source, in proportion and squared, and T in K hardly changes: both together tell
    a module to a per cent of its heat.
    """

    side = word("which side of the module this is", "cold", "hot")
    junction = place("the place whose temperature that side has")
    couples = param("1", 0, 1e4, "couples in series", typical=127)
    seebeck = param("mV/K", -10, 10, "Seebeck coefficient of a couple", typical=0.4)
    resistance = param("mohm", 0, 1e4, "electric resistance of a couple", typical=15)
    input = channel("current", "A")
    strength = "couples"
    searched = False
    shapes = ("seebeck", "resistance")
    sentence = "{into} is the {side} side of a Peltier module of {couples} couples, {seebeck} and {resistance} each"

    def heat(self, u: Inputs, *T: Array) -> Array:
        current, way = u[self.input], 1 if self.side == "hot" else -1
        peltier = way * self.seebeck * current * (T[0] + ZERO_CELSIUS)
        return np.asarray(self.couples * (current**2 * self.resistance / 2 + peltier))

    @classmethod
    def besides(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """The cold side, on every part."""
        return set_in_each(super().besides(machine), side="cold")
