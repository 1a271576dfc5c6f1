"""Left out of the file: a path that stands in the drawing, a part that moves the tool."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from numpy.random import Generator

from proof.assembly import Assembly
from proof.effect import Effect, Setting
from proof.layout import Layout, split


class ForgottenPath(Effect):
    """A joint of the machine [W/K] that the file does not have."""

    name, site, kinds, bounds = "forgotten_path", "forgotten", ("conduction", "contact"), (2.0, 400.0)

    @classmethod
    def without(cls, layout: Layout, at: Any) -> Layout:
        return replace(layout, joints={name: joint for name, joint in layout.joints.items() if name != at[0]})

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, at[1].conductance, setting)

    def conceal(self, build: Assembly, program: Any, index: int) -> None:
        build.join(self.at[1].a, self.at[1].b, self.size)

    def places(self) -> list[list[str]]:
        return [[split(self.at[1].a)[0]], [split(self.at[1].b)[0]]]

    def told(self) -> dict[str, Any]:
        return {"at": self.at[0], "between": [self.at[1].a, self.at[1].b], "size": self.size}


class ForgottenGrowth(Effect):
    """A part that moves the tool [times its own growth] and does not stand under `tcp`."""

    name, site, kinds, bounds = "forgotten_growth", "growth", ("stretching",), (0.3, 3.0)

    @classmethod
    def without(cls, layout: Layout, at: Any) -> Layout:
        return replace(layout, growths={name: growth for name, growth in layout.growths.items() if name != at[0]})

    @classmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        return cls(at, 1.0, setting)

    def conceal(self, build: Assembly, program: Any, index: int) -> None:
        growth = self.at[1]
        stuff = build.layout.materials[build.layout.parts[split(growth.of)[0]].material]
        each = 1e6 * growth.direction * stuff.expansion * growth.length * self.size
        row = build.readings[self.channel()]
        for cell, w in build.at(growth.of).items():
            row[cell] = row.get(cell, 0.0) + w * each

    def channel(self) -> str:
        axis = f"tcp.{self.at[1].axis}"
        return next(name for name, place in self.setting.layout.sensors.items() if place == axis)

    def places(self) -> list[list[str]]:
        return [[f"tcp.{self.at[1].axis}", self.channel()], [split(self.at[1].of)[0]]]

    def told(self) -> dict[str, Any]:
        return {"at": self.at[0], "of": self.at[1].of, "size": self.size}
