"""What a measured channel does to the truth: effects act on the reading in the order they are listed."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from itertools import takewhile
from typing import Any, ClassVar, Self

import numpy as np

from network.catalogue.declaration.declare import Array, Effect, typical_body
from network.catalogue.declaration.machine_protocol import MachineLike, SensorLike
from network.catalogue.mechanisms.mechanism import Inputs


class SensorEffect(Effect):
    """One effect between the truth and the reading.

    quantities: what a channel may measure for it to act on; has_state: it keeps a state z of its own, dz/dt = rate;
    comes_and_goes: it may hold for some time and not for some, otherwise in every run (its `truth` is then needed);
    looks_back: what is read depends on the truth at other times; is_steady: the reading follows from truth and state
    alone, at all times, and only then may one with a state come after.
    """

    section = "effects"
    quantities: ClassVar[tuple[str, ...]] = ("temperature", "displacement", "angle")
    has_state: ClassVar[bool] = False
    comes_and_goes: ClassVar[bool] = False
    looks_back: ClassVar[bool] = False
    is_steady: ClassVar[bool] = True

    @property
    def exchanges(self) -> str:
        """The channel whose place its own reads, and the other way round; nothing where it stays."""
        return ""

    @property
    def follows(self) -> str:
        """The channel whose effect of this kind gives it its numbers; nothing where it has its own."""
        return ""

    def take(self, other: Self) -> Self:
        """The same with the numbers of another that it follows."""
        return self

    def rate(self, truth: Array, state: Array) -> Array:
        """dz/dt; only for effects with a state. Linear in both."""
        return np.zeros_like(truth)

    @abstractmethod
    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        """What is read, in the channel's SI unit (°C, m, rad), with the inputs `u` of that instant."""

    def truth(self, reading: Array, u: Inputs) -> Array:
        """What the reading would be without it, where it holds; only for effects without a state."""
        raise NotImplementedError(f"{self.kind} does not say what lies behind a reading")

    @classmethod
    def proposes(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """On every channel that measures a temperature and has none yet."""
        for name, sensor in machine.sensors.items():
            if sensor.place is not None and not any(e.kind == cls.kind for e in sensor.effects):
                yield {"sensors": {name: cls.put_on(sensor, cls.typical_on(machine))}}

    @classmethod
    def put_on(cls, sensor: SensorLike, effect: Mapping[str, Any]) -> dict[str, Any]:
        """The YAML of a channel with one more effect, before the first that is not steady."""
        body = sensor.to_plain()
        effects = list(body.get("effects", []))
        effects.insert(sum(1 for _ in takewhile(lambda one: one.is_steady, sensor.effects)), dict(effect))
        return {**body, "effects": effects}

    @classmethod
    def typical_on(cls, machine: MachineLike) -> dict[str, Any]:
        """The YAML of a typical one on a channel of this machine."""
        return typical_body(cls)
