"""Concealed in what is measured: a tilt, growth under centrifugal load, a slow sensor, a sensor that sits loose."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.random import Generator

from proof.assembly import Assembly
from proof.effect import Effect, Setting
from proof.programs import Program
from proof.system import Array


def channel_of(setting: Setting, axis: str) -> str:
    return next(name for name, place in setting.layout.sensors.items() if place == f"tcp.{axis}")


class HeadTilt(Effect):
    """The difference of two parts' mean temperatures moves the tool [µm/K] along an axis."""

    name, site, kinds, bounds = "tilt", "tilt", ("tilt", "bending"), (0.2, 12.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 2.0, setting, {"direction": float(rng.choice([-1, 1]))})

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        axis, a, b = self.at
        row = build.readings[channel_of(self.setting, axis)]
        for part, sign in ((a, 1.0), (b, -1.0)):
            for cell, w in build.at(part).items():
                row[cell] = row.get(cell, 0.0) + sign * w * self.size * self.numbers["direction"]

    def places(self) -> list[list[str]]:
        axis, a, b = self.at
        return [[f"tcp.{axis}", channel_of(self.setting, axis)], [a, b]]


class SpinGrowth(Effect):
    """The tool moves at once with the square of speed [µm at top speed]."""

    name, site, kinds, bounds = "centrifugal_growth", "spin", ("centrifugal_growth",), (0.5, 40.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 6.0, setting, {"direction": float(rng.choice([-1, 1]))})

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        top, d = build.layout.top_speed, self.size * self.numbers["direction"]

        def moved(t: Array, rpm: Array, air: Array, reading: Array) -> Array:
            return reading + d * (rpm / top) ** 2

        build.touches.setdefault(channel_of(self.setting, self.at), []).append(moved)

    def places(self) -> list[list[str]]:
        return [[f"tcp.{self.at}", channel_of(self.setting, self.at)]]


class SlowSensor(Effect):
    """A sensor with a lag [s]; in hard truth a tenth of it is a second lag behind the first."""

    name, site, kinds, bounds = "sensor_lag", "lag", ("sensor_lag",), (40.0, 900.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 300.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        lags = [0.9 * self.size, 0.1 * self.size] if self.setting.hard else [self.size]
        for i, lag in enumerate(lags):
            build.add(f"lag {i}", lag)
            cell = build.cells[f"lag {i}"][0]
            build.rows.append((cell, build.readings[self.at]))
            build.readings[self.at] = {cell: 1.0}


class LooseSensor(Effect):
    """In some windows the reading goes a share of the way from the part to the air, as when the sensor lifts off."""

    name, site, kinds, bounds = "sensor_fault", "loose", ("sensor_fault",), (0.04, 0.9)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 0.35, setting, {}, int(rng.integers(2**31)))

    def windows(self, program: Program, index: int) -> Array:
        """Begin and end [s] of two to four windows of 8 to 40 min."""
        rng = np.random.default_rng([self.seed, index])
        begins = np.sort(rng.uniform(600, program.duration - 1200, int(rng.integers(2, 5))))
        return np.array([[begin, begin + rng.uniform(480, 2400)] for begin in begins])

    def acts(self, program: Program, index: int) -> list[list[float]]:
        return self.windows(program, index).tolist()

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        windows, soft = self.windows(program, index), 20.0 if self.setting.hard else 0.5

        def loosened(t: Array, rpm: Array, air: Array, reading: Array) -> Array:
            rises = (1 / (1 + np.exp(-np.clip((t - a) / soft, -50, 50))) for a, _ in windows)
            falls = (1 / (1 + np.exp(-np.clip((b - t) / soft, -50, 50))) for _, b in windows)
            lifted = np.max([up * down for up, down in zip(rises, falls, strict=True)], axis=0)
            return np.asarray(reading + self.size * lifted * (air - reading))

        build.touches.setdefault(self.at, []).append(loosened)

    def places(self) -> list[list[str]]:
        return [[self.at]]
