"""Concealed paths: conduction, a film that grows with speed, a mass behind a part, a floor."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from numpy.random import Generator

from proof.assembly import Assembly
from proof.effect import Effect, Setting
from proof.laws import blown
from proof.layout import split
from proof.programs import Program


class MissingPath(Effect):
    """A conductance [W/K] between two parts that the file does not join there."""

    name, site, kinds, bounds = "missing_path", "path", ("conduction",), (2.0, 90.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 15.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.join(self.at[0], self.at[1], self.size)

    def places(self) -> list[list[str]]:
        return [[split(end)[0]] for end in self.at]


class Fan(Effect):
    """A film to the air that grows with speed as a cylinder's in cross flow: 1 + size at the top speed."""

    name, site, kinds, bounds = "speed_convection", "fan", ("forced_convection",), (0.3, 9.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 2.0, setting)

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        G, top = build.numbers[f"links.{self.at}.conductance"], build.layout.top_speed
        losses = {cell: w * G for cell, w in build.at(build.layout.joints[self.at].a).items()}
        build.films.append((losses, "ambient", lambda rpm: blown(rpm / top, self.size) - 1))

    def places(self) -> list[list[str]]:
        return [[split(self.setting.layout.joints[self.at].a)[0]]]


class HiddenMass(Effect):
    """A heat capacity behind a part, `size` times the part's own, reached with a time constant [s].

    In fine truth it is a slab of three cells, and the conductance is that of its joint.
    """

    name, site, kinds, bounds = "hidden_mass", "mass", ("hidden_mass",), (0.1, 3.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 0.6, setting, {"tau": float(rng.uniform(600, 2400))})

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        C = self.size * sum(build.capacity[cell] for cell in build.cells[self.at])
        G, n = C / self.numbers["tau"], 3 if self.setting.fine else 1
        build.add("hidden", C, n)
        cells = build.cells["hidden"]
        build.paths.append((build.at(self.at), {cells[0]: 1.0}, G))
        build.paths += [({a: 1.0}, {b: 1.0}, 8 * G) for a, b in pairwise(cells)]


class Floor(Effect):
    """A conductance [W/K] into a floor that keeps its own temperature [°C]."""

    name, site, kinds, bounds = "foundation", "floor", ("foundation",), (2.0, 150.0)

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 30.0, setting, {"floor": setting.layout.reference - float(rng.uniform(1.5, 4))})

    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        build.held["floor"] = self.numbers["floor"]
        build.join(self.at, "floor", self.size)
