"""Concealed heat that is not, or not exactly, of a form that a catalogue would have."""

from __future__ import annotations

from abc import abstractmethod
from bisect import bisect_right
from typing import Any

import numpy as np
from numpy.random import Generator

from proof.assembly import Assembly
from proof.effect import Effect, Setting
from proof.exchanges import tightening
from proof.laws import air_drag
from proof.layout import split
from proof.programs import Program
from proof.system import Array, Exchange


class OddHeat(Effect):
    """Heat at one place by a law of its own."""

    kinds = ("unknown",)

    @abstractmethod
    def power(self, t: float, rpm: float, air: float, T: float, program: Program, index: int) -> float:
        """W at a time [s], with the place's mean temperature [°C]."""

    def breaks(self, program: Program, index: int) -> tuple[float, ...]:
        """Instants [s] at which it jumps."""
        return ()

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        def made() -> Exchange:
            w = build.dense(build.at(self.at))

            def heat(t: float, rpm: float, air: float, T: Array) -> Array:
                return w * self.power(t, rpm, air, float(w @ T), program, index)

            return Exchange(heat, self.breaks(program, index))

        build.exchanges.append(made)

    def course(self, T: Array, times: Array, program: Program, index: int) -> Array | None:
        pairs = zip(times, T, strict=True)
        return np.array([self.power(t, program.speed(t), program.air(t), x, program, index) for t, x in pairs])


class Door(OddHeat):
    """A door that is opened now and then: what is then lost to the air [W/K]."""

    name, site, near, bounds = "door", "wash", ("convection", "forced_convection"), (2.0, 200.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 25.0, setting, {}, int(rng.integers(2**31)))

    def acts(self, program: Program, index: int) -> list[list[float]]:
        rng = np.random.default_rng([self.seed, index])
        begins = np.sort(rng.uniform(900, program.duration - 1500, int(rng.integers(3, 7))))
        return [[float(begin), float(begin + rng.uniform(300, 1500))] for begin in begins]

    def breaks(self, program: Program, index: int) -> tuple[float, ...]:
        return tuple(edge for window in self.acts(program, index) for edge in window)

    def power(self, t: float, rpm: float, air: float, T: float, program: Program, index: int) -> float:
        is_open = any(a - 1e-6 <= t < b - 1e-6 for a, b in self.acts(program, index))
        return -self.size * (T - air) * is_open


class Lid(OddHeat):
    """A cover that was off in some of the recordings: what the part then loses to the air [W/K]."""

    name, site, near, bounds = "lid", "wash", ("convection", "natural_convection"), (1.0, 150.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 15.0, setting, {"odd": float(rng.integers(2))})

    def power(self, t: float, rpm: float, air: float, T: float, program: Program, index: int) -> float:
        return -self.size * (T - air) * (index % 2 == self.numbers["odd"])


class StepFan(OddHeat):
    """A fan that starts at a speed of its own: what the part then loses to the air [W/K]."""

    name, site, near, bounds = "fan_step", "cooler", ("forced_convection", "convection"), (1.0, 150.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 15.0, setting, {"from": float(rng.uniform(0.4, 0.7))})

    def power(self, t: float, rpm: float, air: float, T: float, program: Program, index: int) -> float:
        return -self.size * (T - air) * (abs(rpm) > self.numbers["from"] * self.setting.layout.top_speed)


class MixedFriction(OddHeat):
    """Friction whose torque falls with speed until the film carries: most heat [W] well below the top speed."""

    name, site, bounds = "mixed_friction", "run-in", (15.0, 900.0)
    near = ("heat_source", "bearing_friction", "seal_friction", "viscous_friction", "motor_loss")

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 120.0, setting, {"film": float(rng.uniform(0.12, 0.3))})

    def power(self, t: float, rpm: float, air: float, T: float, program: Program, index: int) -> float:
        share = abs(rpm) / self.setting.layout.top_speed / self.numbers["film"]
        return self.size * share * float(np.exp(1 - share))


class TwoAtOnePlace(OddHeat):
    """Two small ones at one place: heat that is always there, and air friction [W each at the most]."""

    name, site, near, bounds = "two_small", "source", ("heat_source", "windage", "motor_loss"), (5.0, 400.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 60.0, setting, {"share": float(rng.uniform(0.35, 0.65))})

    def power(self, t: float, rpm: float, air: float, T: float, program: Program, index: int) -> float:
        drag = air_drag(rpm / self.setting.layout.top_speed, 2.0)
        return self.size * (self.numbers["share"] + (1 - self.numbers["share"]) * drag)


class ChipPile(OddHeat):
    """Chips that warm a part while the machine runs, and for as long as they lie there: heat [W] that lags behind."""

    name, site, near, bounds = "chip_pile", "wash", ("heat_source", "cutting_heat"), (10.0, 800.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 120.0, setting, {"tau": float(rng.uniform(900, 3000))})

    def power(self, t: float, rpm: float, air: float, T: float, program: Program, index: int) -> float:
        return self.size * filled(program, self.numbers["tau"], t)


def filled(program: Program, tau: float, t: float) -> float:
    """A lag of τ [s] behind whether the spindle turns, from 0 at the start."""
    level = 0.0
    for i in range(bisect_right(program.edges, t + 1e-9)):
        end = min(t, program.edges[i + 1]) if i + 1 < len(program.edges) else t
        to = float(program.speeds[i] != 0)
        level = to + (level - to) * float(np.exp(-(end - program.edges[i]) / tau))
    return level


class AgeingPump(OddHeat):
    """A source that grows from run to run and within each: heat [W] on average over the first run."""

    name, site, near, bounds = "ageing_source", "source", ("heat_source",), (8.0, 350.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 60.0, setting, {"growth": float(rng.uniform(0.3, 0.8))})

    def power(self, t: float, rpm: float, air: float, T: float, program: Program, index: int) -> float:
        return self.size * (1 + self.numbers["growth"] * (0.5 * index + t / program.duration - 0.5))


class SteepJoint(Effect):
    """A joint that tightens as it warms, steeper than any straight line: G exp(s ΔT), s [1/K]."""

    name, site, kinds, near, bounds = "steep_joint", "link", ("unknown",), ("contact", "conduction"), (0.03, 0.9)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 0.2, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        joint, G = build.layout.joints[self.at], build.numbers[f"links.{self.at}.conductance"]
        build.bend(joint.a, joint.b, tightening(G, build.layout.reference, self.size))

    def places(self) -> list[list[str]]:
        joint = self.setting.layout.joints[self.at]
        return [[split(joint.a)[0], split(joint.b)[0]]]
