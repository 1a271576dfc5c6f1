"""Makes concealed cases: machine.yaml and recordings in a folder each, the keys beside them under seal.

`python -m proof.cases FOLDER COUNT SEED [JOBS]` from the folder tests/.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from threadpoolctl import threadpool_limits

from proof.assembly import Assembly, assemble
from proof.effect import Effect, Setting
from proof.effects_room import FeedHeat, feed_at, turned_feeds
from proof.judgement import VISIBLE
from proof.keys import Truth, key_of, named
from proof.layout import Layout
from proof.observing import ROUGH, WHITE, Recording, observe, record
from proof.plan import Slot, slot
from proof.programs import Program, programs
from proof.score import is_kept_back
from proof.sealed import seal_of, sealed
from proof.strength import Bench, bench, seen, sized, warmth
from proof.written import machine_text

TRIES, PLACES = 8, 3
"""Effects that are drawn to find a visible one, and places of one that changes the drawing."""
RUNS_AWAY = 1e4
"""σ of what is seen of an effect (some 300 K) from which the true machine would not outlive its run: drawn again."""
ROOM = 2.0
"""K by which a room that is not recorded may differ from what the user states."""
SHARE_DRAWN = 0.7
"""Of it, what the means of the runs are drawn from, evenly to both sides."""
ROOM_STD = 1.0
"""K: ± that the user writes behind it, 1σ of what is drawn (1.4 K/√3) rounded up."""


@dataclass(frozen=True)
class Case:
    """The files of a case by their names, what is public about it, and what it conceals."""

    files: Mapping[str, str]
    about: Mapping[str, Any]
    key: Mapping[str, Any]


def make_cases(
    folder: Path | str, count: int, seed: int, jobs: int = 1, only: Sequence[int] | None = None
) -> list[str]:
    """Writes the cases, cases.json and keys/; their names. Case k depends on the seed and on k alone: those that are
    there already stay as they are. only: numbers of the cases, from 0, in place of the first `count`."""
    folder = Path(folder)
    (folder / "keys").mkdir(parents=True, exist_ok=True)
    numbers = list(range(count) if only is None else only)
    names = [f"case-{i + 1:03d}" for i in numbers]
    work = partial(write_case, folder, seed)
    if jobs > 1:
        with ProcessPoolExecutor(jobs) as pool:
            seals = list(pool.map(work, names, numbers))
    else:
        seals = [work(*each) for each in zip(names, numbers, strict=True)]
    sealed_cases = {name: {"sha256": seal} for name, seal in zip(names, seals, strict=True)} | published(folder)
    told = {"seed": seed, "development": not is_kept_back(seed), "cases": sealed_cases}
    (folder / "cases.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    return names


def published(folder: Path) -> dict[str, dict[str, str]]:
    """The seals that stand already: whatever becomes of a key, they stay what they were."""
    at = folder / "cases.json"
    return json.loads(at.read_text(encoding="utf-8"))["cases"] if at.is_file() else {}


def write_case(folder: Path, seed: int, name: str, index: int) -> str:
    """Makes one case and writes it, unless it is there; the seal of its key."""
    at = folder / "keys" / f"{name}.json"
    if at.is_file() and (folder / name / "case.json").is_file():
        return seal_of(at.read_text(encoding="utf-8"))
    rng = np.random.default_rng([seed, index, 2])
    with threadpool_limits(1):
        case = make_case(rng, slot(seed, index))
    (folder / name).mkdir(exist_ok=True)
    for file, text in case.files.items():
        (folder / name / file).write_text(text, encoding="utf-8")
    at.write_text(text := sealed(case.key, rng), encoding="utf-8")
    (folder / name / "case.json").write_text(json.dumps(case.about, indent=1) + "\n", encoding="utf-8")
    return seal_of(text)


def make_case(rng: Generator, slot: Slot) -> Case:
    """Numbers, programs, effects of a visible strength, and recordings of what the machine really did."""
    layout = slot.layout
    numbers = {path: value * float(np.exp(0.15 * rng.standard_normal())) for path, value in layout.nominal().items()}
    truth = visible_truth(rng, slot, numbers, programmed(rng, slot))
    layout = truth.on.layout
    believed = {path: truth.numbers[path] * wrong(rng, slot.what) for path in layout.nominal()}
    recordings = recorded(rng, truth)
    files = {"machine.yaml": machine_text(layout, believed), **files_of(slot, layout, recordings)}
    about = {"train": [*named(slot)][:-1], "holdout": [*named(slot)][-1:], "layout": slot.layout.name,
             "parts": len(layout.parts), "seconds_limit": None}  # fmt: skip
    return Case(files, about, key_of(truth))


def programmed(rng: Generator, slot: Slot) -> tuple[Program, ...]:
    """What is done to the machine; its axes move where they heat it, or now and then to tempt."""
    layout, is_stated = slot.layout, slot.room == "stated"
    made = programs(rng, layout.top_speed, layout.reference, slot.runs, SHARE_DRAWN * ROOM if is_stated else 0.45)
    if is_stated:
        made = tuple(replace(program, waves=()) for program in made)
    if layout.feeds or FeedHeat in slot.effects or rng.random() < 0.4:
        made = tuple(replace(program, feeds=turned_feeds(rng, program)) for program in made)
    return made


def visible_truth(rng: Generator, slot: Slot, numbers: Mapping[str, float], programs: tuple[Program, ...]) -> Truth:
    """The effects at places and of a strength that calibration cannot hide, the best of some tries."""
    tried = []
    for _ in range(PLACES):
        layout, fixed = slot.layout, {}
        for kind in slot.effects:
            at = site(rng, layout, kind)
            if kind.without(layout, at) is not layout:
                layout, fixed = kind.without(layout, at), {**fixed, kind: at}
        known = {path: numbers[path] for path in layout.nominal()}
        if not slot.effects:
            return Truth(slot, known, programs, (), Bench.idle(layout, known, programs[:-1]))
        on = bench(layout, known, programs[:-1], rooms(slot))
        warm = warmth(layout, on.numbers, programs[:-1])
        setting = Setting(layout, warm, slot.truth == "hard", slot.truth != "lumped", slot.runs)
        effects = tuple(visible(rng, on, setting, kind, fixed.get(kind)) for kind in slot.effects)
        tried.append(Truth(slot, on.numbers, programs, effects, on))
        if not fixed or is_shown(seen(on, effects)["after_calibration"]):
            break
    return max(tried, key=lambda truth: rank_of(seen(truth.on, truth.effects)["after_calibration"]))


def rooms(slot: Slot) -> float:
    return ROOM if slot.room == "stated" else 0.0


def site(rng: Generator, layout: Layout, kind: type[Effect]) -> Any:
    sites = layout.sites[kind.site]
    return sites[int(rng.integers(len(sites)))]


def wrong(rng: Generator, what: str) -> float:
    """What a user's number is off by: 15 % (1 σ); anything up to 30 % where nothing else is wrong."""
    off = rng.uniform(-0.3, 0.3) if what == "wrong_numbers" else 0.15 * np.clip(rng.standard_normal(), -2.5, 2.5)
    return float(np.exp(off))


