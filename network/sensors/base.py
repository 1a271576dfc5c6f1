"""What a measured channel does to the truth: effects act on the reading in the order they are listed."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from network.declare import Array, Effect, typical_body


class SensorEffect(Effect):
    """One effect between the truth and the reading. `has_state`: it keeps a state z of its own, dz/dt = rate."""

    section = "effects"
    has_state: ClassVar[bool] = False

    def rate(self, truth: Array, state: Array) -> Array:
        """dz/dt; only for effects with a state. Linear in both."""
        return np.zeros_like(truth)

    @abstractmethod
    def reading(self, truth: Array, state: Array) -> Array:
        """What is read, in the channel's SI unit (°C, m, rad)."""

    @classmethod
    def proposes(cls, machine: Any) -> Iterator[Mapping[str, Any]]:
        """On every channel that measures a temperature."""
        for name, sensor in machine.sensors.items():
            if sensor.place is not None and not any(e.kind == cls.kind for e in sensor.effects):
                body = sensor.to_plain()
                effects = [*body.get("effects", []), typical_body(cls)]
                yield {"sensors": {name: {**body, "effects": effects}}}
