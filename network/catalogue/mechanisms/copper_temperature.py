from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param, place
from network.catalogue.declaration.machine_protocol import EntryLike, MachineLike
from network.catalogue.declaration.proposals import fresh_entry
from network.catalogue.mechanisms.base import Source
from network.catalogue.mechanisms.heat_source import HeatSource
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.mechanisms.motor_loss import MotorLoss
from network.platform.quantities.number_format import per_kelvin


class CopperTemperature(Source, kind="copper_temperature"):
    """Copper loss that grows with the winding's temperature: q = P (1 + a (T − T_ref)) while |n| > 0.

    P is the loss at the machine's reference, at constant current. For copper a = 1/(234.5 + T_ref/°C), 0.00393 1/K at
    20 °C (IEC 60028). The winding's temperature is read at the first place of `into` unless `reads` says otherwise.
    """

    power = param("W", 0, 1e6, "copper loss while running, at the reference temperature", typical=100)
    slope = param("1/K", 0, 0.02, "growth of the loss per kelvin", typical=0.0039)
    reads = place("where the winding's temperature is read; default the first place of `into`", default=None)
    input = channel("speed", "rpm")
    strength = "slope"
    replaces = {"motor_loss": {"copper": "power"}, "heat_source": {"power": "power"}}
    derived = ("cold",)
    cold: float
    sentence = "the copper loss of {power} in {into} grows by {percent} as {reads} warms"

    @property
    def percent(self) -> str:
        """The slope in words."""
        return per_kelvin(float(self.slope))

    def resolve(self, machine: MachineLike) -> Self:
        reads = self.reads if self.reads is not None else self.into[0][0]
        return self.replaced(reads=reads, cold=machine.reference)

    def heat(self, u: Inputs, *T: Array) -> Array:
        q: Array = self.power * (1 + self.slope * (T[0] - self.cold)) * (u[self.input] != 0)
        return q

    def slopes(self, u: Inputs, *T: Array) -> tuple[Array, ...]:
        slope: Array = self.power * self.slope * (u[self.input] != 0)
        return (slope * np.ones_like(T[0]),)

    @classmethod
    def take_over(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """Of copper loss, and of constant heat while the spindle runs."""
        if isinstance(entry, MotorLoss):
            return {} if entry.copper > 0 else None
        runs = isinstance(entry, HeatSource) and entry.driver == "running" and entry.power > 0
        return {} if runs else None

    @classmethod
    def in_place_of(cls, entry: EntryLike, machine: MachineLike) -> Mapping[str, Any] | None:
        """Beside a motor, which keeps its iron loss."""
        patch = super().in_place_of(entry, machine)
        if patch is None or not isinstance(entry, MotorLoss):
            return patch
        other = fresh_entry(cls.kind, entry.name, machine.sources)
        return {cls.section: {entry.name: {**entry.to_plain(), "copper": "0 W"}, other: patch[cls.section][entry.name]}}
