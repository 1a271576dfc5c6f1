"""Concealed heat: a source, air friction, friction that falls as it warms, and coolers that switch."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator

from proof.assembly import Assembly
from proof.effect import Effect, Setting
from proof.laws import RPM, air_drag, vogel
from proof.layout import split
from proof.programs import Program


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
        rng = np.random.default_rng([self.seed, index])
        for begin in np.sort(rng.uniform(0, program.duration - 900, int(rng.integers(4, 9)))):
            end = float(begin + rng.uniform(180, 780))
            build.bursts.append((float(begin), end, build.at(self.at), self.size * float(rng.uniform(0.6, 1.4))))


class RunIn(Effect):
    """Heat [W at top speed] in proportion to speed that dies away with the time the spindle has turned."""

    name, site, kinds, bounds = "run_in", "run-in", ("unknown",), (40.0, 900.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 250.0, setting, {"tau": float(rng.uniform(1200, 3600))})

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        top, tau = build.layout.top_speed, self.numbers["tau"]
        build.laws.append((
            build.at(self.at), {},
            lambda t, rpm, T: self.size * abs(rpm) / top * float(np.exp(-program.turning(t) / tau)),
        ))  # fmt: skip


def stronger(effect: Effect, factor: float) -> Effect:
    """The same effect at another strength, kept within its bounds; four digits, so that rounding errors do not show."""
    low, high = effect.bounds
    return replace(effect, size=float(f"{np.clip(effect.size * factor, low, high):.4g}"))
