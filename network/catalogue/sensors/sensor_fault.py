from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, cast

import numpy as np

from network.catalogue.declaration.declare import Advice, Array, typical_body
from network.catalogue.declaration.fields import param, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.declaration.many_units import ManyUnitsField
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.nodes import HeldField
from network.catalogue.sensors.base import SensorEffect
from network.catalogue.typical_values import usual_surroundings
from network.platform.quantities.units import show, unit

SAME_INSTANT = 1e-6
"""s: a sample this close before an end of the window lies on it."""
HOUR = 3600.0
PER_TIME = unit("K/h").dimension


class SizeField(ManyUnitsField):
    """Kelvin, or kelvin per hour."""

    def takes(self, unit_text: str) -> bool:
        return unit(unit_text).dimension == PER_TIME


class SensorFault(SensorEffect, kind="sensor_fault"):
    """A thermometer that fails: reading = T + share (T_air − T) loose, T + size by an offset, T + size · t by a drift.

    loose: a contact that opens, share = G_air/(G_contact + G_air) of the sensor's own conductances, once it has
    settled: 0 is a good contact, 1 a sensor that hangs in the air. offset: a jump of the amplifier or the cold
    junction. drift: `size` per hour (K/h, or K), t the time since `begins`. It may hold between `begins` and `ends`
    only, times of the run; outside the reading is the truth. A fit finds `share` and `size` by slopes; the two times
    have none, for the reading jumps at them: the search without gradients finds them. It changes its own channel only;
    a loss from the part to the air changes the neighbours' readings too. Source: mounting error of a contact
    thermometer (Doebelin, Measurement Systems; unverified).
    """

    quantities = ("temperature",)
    comes_and_goes = True
    shape = word("how it fails", "loose", "offset", "drift", default="loose")
    share = param("1", 0, 1, "how far it reads from its part towards the air", default=None, typical=0.2)
    surroundings: Any = HeldField(
        "degC", -50, 100, "temperature of the air, or the input that has it", None, typical=22
    )
    size = cast(Array, SizeField("K", -1000, 1000, "what it reads too much; of a drift, after each hour", None,
                                 typical=1))  # fmt: skip
    begins = param("min", 0, 1e6, "when it begins to fail", default=0)
    ends = param("min", 0, 1e6, "when it holds again; default not before the end", default=None, positive=True)
    one_of = (("share", "surroundings"), ("size",))
    strength = "share"
    is_steady = False
    sentence = "{channel} {fails}{window}"

    @property
    def fails(self) -> str:
        """What it does, in words."""
        if self.shape == "loose":
            share = self.fields["share"].tell(self.share)
            return f"sits loose and reads {share} of the way from its part to {self.air}"
        size = self.field_of("size").tell(self.size)
        if self.shape == "offset":
            return f"reads {size} too much"
        return f"drifts by {size}{'' if self._is_rate else ' an hour'}"

    @property
    def _is_rate(self) -> bool:
        return unit(getattr(self.field_of("size"), "unit", "K")).dimension == PER_TIME

    @property
    def air(self) -> str:
        return self.surroundings if isinstance(self.surroundings, str) else show(float(self.surroundings), "degC")

    @property
    def window(self) -> str:
        begins = f" from {show(float(self.begins), 'min')} on" if self.begins > 0 else ""
        return begins + (f" until {show(float(self.ends), 'min')}" if self.ends is not None else "")

    def needs(self) -> Mapping[str, str]:
        return {self.surroundings: "degC"} if isinstance(self.surroundings, str) else {}

    def faults(self) -> Iterator[Advice]:
        if self.ends is not None and self.ends <= self.begins:
            yield "ends", "ends before it begins", "give a time after `begins`"
        if self.shape == "loose" and self.share is None:
            yield "size", "has a size, and a loose contact has a share", "write `shape: offset` or `shape: drift`"
        if self.shape != "loose" and self.size is None:
            right = "give its size, like 5 K" if self.shape == "offset" else "give its size per hour, like 0.5 K/h"
            yield "shape", f"has a share, and a fault of shape {self.shape} has a size", right
        if self.shape == "offset" and self.size is not None and self._is_rate:
            yield "size", "grows with time, and an offset stays", "give it in K, or write `shape: drift`"

    def truth(self, reading: Array, u: Inputs) -> Array:
        if self.shape != "loose":
            return reading - self._error(u)
        held: Array = (reading - self.share * self._air(u)) / (1 - self.share)
        return held

    def _air(self, u: Inputs) -> Array:
        return u[self.surroundings] if isinstance(self.surroundings, str) else np.asarray(self.surroundings)

    def _error(self, u: Inputs) -> Array:
        """What an offset or a drift adds where it holds."""
        if self.shape == "offset":
            return np.asarray(self.size)
        rate = self.size if self._is_rate else self.size / HOUR
        return np.asarray(rate * (u["time"] - self.begins))

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        t = np.real(u["time"]) + SAME_INSTANT
        fails = (t >= np.real(self.begins)) & (t < (np.inf if self.ends is None else np.real(self.ends)))
        if self.shape != "loose":
            return truth + fails * self._error(u)
        shown: Array = truth + self.share * fails * (self._air(u) - truth)
        return shown

    @classmethod
    def typical_on(cls, machine: MachineLike) -> dict[str, Any]:
        """Loose all the time, in the air around the machine."""
        around = usual_surroundings(machine)
        held = machine.nodes[around].temperature if around is not None else machine.reference
        return typical_body(cls, surroundings=cls.fields["surroundings"].write(held))
