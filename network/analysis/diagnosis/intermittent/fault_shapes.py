"""How a reading fails from an instant on: by an offset, by a drift, towards the air; a displacement by a step.

A fault of size s that began at t0 adds s e(t), e what a fault of unit size adds: 1 (offset, step), t − t0 (drift), or
what full strength would add, T_air − T (loose). Source: as of the kinds that they are called by.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.intermittent.change_points import SHARES
from network.analysis.diagnosis.intermittent.channel_samples import at_share, change_of, effect_of
from network.catalogue.declaration.declare import Array
from network.catalogue.expansions.base import LINEAR_AXES
from network.catalogue.expansions.displacement_step import DisplacementStep
from network.catalogue.sensors.base import SensorEffect
from network.catalogue.sensors.sensor_fault import HOUR, SensorFault
from network.platform.quantities.number_format import format_amount
from network.platform.quantities.units import show
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class FaultShape(ABC):
    """A way in which one channel fails. kind, section: of what it is called; may_stay: whether later runs may have it,
    too; may_jump: whether the reading jumps when it begins; key, unit: of its size."""

    channel: str
    kind: ClassVar[str] = SensorFault.kind
    section: ClassVar[str] = "sensors"
    may_stay: ClassVar[bool] = True
    may_jump: ClassVar[bool] = True
    key: ClassVar[str] = "size"
    unit: ClassVar[str] = "K"

    def full(self, recording: Recording, truth: Array) -> Array:
        """What full strength adds to the reading at each sample, beside how long it lasts."""
        return np.ones_like(truth)

    def last(self, t: Array, t0: float, full: Array) -> Array:
        """What a fault of unit size that begins at t0 [s] adds at instants t [s]."""
        return np.asarray(full * (t >= t0))

    def set_right(self, recording: Recording, values: Array, t0: float, size: float) -> Array:
        """The readings without it."""
        return np.asarray(values - size * self.last(recording.t, t0, self.full(recording, values)))

    def add(self, size: float, more: float) -> float:
        """The size of a fault, where readings that were set right by one size show another one, beside it."""
        return size + more

    def allows(self, size: float) -> bool:
        """Whether it can be of that size."""
        return bool(np.isfinite(size))

    @abstractmethod
    def tell(self, size: float) -> str:
        """What the channel does, in words."""

    def describe_effect(self, size: float) -> Mapping[str, Any]:
        """The YAML of the effect of a sensor that goes on like this."""
        return {"kind": self.kind, "shape": type(self).__name__.lower(), self.key: show(size, self.unit)}


@dataclass(frozen=True, eq=False)
class Offset(FaultShape):
    """A thermometer that reads so many kelvin more."""

    def tell(self, size: float) -> str:
        return f"{self.channel} reads {format_amount(abs(size), 'K')} too {'much' if size > 0 else 'little'}"


@dataclass(frozen=True, eq=False)
class Drift(FaultShape):
    """A thermometer that reads ever more; size: per second."""

    may_jump = False
    unit = "K/h"

    def last(self, t: Array, t0: float, full: Array) -> Array:
        return np.asarray(full * np.maximum(t - max(t0, float(t[0])), 0.0))

    def tell(self, size: float) -> str:
        return f"{self.channel} drifts by {size * HOUR:.3g} K an hour"


@dataclass(frozen=True, eq=False)
class Loose(FaultShape):
    """A thermometer that reads a share of the way towards the air; hanging: that effect, of the whole way."""

    hanging: SensorEffect
    key = "share"
    unit = "1"

    def full(self, recording: Recording, truth: Array) -> Array:
        return change_of(self.hanging, recording, truth)

    def set_right(self, recording: Recording, values: Array, t0: float, size: float) -> Array:
        towards = self.full(recording, values) / (1 - size)
        return np.asarray(values - size * self.last(recording.t, t0, towards))

    def add(self, size: float, more: float) -> float:
        return size + (1 - size) * more

    def allows(self, size: float) -> bool:
        return SHARES[0] < size < SHARES[1]

    def describe_effect(self, size: float) -> Mapping[str, Any]:
        return {**self.hanging.to_plain(), self.key: show(size, self.unit)}

    def tell(self, size: float) -> str:
        return f"{self.channel} sits loose and reads {size:.2g} of the way from its part to the air"


@dataclass(frozen=True, eq=False)
class Step(FaultShape):
    """A displacement that jumps and stays."""

    kind = DisplacementStep.kind
    section = "tcp"
    may_stay = False
    unit = "um"

    def tell(self, size: float) -> str:
        return f"{self.channel} jumps by {show(size, 'um')}"


def list_shapes(h: Hypothesis) -> Iterator[FaultShape]:
    """All ways in which a channel of a machine could fail from an instant on."""
    loose = {c.channels[0]: c for c in candidates(h.machine, h.case.drivers, among=[SensorFault])}
    for name, sensor in h.machine.sensors.items():
        if sensor.quantity == "temperature":
            yield from (Offset(name), Drift(name))
            if name in loose:
                yield Loose(name, effect_of(at_share(loose[name], 1.0), loose[name]))
        elif sensor.axis in LINEAR_AXES:
            yield Step(name)
