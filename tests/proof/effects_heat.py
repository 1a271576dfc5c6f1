"""Concealed heat: a source, air friction, friction that falls as it warms, and coolers that switch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator

from proof.assembly import Assembly
from proof.effect import Effect, Setting
from proof.laws import RPM, air_drag, vogel
from proof.layout import split
from proof.programs import Program
from proof.system import Array


class HiddenSource(Effect):
    """Constant heat [W] at a place, whether the machine runs or not."""

    name, site, kinds, bounds = "hidden_source", "source", ("heat_source",), (8.0, 350.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 60.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.losses["hidden source"] = (build.at(self.at), lambda rpm: self.size)


class Windage(Effect):
    """Air friction of a turning part [W at top speed], with a friction coefficient that falls with speed."""

    name, site, kinds, bounds = "windage", "windage", ("windage",), (20.0, 500.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 150.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        top = build.layout.top_speed
        build.losses["windage"] = (build.at(self.at), lambda rpm: air_drag(rpm / top, self.size))


class ThinOil(Effect):
    """The torque of a bearing falls as its inner ring warms; `size` is the steepness of its oil's viscosity."""

    name, site, kinds, bounds = "viscous_friction", "viscous", ("viscous_friction",), (0.3, 2.2)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 1.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        into, _ = build.losses.pop(self.at)
        torque = build.numbers[f"sources.{self.at}.torque"]
        inner = next(iter(build.layout.heats[self.at].into))
        cold = build.layout.reference
        build.laws.append((
            into, build.at(inner), lambda t, rpm, T: RPM * abs(rpm) * torque * vogel(T, cold, self.size)
        ))  # fmt: skip

    def places(self) -> list[list[str]]:
        return [[split(place)[0] for place in self.setting.layout.heats[self.at].into]]


class ChillerTank(Effect):
    """The coolant that is believed to be held is a tank [J/K] whose chiller [W] switches with a hysteresis [K]."""

    name, site, kinds, bounds = "relay_chiller", "tank", ("thermostat_cooling",), (0.3, 1.5)
    scales = False

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        believed = setting.layout.held[at] or 0.0
        numbers = {
            "C": rng.uniform(45e3, 130e3), "set": believed + rng.uniform(0.3, 1.6), "P": rng.uniform(650, 1200),
            "UA": rng.uniform(4, 25), "delay": rng.uniform(10, 40) if setting.hard else 0.0,
            "slope": 0.02 if setting.hard else 0.0,
        }  # fmt: skip
        return cls(at, float(rng.uniform(0.6, 1.4)), setting, {key: float(x) for key, x in numbers.items()})

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        x = self.numbers
        del build.held[self.at]
        build.add(self.at, x["C"])
        build.paths += [(a, build.at(self.at), G) for a, to, G in build.sinks if to == self.at]
        build.sinks = [sink for sink in build.sinks if sink[1] != self.at]
        build.join(self.at, "ambient", x["UA"])
        switch(build, self.at, x["P"], x["set"], self.size, x["delay"], x["slope"])

    def places(self) -> list[list[str]]:
        layout = self.setting.layout
        washed = [split(joint.a)[0] for joint in layout.joints.values() if joint.b == self.at]
        return [[*washed, self.at]]


class PartCooler(Effect):
    """A cooler [W] that acts on a part and watches it, on and off with a hysteresis [K]."""

    name, site, kinds, bounds = "part_cooler", "cooler", ("thermostat_cooling",), (40.0, 600.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        reference = setting.layout.reference
        rise = max(setting.warm[split(at)[0]] - reference, 1.0)
        set_at = reference + float(rng.uniform(0.35, 0.65)) * rise
        delay = float(rng.uniform(10, 40)) if setting.hard else 0.0
        numbers = {"set": set_at, "hysteresis": float(rng.uniform(0.08, 0.16)) * rise, "delay": delay}
        return cls(at, 200.0, setting, numbers)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        x = self.numbers
        switch(build, self.at, self.size, x["set"], x["hysteresis"], x["delay"], 0.0)


def switch(build: Assembly, at: str, P: float, middle: float, half: float, delay: float, slope: float) -> None:
    """A relay that watches the place it cools."""
    numbers = {"power": P, "upper": middle + half, "lower": middle - half, "delay": delay, "slope": slope}
    build.relays.append((build.at(at), build.at(at), numbers))


class WashBursts(Effect):
    """Heat [W] in bursts at irregular times, as from coolant wash behind a door whose switch nobody recorded."""

    name, site, kinds, bounds = "wash_bursts", "wash", ("unknown",), (60.0, 1500.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 400.0, setting, {}, int(rng.integers(2**31)))

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.bursts += [(a, b, build.at(self.at), P) for a, b, P in self.bursts(program, index)]

    def bursts(self, program: Program, index: int) -> Iterator[list[float]]:
        """Begin and end [s], and power [W]."""
        rng = np.random.default_rng([self.seed, index])
        for begin in np.sort(rng.uniform(0, program.duration - 900, int(rng.integers(4, 9)))):
            end = float(begin + rng.uniform(180, 780))
            yield [float(begin), end, self.size * float(rng.uniform(0.6, 1.4))]

    def acts(self, program: Program, index: int) -> list[list[float]]:
        return [[begin, end] for begin, end, _ in self.bursts(program, index)]

    def course(self, T: Array, times: Array, program: Program, index: int) -> Array | None:
        return np.asarray(sum(P * ((times >= a) & (times < b)) for a, b, P in self.bursts(program, index)))


class RunIn(Effect):
    """Heat [W at top speed] in proportion to speed that dies away with the time the spindle has turned."""

    name, site, kinds, bounds = "run_in", "run-in", ("unknown",), (40.0, 900.0)
    near = ("heat_source", "motor_loss", "bearing_friction", "seal_friction")

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 250.0, setting, {"tau": float(rng.uniform(1200, 3600))})

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.laws.append((build.at(self.at), {}, lambda t, rpm, T: self.power(program, t)))

    def power(self, program: Program, t: float) -> float:
        share = abs(program.speed(t)) / self.setting.layout.top_speed
        return self.size * share * float(np.exp(-program.turning(t) / self.numbers["tau"]))

    def course(self, T: Array, times: Array, program: Program, index: int) -> Array | None:
        return np.array([self.power(program, t) for t in times])


def stronger(effect: Effect, factor: float) -> Effect:
    """The same effect at another strength, kept within its bounds; four digits, so that rounding errors do not show."""
    low, high = effect.bounds
    return replace(effect, size=float(f"{np.clip(effect.size * factor, low, high):.4g}"))
