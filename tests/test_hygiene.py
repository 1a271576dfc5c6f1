"""Readings that cannot be true: each fault on its own is told and set aside, and what is clean stays clean."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from network import Machine, Recording, calibrate, compare, diagnose, simulate
from network.cli import main
from network.platform.refusal import Complaints
from network.recordings.columns import Column, Samples
from network.recordings.csv_table import write_csv
from network.recordings.hygiene.frozen import hanging
from network.recordings.hygiene.glue import find_glued
from network.recordings.hygiene.jumps import chance_of_steps
from network.recordings.hygiene.set_aside import SetAside
from network.recordings.pieces import find_cuts
from network.recordings.runs import runs_of
from network.recordings.scenario import Scenario
from network.recordings.time_order import FALSE_ALARM

SHARED = Path(__file__).parents[2] / "shared"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="the folder shared/ is not beside this repository")
MILL = "machines/vertical_mill.yaml"
INPUTS = {
    "speed": [{"for": "40 min", "at": "6000 rpm"}, {"for": "50 min", "at": "1000 rpm"}, {"at": "4000 rpm"}],
    "ambient": {"sine": {"mean": "22 degC", "amplitude": "1 K", "period": "6 h"}},
}


def made(seed: int, start: str | None = None) -> Recording:
    """A run of the mill with every sensor's noise."""
    machine = Machine.load(MILL)
    inputs = {name: INPUTS.get(name, "0 m/min") for name in machine.inputs}
    run = simulate(machine, Scenario.of("made", "3 h", inputs, start=start), noise_seed=seed)
    columns = {name: Column(name, unit, v) for name, unit, v in run.columns_in_si() if not name.startswith("tcp")}
    return Recording("made", "made.csv", run.t, columns)


@pytest.fixture(scope="module")
def mill() -> Machine:
    return Machine.load(MILL)


@pytest.fixture(scope="module")
def clean() -> Recording:
    return made(1)


def temperatures(machine: Machine) -> list[str]:
    return [name for name, sensor in machine.sensors.items() if sensor.place is not None]


def changed(recording: Recording, name: str, values: Any) -> Recording:
    column = replace(recording.columns[name], values=np.asarray(values, float))
    return replace(recording, columns={**recording.columns, name: column})


def excluded(machine: Machine, recording: Recording) -> tuple[SetAside, ...]:
    (run,) = runs_of(machine, recording)
    for aside in run.excluded or ():
        kept = np.isfinite(run.columns[aside.channel].values[aside.rows])
        assert kept.all() if aside.is_told_only else not kept.any()
    return run.excluded or ()


def test_clean_runs_stay_clean(mill: Machine) -> None:
    assert [excluded(mill, made(seed)) for seed in range(10)] == [()] * 10


@pytest.mark.parametrize("after", [900, 500, 301])
def test_an_offset_for_good_is_set_aside_from_its_instant(mill: Machine, clean: Recording, after: int) -> None:
    name = temperatures(mill)[-1]
    values = clean.columns[name].values + np.where(np.arange(len(clean.t)) >= after, 5.0, 0.0)
    (aside,) = excluded(mill, changed(clean, name, values))
    assert (aside.channel, aside.begin, aside.until) == (name, clean.t[after], clean.t[-1])
    assert aside.size == pytest.approx(5, abs=0.3) and aside.readings == len(clean.t) - after
    sentence = f"made.csv: {name} leaves the other temperatures at once, for good, by "
    assert aside.sentence("made.csv").startswith(sentence) and aside.sentence("made.csv").endswith(
        "readings are left out"
    )


def test_what_comes_back_or_what_all_do_is_left_alone(mill: Machine, clean: Recording) -> None:
    window = (clean.t > 3000) & (clean.t < 6000)
    name = temperatures(mill)[-1]
    assert excluded(mill, changed(clean, name, clean.columns[name].values + 3.0 * window)) == ()
    ramp = np.clip((clean.t - 5000) / 2000, 0, 1)
    assert excluded(mill, changed(clean, name, clean.columns[name].values + 5 * ramp)) == ()
    relaxing = np.where(clean.t > 5000, 5 - 5 * np.exp(-(clean.t - 5000) / 60), 0.0)
    assert excluded(mill, changed(clean, name, clean.columns[name].values + relaxing)) == ()


@pytest.mark.parametrize(("text", "factor", "offset"), [("degF", 1.8, 32.0), ("K", 1.0, 273.15)])
@pytest.mark.parametrize("window", [(0.0, 1e9), (4000.0, 1e9), (4000.0, 8000.0)])
def test_another_unit_is_named(
    mill: Machine, clean: Recording, text: str, factor: float, offset: float, window: tuple[float, float]
) -> None:
    name = temperatures(mill)[0]
    own, there = clean.columns[name].values, (clean.t >= window[0]) & (clean.t < window[1])
    (aside,) = excluded(mill, changed(clean, name, np.where(there, own * factor + offset, own)))
    assert aside.channel == name and f"told in {text}" in aside.why
    assert aside.rows.tolist() == np.flatnonzero(there).tolist()


