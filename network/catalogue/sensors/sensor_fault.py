from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Advice, Array, typical_body
from network.catalogue.declaration.fields import REQUIRED, param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.mechanisms.base import Inputs
from network.catalogue.nodes import HeldField
from network.catalogue.sensors.base import SensorEffect
from network.catalogue.typical_values import usual_surroundings
from network.platform.quantities.units import show

SAME_INSTANT = 1e-6
"""s: a sample this close before an end of the window lies on it."""


class SensorFault(SensorEffect, kind="sensor_fault"):
    """A loose contact: the sensor reads between its part and the air, reading = T + share (T_air − T).

    share = G_air/(G_contact + G_air) of the sensor's own conductances, once it has settled: 0 is a good contact, 1 a
    sensor that hangs in the air. It may hold between `begins` and `ends` only, times of the run, and is constant there;
    outside the reading is the truth. A fit finds `share` by slopes and the two times on a grid, for the reading jumps
    at them. It changes its own channel only; a loss from the part to the air changes the neighbours' readings too.
    Source: mounting error of a contact thermometer (Doebelin, Measurement Systems; unverified).
    """

    quantities = ("temperature",)
    comes_and_goes = True
    share = param("1", 0, 1, "how far it reads from its part towards the air", typical=0.2)
    surroundings: Any = HeldField(
        "degC", -50, 100, "temperature of the air, or the input that has it", REQUIRED, typical=22
    )
    begins = param("min", 0, 1e6, "when it comes loose", default=0)
    ends = param("min", 0, 1e6, "when it holds again; default not before the end", default=None, positive=True)
    strength = "share"
    sentence = "{channel} sits loose and reads {share} of the way from its part to {air}{window}"

    @property
    def air(self) -> str:
        return self.surroundings if isinstance(self.surroundings, str) else show(float(self.surroundings), "degC")

    @property
    def window(self) -> str:
        begins = f" from {show(float(self.begins), 'min')} on" if self.begins > 0 else ""
        return begins + (f" until {show(float(self.ends), 'min')}" if self.ends is not None else "")

    def is_steady(self) -> bool:
        return False

    def needs(self) -> Mapping[str, str]:
        return {self.surroundings: "degC"} if isinstance(self.surroundings, str) else {}

    def faults(self) -> Iterator[Advice]:
        if self.ends is not None and self.ends <= self.begins:
            yield "ends", "ends before it begins", "give a time after `begins`"

    def truth(self, reading: Array, u: Inputs) -> Array:
        held: Array = (reading - self.share * self._air(u)) / (1 - self.share)
        return held

    def _air(self, u: Inputs) -> Array:
        return u[self.surroundings] if isinstance(self.surroundings, str) else np.asarray(self.surroundings)

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        air = self._air(u)
        t = np.real(u["time"]) + SAME_INSTANT
        loose = (t >= np.real(self.begins)) & (t < (np.inf if self.ends is None else np.real(self.ends)))
        shown: Array = truth + self.share * loose * (air - truth)
        return shown

    @classmethod
    def typical_on(cls, machine: MachineLike) -> dict[str, Any]:
        """Loose all the time, in the air around the machine."""
        around = usual_surroundings(machine)
        held = machine.nodes[around].temperature if around is not None else machine.reference
        return typical_body(cls, surroundings=cls.fields["surroundings"].write(held))
