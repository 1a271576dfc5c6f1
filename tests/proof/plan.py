"""Which cases are made: of each class so many, each on a machine, in a tier of truth and with recordings of its own.

Case k depends on the seed and on k alone, so that a proof can be extended. Of the first 200 cases 60 conceal nothing
and 60 one effect of the catalogue; the first 300 hold 60 of every class. The first 40 are of small machines.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.random import Generator

from proof.effect import Effect
from proof.effects_failing import ComesLoose, Drifts, FalseZero, Jumps, KnockedProbe, LateClock, MixedUp
from proof.effects_heat import ChillerTank, HiddenSource, PartCooler, RunIn, ThinOil, WashBursts, Windage
from proof.effects_left_out import ForgottenGrowth, ForgottenPath
from proof.effects_odd import AgeingPump, ChipPile, Door, Lid, MixedFriction, SteepJoint, StepFan, TwoAtOnePlace
from proof.effects_path import Fan, Floor, HiddenMass, MissingPath
from proof.effects_room import FeedHeat, Pulses, Radiator, RoomDrift
from proof.effects_seen import HeadTilt, LooseSensor, SlowSensor, SpinGrowth
from proof.grinder import GRINDER
from proof.lathe import LATHE
from proof.layout import Layout
from proof.mill import MILL
from proof.places_for import usual_sites
from proof.portal import PORTAL
from proof.scattered import BENT, FEATURES, scattered

LAYOUTS = {layout.name: layout for layout in (PORTAL, MILL, LATHE, GRINDER)}
"""Machines that were drawn by hand."""
DRAWN = 0.3
"""Share of cases on these."""
TRUTHS = ("lumped", "fine", "hard")
CHEAP = 40
"""The first cases of a proof, for every day."""
EACH = 60
"""Cases of every class in a whole proof."""
FIRST = {"innocent": 60, "effect": 60, "outside": 35, "sensor": 25, "two": 20}
"""Of the first 200 cases."""

Pair = tuple[type[Effect], type[Effect]]

EFFECTS: tuple[type[Effect], ...] = (
    HiddenSource, MissingPath, Fan, Windage, ThinOil, ChillerTank, HiddenMass, Floor, HeadTilt, SpinGrowth, PartCooler,
    ForgottenPath, Pulses, ForgottenGrowth, FeedHeat, RoomDrift, Radiator,
)  # fmt: skip
SENSORS: tuple[type[Effect], ...] = (
    SlowSensor, LooseSensor, ComesLoose, Jumps, Drifts, FalseZero, MixedUp, KnockedProbe, LateClock,
)  # fmt: skip
OUTSIDE: tuple[type[Effect], ...] = (
    WashBursts, RunIn, Door, StepFan, TwoAtOnePlace, ChipPile, MixedFriction, SteepJoint, Lid, AgeingPump,
)  # fmt: skip
TWO: tuple[Pair, ...] = (
    (Fan, HeadTilt), (HiddenSource, SlowSensor), (MissingPath, SpinGrowth), (Windage, HiddenMass),
    (ThinOil, Floor), (PartCooler, ForgottenGrowth), (FeedHeat, ComesLoose), (HiddenSource, Fan),
)  # fmt: skip
NULLS: Mapping[str, str] = {"wrong_numbers": "lumped", "coarse": "fine", "rough": "hard", "room": "lumped"}
"""Machines with nothing concealed, and the truth each is made with; `room`: the rooms differ and are not recorded."""


@dataclass(frozen=True)
class Slot:
    """One case to be made. room: `recorded` or `stated` (constant, not recorded, and not the same in every run)."""

    group: str
    what: str
    effects: tuple[type[Effect], ...]
    truth: str
    layout: Layout
    room: str = "recorded"
    runs: int = 3


@cache
def classes(count: int) -> tuple[str, ...]:
    """The class of every case, always the one that lags most behind its share; then what a class lacks to EACH."""
    given: Counter[str] = Counter()
    total, told = sum(FIRST.values()), []
    for i in range(count):
        share = FIRST if i < total else dict.fromkeys(FIRST, EACH)
        whole = total if i < total else EACH * len(FIRST)
        told.append(max(FIRST, key=lambda name: share[name] * (i + 1) / whole - given[name]))
        given[told[-1]] += 1
    return tuple(told)


def slot(seed: int, index: int) -> Slot:
    """The case of a number, from 0."""
    rng = np.random.default_rng([seed, index, 1])
    group, *before = reversed(classes(index + 1))
    nth = before.count(group)
    what, effects = chosen(seed, group, nth)
    truth = NULLS[what] if what in NULLS else TRUTHS[(nth + seed) % len(TRUTHS)]
    is_stated = what == "room" or any(effect.room == "stated" for effect in effects) or rng.random() < 0.1
    runs = int(rng.choice([1, 3, 3, 3, 3, 3, 3, 6]))
    layout = machine(rng, effects, index < CHEAP)
    return Slot(group, what, effects, truth, layout, "stated" if is_stated else "recorded", runs)


def chosen(seed: int, group: str, nth: int) -> tuple[str, tuple[type[Effect], ...]]:
    """What the nth case of a class conceals: all of its kind in turn, in an order of the seed's."""
    if group == "innocent":
        return list(NULLS)[nth % len(NULLS)], ()
    if group == "two":
        pair = TWO[turn(seed, len(TWO), nth)]
        return "+".join(effect.name for effect in pair), pair
    among = {"effect": EFFECTS, "sensor": SENSORS, "outside": OUTSIDE}[group]
    effect = among[turn(seed, len(among), nth)]
    return effect.name, (effect,)


def turn(seed: int, of: int, nth: int) -> int:
    """Every one of so many once, then again in another order."""
    return int(np.random.default_rng([seed, of, nth // of]).permutation(of)[nth % of])


def machine(rng: Generator, effects: tuple[type[Effect], ...], is_small: bool) -> Layout:
    """One of those drawn by hand, or a scattered one, that has a site for every effect."""
    needed = {effect.site for effect in effects}
    while True:
        layout = list(LAYOUTS.values())[int(rng.integers(len(LAYOUTS)))]
        if rng.random() > DRAWN:
            layout = scattered(rng, parts(rng, is_small), features(rng, is_small))
        layout = usual_sites(rng, layout)
        if needed <= layout.sites.keys():
            return layout


def parts(rng: Generator, is_small: bool) -> int:
    """3 to 40: every second machine has at most 8, every tenth 20 or more."""
    if is_small or rng.random() < 0.5:
        return int(rng.integers(3, 9))
    return int(rng.integers(9, 20)) if rng.random() < 0.8 else int(rng.integers(20, 41))


def features(rng: Generator, is_small: bool) -> tuple[str, ...]:
    """What a machine has beside joints and still air; what bends its balance more rarely, for it takes time."""
    chance = dict.fromkeys(FEATURES, 0.4) | dict.fromkeys(BENT, 0.08 if is_small else 0.15)
    return tuple(name for name in FEATURES if rng.random() < chance[name])
