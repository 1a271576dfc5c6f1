"""What is real in a case, and its key: what is concealed, and which answers would be right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from proof.assembly import assemble
from proof.effect import Effect
from proof.layout import split
from proof.observing import track_of
from proof.plan import Slot
from proof.programs import Program
from proof.strength import COARSE, Bench, seen


@dataclass(frozen=True)
class Truth:
    """What is real in a case: numbers, programs, effects and how they are seen."""

    slot: Slot
    numbers: Mapping[str, float]
    programs: tuple[Program, ...]
    effects: tuple[Effect, ...]
    on: Bench


def named(slot: Slot) -> dict[str, str]:
    """What a diagnosis is given of each recording, and the table behind it."""
    names = [*(f"train{i + 1}" for i in range(slot.runs)), "holdout"]
    return {f"{name}.{'csv' if slot.room == 'recorded' else 'yaml'}": f"{name}.csv" for name in names}


def key_of(truth: Truth) -> dict[str, Any]:
    """What is concealed, and which kinds and places would be right answers."""
    slot, effects = truth.slot, truth.effects
    return {
        "layout": slot.layout.name,
        "truth": slot.truth,
        "class": slot.group,
        "what": slot.what,
        "room": slot.room,
        "effects": {effect.name: effect.told() for effect in effects},
        "kinds": [list(effect.kinds) for effect in effects],
        "near": [list(effect.near) for effect in effects],
        "places": [effect.places() for effect in effects],
        "windows": [[w for e in effects for w in e.acts(p, i)] for i, p in enumerate(truth.programs[:-1])],
        "course": course_of(truth),
        "in_noise": dict(seen(truth.on, effects)),
        "numbers": dict(truth.numbers),
    }


def course_of(truth: Truth) -> dict[str, Any] | None:
    """The heat [W] that something outside the catalogue brings to its place over the first recording."""
    if truth.slot.group != "outside":
        return None
    effect, program = truth.effects[0], truth.programs[0]
    build = assemble(truth.on.layout, truth.numbers)
    effect.conceal(build, program, 0)
    times = program.times(60.0)
    if not isinstance(effect.at, str) or split(effect.at)[0] not in build.cells:
        return None
    T = track_of(build, program, {}, COARSE).at(times, build.dense(build.at(effect.at))[None])[:, 0]
    heat = effect.course(T, times, program, 0)
    file = next(iter(named(truth.slot)))
    return None if heat is None else {"file": file, "t": times.tolist(), "heat": np.round(heat, 3).tolist()}
