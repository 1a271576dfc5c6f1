"""Sealed pairs: recordings of one machine then and now, between which one number or one thermometer has changed, or
nothing has.

Pair k depends on the seed and on k alone. A number changes by so much that the runs of now differ by LEAST to MOST
noise units rms from what any numbers that are the same then and now can imitate; a thermometer by 0.6 to 3 K.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from threadpoolctl import threadpool_limits

from proof.assembly import assemble
from proof.effects_room import feed_at, turned_feeds
from proof.layout import Layout
from proof.observing import ROUGH, WHITE, Recording, observe, record
from proof.plan import TRUTHS, machine
from proof.programs import Program, programs
from proof.score import is_kept_back
from proof.sealed import seal_of, sealed
from proof.strength import COARSE, EVERY, LEAST, MOST, Bench, bench, rms
from proof.system import Array
from proof.written import machine_text

THEN, NOW = 3, 3
"""Runs of each set."""
TRIES = 12
FEWEST, GROTESQUE = 0.15, 1.4
"""Logarithm of the factor that a number changes by."""
SENSORS = 3
"""Of so many changes one is of a thermometer."""
AS_GOOD = 0.25
"""Noise units rms below which two changes leave the same: no one could tell them apart."""


@dataclass(frozen=True)
class Change:
    """number: its path, or sensors.NAME; size: its factor, or kelvin; visible: noise units rms that it leaves; alike:
    other numbers that would show the same."""

    number: str
    size: float
    visible: float
    alike: tuple[str, ...] = ()


def list_pairs(changed: int, unchanged: int) -> list[str]:
    """Names of pairs, changed and unchanged ones in turn."""
    sides = (("changed", changed), ("same", unchanged))
    both = [[f"{what}-{k + 1:03d}" for k in range(count)] for what, count in sides]
    return [name for pair in zip_longest(*both) for name in pair if name]


def make_pair_of(folder: Path, seed: int, name: str) -> None:
    """Writes a pair, unless it is there, and publishes the seal of its key."""
    (folder / "keys").mkdir(parents=True, exist_ok=True)
    at, seal = folder / "cases.json", write_pair(folder, seed, name)
    told = json.loads(at.read_text(encoding="utf-8")) if at.is_file() else {
        "seed": seed, "development": not is_kept_back(seed), "cases": {}}  # fmt: skip
    told["cases"].setdefault(name, {"sha256": seal})
    at.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def write_pair(folder: Path, seed: int, name: str) -> str:
    """Makes one pair and writes it, unless it is there; the seal of its key."""
    at = folder / "keys" / f"{name}.json"
    if at.is_file():
        return seal_of(at.read_text(encoding="utf-8"))
    what, _, number = name.partition("-")
    rng = np.random.default_rng([seed, int(number), 3, what == "same"])
    with threadpool_limits(1):
        files, key = make_pair(rng, int(number) - 1, seed, what == "changed")
    (folder / name).mkdir(exist_ok=True)
    for file, text in files.items():
        (folder / name / file).write_text(text, encoding="utf-8")
    at.write_text(text := sealed(key, rng), encoding="utf-8")
    return seal_of(text)


def make_pair(rng: Generator, index: int, seed: int, is_changed: bool) -> tuple[dict[str, str], dict[str, Any]]:
    """Files and key: one machine, its programs, and the change."""
    truth, layout = TRUTHS[(index + seed) % len(TRUTHS)], machine(rng, (), True)
    numbers = {path: value * float(np.exp(0.15 * rng.standard_normal())) for path, value in layout.nominal().items()}
    runs = programs(rng, layout.top_speed, layout.reference, THEN + NOW)[: THEN + NOW]
    if layout.feeds:
        runs = tuple(replace(run, feeds=turned_feeds(rng, run)) for run in runs)
    change = None
    if is_changed and index % SENSORS == SENSORS - 1:
        change = changed_thermometer(rng, layout)
    elif is_changed:
        change = changed_number(rng, layout, numbers, runs)
    believed = {path: numbers[path] * float(np.exp(0.15 * np.clip(rng.standard_normal(), -2.5, 2.5)))
                for path in layout.nominal()}  # fmt: skip
    files = {"machine.yaml": machine_text(layout, believed)}
    for name, recording in zip(names(), recorded(rng, layout, numbers, runs, truth, change), strict=True):
        files[f"{name}.csv"] = recording.text()
    key = {"layout": layout.name, "truth": truth, "change": None if change is None else vars(change),
           "numbers": dict(numbers)}  # fmt: skip
    return files, key


def names() -> list[str]:
    return [*(f"then{k + 1}" for k in range(THEN)), *(f"now{k + 1}" for k in range(NOW))]


def changed_thermometer(rng: Generator, layout: Layout) -> Change:
    warm = [name for name, place in layout.sensors.items() if not place.startswith("tcp.")]
    size = float(rng.choice([-1, 1]) * rng.uniform(0.6, 3))
    return Change(f"sensors.{warm[int(rng.integers(len(warm)))]}", size, abs(size) / 0.05)


def changed_number(rng: Generator, layout: Layout, numbers: Mapping[str, float], runs: Sequence[Program]) -> Change:
    """A number and a factor that are seen; the most visible of some tries."""
    on, tried = bench(layout, numbers, runs), list[Change]()
    paths = list(layout.nominal())
    while len(tried) < TRIES and not (tried and tried[-1].visible >= LEAST):
        path, way = paths[int(rng.integers(len(paths)))], float(rng.choice([-1, 1]))
        aim = float(np.exp(rng.uniform(np.log(LEAST), np.log(MOST))))
        tried.append(sized(on, path, way, aim))
    best = max(tried, key=lambda change: change.visible)
    return Change(best.number, best.size, best.visible, tuple(alike(on, best)))


def sized(on: Bench, path: str, way: float, aim: float) -> Change:
    """A change that leaves so much, within what is not grotesque."""
    log, left = 0.3, 0.0
    for _ in range(3):
        left = rms(on.remaining(moved(on, path, float(np.exp(way * log)))))
        log = float(np.clip(log * aim / max(left, 1e-6), FEWEST, GROTESQUE))
    left = rms(on.remaining(moved(on, path, float(np.exp(way * log)))))
    return Change(path, float(np.exp(way * log)), round(left, 3))


def moved(on: Bench, path: str, factor: float) -> Array:
    """What the runs of now show otherwise, in units of noise; then nothing."""
    rows = []
    for index, program in enumerate(on.programs):
        now = index >= THEN
        build = assemble(on.layout, {**on.numbers, path: on.numbers[path] * (factor if now else 1.0)})
        shown = observe(build, program, {}, program.times(EVERY), COARSE)
        rows += [values / on.layout.channels()[name] for name, values in shown.items()]
    return np.asarray(np.concatenate(rows) - on.plain)


def alike(on: Bench, change: Change) -> list[str]:
    """Numbers whose change now, by as much as fits best, would leave next to nothing of what is seen."""
    whole = on.remaining(moved(on, change.number, change.size))
    told = []
    for path in on.layout.nominal():
        other = on.remaining(moved(on, path, 1.1))
        share = float(whole @ other) / max(float(other @ other), 1e-12)
        if path != change.number and rms(whole - share * other) < AS_GOOD:
            told.append(path)
    return told


def recorded(
    rng: Generator, layout: Layout, numbers: Mapping[str, float], runs: Sequence[Program], truth: str,
    change: Change | None,
) -> list[Recording]:  # fmt: skip
    """Every run, each part starting some 0.1 K off the reference; sensors' own offsets stay what they are."""
    noise, channels = ROUGH if truth == "hard" else WHITE, layout.channels()
    warm = [name for name, sigma in channels.items() if sigma < 0.1]
    offsets = {name: noise.offset * float(np.clip(rng.standard_normal(), -2, 2)) for name in warm}
    made = []
    for index, program in enumerate(runs):
        now, own, more = index >= THEN, dict(numbers), dict(offsets)
        if change is not None and now and change.number in own:
            own[change.number] *= change.size
        elif change is not None and now:
            name = change.number.removeprefix("sensors.")
            more[name] = more.get(name, 0.0) + change.size
        build = assemble(layout, own, truth != "lumped")
        start = {name: layout.reference + float(rng.uniform(-0.15, 0.15)) for name in (*layout.parts, *layout.vessels)}
        times = program.times()
        shown = observe(build, program, {**dict.fromkeys(build.owner, layout.reference), **start}, times)
        feed = feed_at(program, times) if program.feeds else None
        made.append(record(rng, program, times, shown, channels, noise, more, feed))
    return made
