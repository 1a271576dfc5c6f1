"""Which cases are made: so many of every effect, of two at once, with nothing concealed, and of the unknown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from numpy.random import Generator

from proof.effect import Effect
from proof.effects_heat import ChillerTank, HiddenSource, PartCooler, RunIn, ThinOil, WashBursts, Windage
from proof.effects_path import Fan, Floor, HiddenMass, MissingPath
from proof.effects_seen import HeadTilt, LooseSensor, SlowSensor, SpinGrowth
from proof.grinder import GRINDER
from proof.lathe import LATHE
from proof.layout import Layout
from proof.mill import MILL
from proof.portal import PORTAL

LAYOUTS = {layout.name: layout for layout in (PORTAL, MILL, LATHE, GRINDER)}
RESERVED = "grinder"
"""The layout that is used in a minority of cases, for the final score only."""
TURNS = ("portal", "mill", "lathe", "mill", "portal", "grinder", "lathe")
TRUTHS = ("lumped", "fine", "hard")

Choice = tuple[type[Effect], ...]
"""Effects that answer to the same kind: the first that the layout has a site for, every fourth time the last."""

SINGLES: Mapping[str, Choice] = {
    "heat_source": (HiddenSource,),
    "conduction": (MissingPath,),
    "forced_convection": (Fan,),
    "windage": (Windage,),
    "viscous_friction": (ThinOil,),
    "thermostat_cooling": (ChillerTank, PartCooler),
    "hidden_mass": (HiddenMass,),
    "foundation": (Floor,),
    "tilt": (HeadTilt,),
    "centrifugal_growth": (SpinGrowth,),
    "sensor_lag": (SlowSensor,),
    "sensor_fault": (LooseSensor,),
}
DOUBLES = (("forced_convection", "tilt"), ("heat_source", "sensor_lag"), ("conduction", "centrifugal_growth"))
SHARES = {
    "heat_source": 2, "conduction": 3, "forced_convection": 3, "windage": 2, "viscous_friction": 2,
    "thermostat_cooling": 4, "hidden_mass": 2, "foundation": 2, "tilt": 2, "centrifugal_growth": 1, "sensor_lag": 2,
    "sensor_fault": 2, "two": 2, "wrong_numbers": 4, "coarse": 3, "rough": 2, "outside": 2,
}  # fmt: skip
"""Of 40 cases."""
NULLS = {"wrong_numbers": "lumped", "coarse": "fine", "rough": "hard"}
"""Machines with nothing concealed, and the truth each is made with."""


@dataclass(frozen=True)
class Slot:
    """One case to be made: its class, the effects to conceal, the truth and the machine."""

    what: str
    effects: tuple[type[Effect], ...]
    truth: str
    layout: Layout


def slots(count: int, rng: Generator, reserved: bool = True) -> list[Slot]:
    """The cases of a proof in the order of their numbers: the shares kept for any count, the order shuffled."""
    turns = [name for name in TURNS if reserved or name != RESERVED]
    classes = apportioned(count)
    order = rng.permutation(count)
    seen: Counter[str] = Counter()
    plan = []
    for turn, i in enumerate(order):
        what = classes[i]
        truth = NULLS.get(what) or TRUTHS[(list(SHARES).index(what) + seen[what]) % len(TRUTHS)]
        layout = LAYOUTS[turns[turn % len(turns)]]
        effects = tuple(chosen(choice, seen[what], layout) for choice in choices(what, seen[what]))
        plan.append(Slot(what, effects, truth, layout))
        seen[what] += 1
    return plan


def chosen(choice: Choice, nth: int, layout: Layout) -> type[Effect]:
    """The effect for the nth case of a class on this machine."""
    fitting = [effect for effect in choice if effect.site in layout.sites]
    return fitting[-1 if nth % 4 == 3 else 0]


def apportioned(count: int) -> list[str]:
    """Classes in turn, always the one that lags most behind its share."""
    given: Counter[str] = Counter()
    total = sum(SHARES.values())
    for i in range(count):
        given[max(SHARES, key=lambda what: SHARES[what] * (i + 1) / total - given[what])] += 1
    return [what for what in SHARES for _ in range(given[what])]


def choices(what: str, nth: int) -> tuple[Choice, ...]:
    """The effects of a class; the nth case of two effects takes the nth pair."""
    if what in NULLS:
        return ()
    if what == "outside":
        return ((WashBursts,), (RunIn,))[nth % 2 : nth % 2 + 1]
    kinds = DOUBLES[nth % len(DOUBLES)] if what == "two" else (what,)
    return tuple(SINGLES[kind] for kind in kinds)
