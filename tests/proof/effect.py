"""The idea of a concealed effect: what it does to the truth, how strong it may be, and which answers would be right."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from numpy.random import Generator

from proof.assembly import Assembly
from proof.layout import Layout, split
from proof.programs import Program
from proof.system import Array


@dataclass(frozen=True)
class Setting:
    """What an effect is drawn for: the machine, how warm its parts get without it [°C], which truth it is, and how many
    recordings there are to learn from."""

    layout: Layout
    warm: Mapping[str, float]
    hard: bool = False
    fine: bool = False
    runs: int = 3


@dataclass(frozen=True)
class Effect(ABC):
    """`at` is one of the layout's sites, `size` its strength within `bounds`, `numbers` whatever else was drawn."""

    at: Any
    size: float
    setting: Setting
    numbers: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0

    name: ClassVar[str]
    site: ClassVar[str]
    kinds: ClassVar[tuple[str, ...]]
    near: ClassVar[tuple[str, ...]] = ()
    """Kinds that would be a part of the truth, where no kind is all of it."""
    bounds: ClassVar[tuple[float, float]]
    scales: ClassVar[bool] = True
    room: ClassVar[str] = ""
    """How the room has to be told for it, if that matters."""

    @classmethod
    def without(cls, layout: Layout, at: Any) -> Layout:
        """The machine that the user knows; the same, where the effect is nothing that stands in a drawing."""
        return layout

    def acts(self, program: Program, index: int) -> list[list[float]]:
        """Windows [s] of a recording in which it acts; none: all the time."""
        return []

    def course(self, T: Array, times: Array, program: Program, index: int) -> Array | None:
        """Heat [W] that it brings to its place over time, whose mean temperature [°C] is given; None: no such heat."""
        return None

    @classmethod
    @abstractmethod
    def draw(cls, setting: Setting, at: Any, rng: Generator) -> Effect:
        """An effect of a middling strength at one of the sites."""

    @abstractmethod
    def conceal(self, build: Assembly, program: Program, index: int) -> None:
        """Adds itself to the truth of the recording `index`."""

    def places(self) -> list[list[str]]:
        """Groups of names: a right answer names one of each group."""
        return [[split(self.at)[0]]]

    def told(self) -> dict[str, Any]:
        """For the key."""
        return {"at": self.at, "size": self.size, **self.numbers}
