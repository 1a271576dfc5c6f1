"""Makes concealed cases: machine.yaml and recordings in a folder each, the keys beside them under seal.

`python -m proof.cases FOLDER COUNT SEED [JOBS]` from the folder tests/.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator

from proof.assembly import Assembly, assemble
from proof.effect import Effect, Setting
from proof.layout import Layout
from proof.observing import ROUGH, WHITE, Recording, observe, record
from proof.plan import Slot, slots
from proof.programs import Program, four_programs
from proof.sealed import seal_of, sealed
from proof.strength import Bench, bench, seen, sized, warmth
from proof.system import Array
from proof.written import machine_text

FILES = ("train1", "train2", "train3", "holdout")
VISIBLE = 0.9
"""Noise units rms that an effect leaves at the least after calibration."""
TRIES = 8


@dataclass(frozen=True)
class Case:
    """The files of a case, and what they conceal."""

    machine: str
    recordings: Mapping[str, Recording]
    key: Mapping[str, Any]


def make_cases(folder: Path | str, count: int, seed: int, jobs: int = 1, reserved: bool = True) -> list[str]:
    """Writes the cases, cases.json and keys/; their names. The same seed makes the same cases.

    Without `reserved` the layout that is kept for the final score does not occur.
    """
    folder = Path(folder)
    (folder / "keys").mkdir(parents=True, exist_ok=True)
    plan = slots(count, np.random.default_rng([seed, 0]), reserved)
    names = [f"case-{i + 1:03d}" for i in range(count)]
    work = partial(write_case, folder, seed)
    if jobs > 1:
        with ProcessPoolExecutor(jobs) as pool:
            seals = list(pool.map(work, names, plan, range(count)))
    else:
        seals = [work(*each) for each in zip(names, plan, range(count), strict=True)]
    told = {"seed": seed, "cases": {name: {"sha256": seal} for name, seal in zip(names, seals, strict=True)}}
    (folder / "cases.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    return names


def write_case(folder: Path, seed: int, name: str, slot: Slot, index: int) -> str:
    """Makes one case and writes it; the seal of its key."""
    rng = np.random.default_rng([seed, index + 1])
    case = make_case(rng, slot)
    (folder / name).mkdir(exist_ok=True)
    (folder / name / "machine.yaml").write_text(case.machine, encoding="utf-8")
    for file, recording in case.recordings.items():
        (folder / name / f"{file}.csv").write_text(recording.text(), encoding="utf-8")
    text = sealed(case.key, rng)
    (folder / "keys" / f"{name}.json").write_text(text, encoding="utf-8")
    return seal_of(text)


def make_case(rng: Generator, slot: Slot) -> Case:
    """Numbers, programs, effects of a visible strength, and recordings of what the machine really did."""
    layout = slot.layout
    numbers = {path: value * float(np.exp(0.15 * rng.standard_normal())) for path, value in layout.nominal().items()}
    programs = four_programs(rng, layout.top_speed, layout.reference)
    on = bench(layout, numbers, programs[:3])
    setting = Setting(layout, warmth(layout, numbers, programs[:3]), slot.truth == "hard", slot.truth != "lumped")
    effects = [visible(rng, on, setting, kind) for kind in slot.effects]
    recordings = recorded(rng, slot, numbers, programs, effects)
    believed = {path: value * wrong(rng, slot.what) for path, value in numbers.items()}
    return Case(machine_text(layout, believed), recordings, key_of(slot, effects, numbers, seen(on, effects)))


def wrong(rng: Generator, what: str) -> float:
    """What a user's number is off by: 15 % (1 σ); anything up to 30 % where nothing else is wrong."""
    off = rng.uniform(-0.3, 0.3) if what == "wrong_numbers" else 0.15 * np.clip(rng.standard_normal(), -2.5, 2.5)
    return float(np.exp(off))


def visible(rng: Generator, on: Bench, setting: Setting, kind: type[Effect]) -> Effect:
    """An effect at one of its sites that calibration cannot hide; the most visible of some tries."""
    found: list[tuple[float, Effect]] = []
    sites = setting.layout.sites[kind.site]
    while len(found) < TRIES and not (found and found[-1][0] > VISIBLE):
        effect = sized(rng, on, kind.draw(setting, sites[int(rng.integers(len(sites)))], rng))
        found.append((seen(on, [effect])["after_calibration"], effect))
    return max(found, key=lambda pair: pair[0])[1]


def recorded(
    rng: Generator, slot: Slot, numbers: Mapping[str, float], programs: Sequence[Program], effects: Sequence[Effect]
) -> dict[str, Recording]:
    """Three recordings to learn from and one to be judged on, each part starting some 0.1 K off the reference."""
    layout, noise = slot.layout, ROUGH if slot.truth == "hard" else WHITE
    warm = [name for name, sigma in layout.channels().items() if sigma < 0.1]
    offsets = {name: noise.offset * float(np.clip(rng.standard_normal(), -2, 2)) for name in warm}
    fed = rng.random() < 0.4
    files = {}
    for index, (file, program) in enumerate(zip(FILES, programs, strict=True)):
        start = {name: layout.reference + float(rng.uniform(-0.15, 0.15)) for name in layout.parts}
        build = concealed(layout, numbers, slot.truth != "lumped", program, effects, index)
        shown = observe(build, program, start, program.times())
        feed = idle_feed(rng, program) if fed else None
        files[file] = record(rng, program, program.times(), shown, layout.channels(), noise, offsets, feed)
    return files


def concealed(
    layout: Layout, numbers: Mapping[str, float], fine: bool, program: Program, effects: Sequence[Effect], index: int
) -> Assembly:
    """The true machine of one recording."""
    build = assemble(layout, numbers, fine)
    for effect in effects:
        effect.conceal(build, program, index)
    return build


def idle_feed(rng: Generator, program: Program) -> Array:
    """A feed [m/min] that drives nothing: it only tempts."""
    values = {edge: float(rng.choice([0.0, 4.0, 9.0, 15.0])) for edge in program.edges}
    return np.array([values[max(edge for edge in program.edges if edge <= t + 1e-9)] for t in program.times()])


def key_of(
    slot: Slot, effects: Sequence[Effect], numbers: Mapping[str, float], visibility: Mapping[str, float]
) -> dict[str, Any]:
    """What is concealed, and which kinds and places would be right answers."""
    return {
        "layout": slot.layout.name,
        "truth": slot.truth,
        "class": slot.what,
        "effects": {effect.name: effect.told() for effect in effects},
        "kinds": [list(effect.kinds) for effect in effects],
        "places": [effect.places() for effect in effects],
        "in_noise": dict(visibility),
        "numbers": dict(numbers),
    }


if __name__ == "__main__":
    target, how_many, start_seed, *more = sys.argv[1:]
    print(f"{len(make_cases(target, int(how_many), int(start_seed), int(more[0]) if more else 1))} cases in {target}")
