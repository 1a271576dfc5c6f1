"""Concealed in what is measured, from an instant on or from the beginning: sensors that fail, lie or are mixed up."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.random import Generator

from proof.assembly import Assembly
from proof.effect import Effect, Setting
from proof.effects_seen import channel_of
from proof.programs import Program
from proof.system import Array


class Failing(Effect):
    """A thermometer that from an instant of one run on reads wrong; `stays`: in the later runs, too."""

    site, kinds = "loose", ("sensor_fault",)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        numbers = {"run": float(rng.integers(3)), "after": float(rng.uniform(0.2, 0.7))}
        stays = {"stays": float(rng.random() < 0.4)}
        return cls(at, float(np.sqrt(cls.bounds[0] * cls.bounds[1])), setting, numbers | stays)

    def begins(self, program: Program, index: int) -> float:
        """s from which it fails; never where it works."""
        failed = int(self.numbers["run"]) % self.setting.runs
        if index == failed:
            return self.numbers["after"] * program.duration
        return 0.0 if index > failed and self.numbers["stays"] else np.inf

    def acts(self, program: Program, index: int) -> list[list[float]]:
        begin = self.begins(program, index)
        return [[begin, program.duration]] if begin < program.duration else []

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        begin = self.begins(program, index)

        def failed(t: Array, rpm: Array, air: Array, reading: Array) -> Array:
            return np.where(t >= begin, self.wrong(t - begin, air, reading), reading)

        build.touches.setdefault(self.at, []).append(failed)

    @abstractmethod
    def wrong(self, since: Array, air: Array, reading: Array) -> Array:
        """What it reads so many seconds after."""

    def places(self) -> list[list[str]]:
        return [[self.at]]


class ComesLoose(Failing):
    """It reads a share of the way towards the air."""

    name, bounds = "sensor_loose", (0.05, 0.9)

    def wrong(self, since: Array, air: Array, reading: Array) -> Array:
        return reading + self.size * (air - reading)


class Jumps(Failing):
    """It reads so many kelvin more."""

    name, bounds = "sensor_jump", (0.2, 6.0)

    def wrong(self, since: Array, air: Array, reading: Array) -> Array:
        return reading + self.size


class Drifts(Failing):
    """It reads so many kelvin an hour more."""

    name, bounds = "sensor_drift", (0.1, 4.0)

    def wrong(self, since: Array, air: Array, reading: Array) -> Array:
        return reading + self.size * since / 3600


class FalseZero(Effect):
    """A thermometer that reads so many kelvin too much all the time."""

    name, site, kinds, bounds = "sensor_offset", "loose", ("sensor_offset",), (0.5, 5.0)
    scales = False

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, float(rng.choice([-1, 1]) * rng.uniform(0.6, 3)), setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.touches.setdefault(self.at, []).append(lambda t, rpm, air, reading: reading + self.size)

    def places(self) -> list[list[str]]:
        return [[self.at]]


class MixedUp(Effect):
    """Two thermometers whose columns are exchanged."""

    name, site, kinds, bounds = "sensor_swap", "swap", ("sensor_swap",), (1.0, 1.0)
    scales = False

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 1.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        a, b = self.at
        build.readings[a], build.readings[b] = build.readings[b], build.readings[a]

    def places(self) -> list[list[str]]:
        return [[self.at[0]], [self.at[1]]]


class LateClock(Effect):
    """All readings are so many seconds late against the schedule."""

    name, site, kinds, bounds = "clock_shift", "clock", ("clock_shift",), (20.0, 400.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 90.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        for name in build.layout.sensors:
            build.touches.setdefault(name, []).append(lambda t, rpm, air, reading: np.interp(t - self.size, t, reading))

    def places(self) -> list[list[str]]:
        return []


class KnockedProbe(Effect):
    """The displacement jumps by so many micrometres at an instant of one run, and stays there."""

    name, site, kinds, bounds = "displacement_step", "spin", ("displacement_step", "sensor_fault"), (0.5, 40.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 5.0, setting, {"run": float(rng.integers(3)), "after": float(rng.uniform(0.25, 0.7))})

    def acts(self, program: Program, index: int) -> list[list[float]]:
        is_here = index == int(self.numbers["run"]) % self.setting.runs
        return [[self.numbers["after"] * program.duration, program.duration]] if is_here else []

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        begin = next((a for a, _ in self.acts(program, index)), np.inf)

        def moved(t: Array, rpm: Array, air: Array, reading: Array) -> Array:
            return np.asarray(reading + self.size * (t >= begin))

        build.touches.setdefault(channel_of(self.setting, self.at), []).append(moved)

    def places(self) -> list[list[str]]:
        return [[f"tcp.{self.at}", channel_of(self.setting, self.at)]]