def test_lone_readings_are_set_aside(mill: Machine, clean: Recording) -> None:
    rows = [100, 455, 600, 888]
    for name, size, shown in ((temperatures(mill)[0], 10.0, "K"), ("dz", 2e-3, "um")):
        values = clean.columns[name].values.copy()
        values[rows] += [size, -size, size, size]
        (aside,) = excluded(mill, changed(clean, name, values))
        assert aside.rows.tolist() == rows and abs(aside.size) == pytest.approx(size, rel=0.05)
        assert aside.shown_size[1] == shown
    often = clean.columns["dz"].values + np.where(np.arange(len(clean.t)) % 20 == 7, 1e-3, 0)
    assert excluded(mill, changed(clean, "dz", often)) == (), "no exception"


def test_a_frozen_channel(mill: Machine, clean: Recording) -> None:
    name = temperatures(mill)[0]
    values = clean.columns[name].values.copy()
    values[300:500] = values[300]
    (aside,) = excluded(mill, changed(clean, name, values))
    assert (aside.rows[0], aside.rows[-1], aside.size) == (301, 499, 0.0)
    assert aside.sentence("r").startswith(f"r: {name} is stuck from ")
    assert not hanging(np.full(59, 1.0)).any() and hanging(np.full(60, 1.0)).all()
    steady = np.round(20 + np.linspace(0, 1, 400), 1)
    assert not hanging(steady).any(), "a coarse channel repeats itself all the time"


def test_what_no_sensor_gives_is_set_aside(mill: Machine, clean: Recording) -> None:
    """What ran away in a simulation, or lost its exponent; a wire that came off reads less and is looked for later."""
    for name in (temperatures(mill)[0], "dz"):
        values = clean.columns[name].values.copy()
        values[-200:] = 1e250 ** np.linspace(0.1, 1, 200)
        aside = excluded(mill, changed(clean, name, values))[0]
        assert (aside.rows[0], aside.rows[-1]) == (len(values) - 200, len(values) - 1)
        assert aside.sentence("r").startswith(f"r: {name} has readings beyond what any sensor gives from ")
    loose = clean.columns[name := temperatures(mill)[0]].values.copy()
    loose[100:400] = 999.0
    assert not any("beyond" in aside.why for aside in excluded(mill, changed(clean, name, loose)))


def test_a_channel_that_scatters_is_told_and_kept(mill: Machine, clean: Recording) -> None:
    name = temperatures(mill)[0]
    noise = np.random.default_rng(3).normal(0, 5.0, len(clean.t))
    (aside,) = excluded(mill, changed(clean, name, clean.columns[name].values + noise))
    assert aside.is_told_only and aside.size == pytest.approx(5, rel=0.1)
    assert "times as much from sample to sample as the other temperatures" in aside.sentence("r")


def glued(first: Recording, second: Recording, at: int) -> Samples:
    columns = {
        name: replace(c, values=np.concatenate([c.values[:at], second.columns[name].values[at:]]))
        for name, c in first.columns.items()
    }
    rows = np.arange(len(first.t))
    return Samples(first.t, columns, rows + 2, ("made.csv",), rows * 0, "s")


def test_glued_recordings_are_parted(clean: Recording) -> None:
    other = made(2, start="32 degC")
    (cut,) = find_cuts(glued(clean, other, 300), Complaints())
    assert cut.index == 300 and "temperatures jump at once" in cut.why and "no input does" in cut.why
    assert find_cuts(glued(clean, clean, 300), Complaints()) == ()


def test_what_an_input_may_have_done_is_no_glue() -> None:
    t = np.arange(400) * 600.0
    heat = np.where(t > 120000, 1.0, 0.0)
    draw = np.random.default_rng(0)
    warm = [Column(f"T{k}", "degC", 20 + 8 * heat + draw.normal(0, 0.05, 400)) for k in range(4)]
    (found,) = find_glued(t, warm)
    assert found == (201, ["T0", "T1", "T2", "T3"]), "nothing recorded did it"
    assert find_glued(t, [*warm, Column("heater", "1", heat)]) == []
    often = Column("heater", "1", heat + ((t > 30000) & (t < 60000)))
    assert len(find_glued(t, [*warm, often])) == 1, "it did nothing of the kind before"