def visible(rng: Generator, on: Bench, setting: Setting, kind: type[Effect], at: Any = None) -> Effect:
    """An effect at one of its sites that calibration cannot hide; the most visible of some tries that does not run
    away."""
    found: list[tuple[float, Effect]] = []
    while len(found) < (TRIES if at is None else 1) and not (found and is_shown(found[-1][0])):
        where = site(rng, setting.layout, kind) if at is None else at
        effect = sized(rng, on, kind.draw(setting, where, rng))
        found.append((seen(on, [effect])["after_calibration"], effect))
    return max(found, key=lambda pair: rank_of(pair[0]))[1]


def is_shown(left: float) -> bool:
    """Whether so much [σ] is seen, of a machine that outlives it."""
    return VISIBLE < left < RUNS_AWAY


def rank_of(left: float) -> tuple[bool, float]:
    """By which what leaves so much [σ] is taken: the most that does not run away."""
    return left < RUNS_AWAY, left


def recorded(rng: Generator, truth: Truth) -> list[Recording]:
    """Recordings to learn from and one to be judged on, each part starting some 0.1 K off where it stood."""
    slot, layout = truth.slot, truth.on.layout
    noise = ROUGH if slot.truth == "hard" else WHITE
    warm = [name for name, sigma in layout.channels().items() if sigma < 0.1]
    offsets = {name: noise.offset * float(np.clip(rng.standard_normal(), -2, 2)) for name in warm}
    made = []
    for index, program in enumerate(truth.programs):
        stood = program.mean if slot.room == "stated" else layout.reference
        start = {name: stood + float(rng.uniform(-0.15, 0.15)) for name in (*layout.parts, *layout.vessels)}
        build = concealed(truth, program, index)
        times = program.times()
        shown = observe(build, program, {**dict.fromkeys(build.owner, stood), **start}, times)
        feed = feed_at(program, times) if program.feeds else None
        has_room = slot.room == "recorded"
        made.append(record(rng, program, times, shown, layout.channels(), noise, offsets, feed, has_room))
    return made


def concealed(truth: Truth, program: Program, index: int) -> Assembly:
    """The true machine of one recording."""
    build = assemble(truth.on.layout, truth.numbers, truth.slot.truth != "lumped")
    for effect in truth.effects:
        effect.conceal(build, program, index)
    return build


def files_of(slot: Slot, layout: Layout, recordings: Sequence[Recording]) -> dict[str, str]:
    """The tables, with mappings that state the room where it was not recorded."""
    files = {}
    for (given, table), recording in zip(named(slot).items(), recordings, strict=True):
        files[table] = recording.text()
        if given != table:
            files[given] = recording.mapping(table.removesuffix(".csv"), table, layout.reference, ROOM_STD)
    return files


if __name__ == "__main__":
    target, how_many, start_seed, *more = sys.argv[1:]
    print(f"{len(make_cases(target, int(how_many), int(start_seed), int(more[0]) if more else 1))} cases in {target}")
