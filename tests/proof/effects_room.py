"""Concealed around the machine and by the clock: a room that drifts, heat in pulses, heat of the axes, radiation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.random import Generator

from proof.assembly import Assembly
from proof.effect import Effect, Setting
from proof.exchanges import radiation
from proof.programs import Program
from proof.system import Array


class RoomDrift(Effect):
    """The room, taken as constant, warms or cools [K over a run], another way in each run."""

    name, site, kinds, bounds, room = "room_drift", "room", ("ambient_drift",), (0.3, 8.0), "stated"

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 2.0, setting, {"late": float(rng.uniform(0, 0.4))}, int(rng.integers(2**31)))

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.airs.append(lambda t: self.rise(t, program, index))

    def rise(self, t: float, program: Program, index: int) -> float:
        """K over the room at the beginning: still at first, then straight."""
        rng = np.random.default_rng([self.seed, index])
        share, late = float(rng.choice([-1, 1]) * rng.uniform(0.6, 1.3)), self.numbers["late"]
        return self.size * share * max(0.0, t / program.duration - late) / (1 - late)

    def places(self) -> list[list[str]]:
        return [["ambient"]]


class Pulses(Effect):
    """Heat [W] by the clock: in pulses of the same length and distance, or once in every run."""

    name, site, kinds, bounds = "timed_source", "source", ("timed_source",), (40.0, 1500.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        period = float(rng.uniform(1500, 4500))
        numbers = {"period": period, "duration": float(rng.uniform(0.2, 0.55)) * period}
        if rng.random() < 0.35:
            numbers = {"period": 0.0, "duration": float(rng.uniform(1200, 4500))}
        return cls(at, 200.0, setting, numbers | {"phase": float(rng.uniform(300, 3000))})

    def acts(self, program: Program, index: int) -> list[list[float]]:
        x = self.numbers
        begins = np.arange(x["phase"], program.duration, x["period"]) if x["period"] else np.array([x["phase"]])
        return [[float(begin), float(begin + x["duration"])] for begin in begins]

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.bursts += [(a, b, build.at(self.at), self.size) for a, b in self.acts(program, index)]


class FeedHeat(Effect):
    """Heat in proportion to the feed, which is recorded [W at 10 m/min]."""

    name, site, bounds = "feed_heat", "source", (15.0, 900.0)
    kinds = ("screw_friction", "guide_friction", "heat_source", "cutting_heat")

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 120.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.fed.append((build.at(self.at), lambda feed: self.size * abs(feed) / 10))


class Radiator(Effect):
    """A part that radiates to a wall which keeps a temperature of its own: emissivity times area [m²]."""

    name, site, kinds, bounds = "radiation", "cooler", ("radiation", "convection", "foundation"), (0.05, 25.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 1.0, setting, {"wall": setting.layout.reference + float(rng.choice([-5, 12, 25]))})

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.held["wall"] = self.numbers["wall"]
        build.bend(self.at, "wall", radiation(self.size))


def turned_feeds(rng: Generator, program: Program) -> tuple[float, ...]:
    """A feed [m/min] from every edge of the speed on."""
    return tuple(float(x) for x in rng.choice(np.array([0.0, 4.0, 9.0, 15.0]), len(program.edges)))


def feed_at(program: Program, times: Array) -> Array:
    return np.array([program.feed(t) for t in times])