@pytest.mark.parametrize("tail", ["normal", "laplace", "t3"])
def test_chance_of_steps_is_that_of_chance(tail: str) -> None:
    draw = np.random.default_rng(7)
    shapes = {
        "normal": lambda: draw.normal(size=800), "laplace": lambda: draw.laplace(size=800),
        "t3": lambda: draw.standard_t(3, size=800),
    }  # fmt: skip
    t = np.arange(800.0)
    least = np.array([chance_of_steps(t, np.cumsum(shapes[tail]())).min() for _ in range(2000)])
    for level in (0.01, 0.1):
        assert (least < level).mean() < 3 * level
    assert (least < FALSE_ALARM).mean() < 5 * FALSE_ALARM + 2e-3


def offset_run(clean: Recording, name: str) -> Recording:
    return changed(clean, name, clean.columns[name].values + np.where(clean.t >= 4000, 8.0, 0.0))


def test_what_is_set_aside_counts_in_no_figure(mill: Machine, clean: Recording, tmp_path: Path) -> None:
    name = temperatures(mill)[-1]
    bad = offset_run(clean, name)
    result = compare(mill, bad)
    summary = result.summary()["recordings"][0]
    assert summary["channels"][name]["n"] == 400 and summary["channels"][name]["max"] < 4
    told = summary["excluded"][name][0]
    assert (told["from"], told["set_aside"], told["size"]["unit"]) == (4000, True, "K")
    assert result.warnings[0].startswith(f"made.csv: {name} leaves the other temperatures")
    write_csv(tmp_path / "r.csv", bad.t, {n: (c.unit, c.values) for n, c in bad.columns.items()})
    main(["compare", MILL, str(tmp_path / "r.csv"), "--json", str(tmp_path / "r.json")])
    written = json.loads((tmp_path / "r.json").read_text())["recordings"][0]
    assert written["excluded"][name][0]["readings"] == told["readings"]


def test_calibrate_and_diagnose_tell_it(mill: Machine, clean: Recording) -> None:
    blocks = Machine.load("machines/two_blocks.yaml")
    run = simulate(blocks, Scenario.of("x", "2 h", {"ambient": "22 degC"}), noise_seed=1)
    columns = {name: Column(name, unit, v) for name, unit, v in run.columns_in_si() if not name.startswith("tcp")}
    good = Recording("x", "x.csv", run.t, columns)
    bad = offset_run(good, "T_cold")
    found = calibrate(blocks, bad)
    assert found.warnings[0].startswith("x.csv: T_cold leaves the other temperatures") and found.after.rmse_in_noise < 3
    assert found.summary()["fit"]["train"]["after"]["recordings"][0]["excluded"]["T_cold"][0]["set_aside"]
    told = diagnose(blocks, bad)
    assert any("x.csv: T_cold leaves the other temperatures" in note for note in told.notes)
    aside = told.summary()["runs"][0]["excluded"]["T_cold"][0]
    assert not aside["set_aside"], "a diagnosis names it by itself"


@needs_shared
def test_real_recordings_that_are_clean_stay_clean() -> None:
    for case in sorted((SHARED / "cases").iterdir()):
        if case.is_dir():
            machine = Machine.load(case / "machine.yaml")
            assert not [a for p in case.glob("*.csv") for r in runs_of(machine, Recording.load(p)) for a in r.excluded]
    rigs = {"heated_building": "building_*", "lathe_warm_up": "lathe_*", "three_blocks": "three_*",
            "toaster_oven": "toaster_*", "two_heater_rig": "tclab_*"}  # fmt: skip
    for rig, pattern in rigs.items():
        machine = Machine.load(f"machines/{rig}.yaml")
        for path in Path("tests/recordings").glob(f"{pattern}.yaml"):
            recording = Recording.load(path)
            assert not recording.cuts and not [a for r in runs_of(machine, recording) for a in r.excluded]


@needs_shared
def test_the_thermistor_that_is_not_true_is_told(tmp_path: Path) -> None:
    text = Path("tests/recordings/three_blocks.yaml").read_text().replace("../../../shared", str(SHARED))
    (tmp_path / "m.yaml").write_text(text.replace("  NTC8_C:", '  NTC7_C: "NTC7 [degC]"\n  NTC8_C:'))
    machine = Path("machines/three_blocks.yaml").read_text()
    line = "  NTC7: {measures: cylinder 2@0.3, noise: 0.3 mK}\n  NTC8: {measures"
    (tmp_path / "three.yaml").write_text(machine.replace("  NTC8: {measures", line))
    loaded = Machine.load(tmp_path / "three.yaml")
    (aside,) = excluded(loaded, Recording.load(tmp_path / "m.yaml"))
    assert aside.channel == "NTC7" and aside.is_told_only


@needs_shared
def test_false_trips_of_the_probe_are_set_aside() -> None:
    machine = Machine.load("machines/heated_gantry.yaml")
    (aside,) = excluded(machine, Recording.load("tests/recordings/voron_2021_06_05.yaml"))
    assert (aside.channel, aside.readings) == ("dz", 11)
