"""Corrections for a control: the C file against Python, what the reduction keeps, what sensors mend, refusals."""

from __future__ import annotations

import ctypes
import json
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build import machine

from network import Machine, Refused, Scenario, simulate
from network.analysis.correction.correction import Correction, make_correction, sample_inputs
from network.catalogue.declaration.declare import Array
from network.cli import main
from network.recordings.load_source import load_recording
from network.report.files.c_compiler import FLAGS
from network.report.files.correction_c import write_c
from network.report.files.step_timing import time_step

ROOT = Path(__file__).parents[1]
GCC = shutil.which("gcc")
with_gcc = pytest.mark.skipif(GCC is None, reason="no C compiler")


def shipped(name: str, **changes: Any) -> Machine:
    return Machine.load(ROOT / "machines" / f"{name}.yaml", **changes)


def scenario(name: str) -> Scenario:
    return Scenario.load(ROOT / "scenarios" / f"{name}.yaml")


def gantry(**more: Any) -> Correction:
    return make_correction(shipped("gantry_spindle"), [scenario("warm_up_and_stop")], **more)


def bare() -> Machine:
    """No sensor, one input, and a name that would end a comment."""
    grows = {"kind": "stretching", "of": "a", "length": "1 m", "expansion": "1e-5 1/K", "direction": 1}
    skin = {"kind": "convection", "between": ["a", "room"], "conductance": "2 W/K"}
    nodes = {"a": {"heat_capacity": "5 kJ/K"}, "room": {"temperature": "air */ \\ ??/"}}
    return machine(nodes, links={"skin": skin}, tcp={"z": {"grows": grows}})


MADE: dict[str, Callable[[], Correction]] = {
    "gantry": gantry,
    "lathe": lambda: make_correction(shipped("cnc_lathe"), [scenario("shop_day")], states=9),
    "mill, which is not linear": lambda: make_correction(shipped("vertical_mill"), [scenario("warm_up_and_stop")]),
    "fine, without a room": lambda: make_correction(
        shipped("flagship_gantry", level="fine"), [scenario("day_of_work")], channels=["speed", "T_head"]
    ),
    "bare": lambda: make_correction(bare(), []),
    "a fan that the speed drives": lambda: make_correction(machine(**FAN), [scenario("day_of_work")]),
    "spins": lambda: make_correction(shipped("gantry_spindle", sets=[
        "tcp.z.spins={kind: centrifugal_growth, displacement: 9 um, reference_speed: 8000 rpm, direction: -1}"]), []),
}  # fmt: skip


class Compiled:
    """The C file as a library, its warnings errors."""

    def __init__(self, correction: Correction, where: Path) -> None:
        self.filter = correction.filter
        (where / "correction.c").write_text(write_c(correction), encoding="utf-8")
        strict = [*FLAGS, "-Wshadow", "-Wconversion", "-shared", "-fPIC", "-ffp-contract=off"]
        subprocess.run([str(GCC), *strict, "correction.c", "-o", "correction.so"], cwd=where, check=True)
        self.library = ctypes.CDLL(str(where / "correction.so"))
        self.state = (ctypes.c_double * self.filter.states)()

    def run(self, inputs: dict[str, Array], read: Array) -> Array:
        rows = []
        for k in range(len(read)):
            u = (ctypes.c_double * (len(inputs) + 1))(*[values[k] for values in inputs.values()])
            y, moved = (ctypes.c_double * (read.shape[1] + 1))(*read[k]), (ctypes.c_double * len(self.filter.axes))()
            if k == 0:
                self.library.lptn_start(self.state, u, y)
            self.library.lptn_step(self.state, u, y, moved)
            rows.append(list(moved))
        return np.array(rows)


@with_gcc
@pytest.mark.parametrize("name", MADE)
def test_the_c_file_says_what_python_says(name: str, tmp_path: Path) -> None:
    """To 1e-9, over inputs to both sides of zero and beyond their tables, also where readings and inputs fail."""
    correction, rng = MADE[name](), np.random.default_rng(1)
    f, steps = correction.filter, 400
    inputs = {n: (rng.uniform(15, 35, steps) if u == "degC" else rng.choice([0.0, 1.0, -1.0], steps)
                  * rng.uniform(0, 15_000 if u == "rpm" else 50, steps)) for n, u in f.inputs.items()}  # fmt: skip
    for values in inputs.values():
        values[rng.random(steps) < 0.02] = np.nan
    read = rng.uniform(18, 40, (steps, len(f.sensors)))
    read[rng.random(read.shape) < 0.2] = np.nan
    told, _ = f.run(inputs, read)
    assert np.isfinite(told).all() and np.ptp(told, axis=0).min() > 0.1
    np.testing.assert_allclose(Compiled(correction, tmp_path).run(inputs, read), told, rtol=1e-9, atol=1e-9)


@with_gcc
def test_a_step_of_twelve_states_takes_less_than_5_us(tmp_path: Path) -> None:
    fine = make_correction(shipped("flagship_gantry", level="fine"), [scenario("day_of_work")], states=12)
    (tmp_path / "c.c").write_text(write_c(fine), encoding="utf-8")
    seconds = time_step(tmp_path / "c.c")
    assert fine.filter.own == 12 and seconds is not None and 0 < seconds < 5e-6


def test_all_states_lose_only_what_the_step_does() -> None:
    """Nothing is left out: what remains is that inputs are held over a step, so a tenth of it loses a tenth."""
    losses = [gantry(states=99, step=step).losses[0].by_axis["z"] for step in (10.0, 100.0)]
    assert losses[0] < 0.2e-6 and losses[0] < losses[1]


def test_few_states_lose_less_than_the_displacement_can_be_read() -> None:
    correction = gantry()
    assert correction.filter.own < correction.full and max(correction.losses[0].by_axis.values()) < 0.125e-6
    assert [*correction.by_states.values()] == sorted(correction.by_states.values(), reverse=True)


def test_an_equilibrium_is_kept_by_the_fewest_states() -> None:
    """States that are left out follow at once: the machine ends where the full one does."""
    long = Scenario.of("long", "400 h", {"speed": "8000 rpm", "ambient": "25 degC"}, output="1 h")
    correction = make_correction(shipped("gantry_spindle"), [long], states=2, step=600.0)
    loss = correction.losses[0]
    for axis in loss.by_axis:
        assert loss.told[axis][-1] == pytest.approx(loss.full[axis][-1], abs=2e-9)


def test_a_machine_warm_all_through_is_recognised_at_once() -> None:
    """All sensors at 26 °C, the room and the coolant at 26 °C: 4.4 K over the reference everywhere."""
    warm = shipped("gantry_spindle", sets=["nodes.coolant.temperature=26 degC"])
    f = make_correction(warm, [scenario("warm_up_and_stop")], states=9).filter
    told, missed = f.run({"speed": np.zeros(3), "ambient": np.full(3, 26.0)}, np.full((3, len(f.sensors)), 26.0))
    rise = simulate(warm, Scenario.of("warm", "1 h", {"speed": "0 rpm", "ambient": "26 degC"}, start="26 degC"))
    expected = [rise.tcp[axis][0] * 1e6 for axis in f.axes]
    np.testing.assert_allclose(told, [expected] * 3, rtol=1e-6)
    assert np.abs(missed).max() < 1e-6


def test_sensors_mend_what_the_model_has_wrong() -> None:
    """The true jacket takes a third less: with sensors less than half of the error is left."""
    truth = shipped("gantry_spindle", sets=["links.coolant jacket.conductance=20 W/K"])
    run = simulate(truth, scenario("day_of_work"), noise_seed=1)
    f = gantry().filter
    t, inputs = sample_inputs(f, run.schedule)
    read = np.stack([np.interp(t, run.t, run.sensors[name]) for name in f.sensors], axis=1)
    true = np.interp(t, run.t, run.tcp["z"]) * 1e6
    alone, mended = (f.run(inputs, r)[0][:, f.axes.index("z")] - true for r in (np.full_like(read, np.nan), read))
    assert np.sqrt(np.mean(mended**2)) < 0.5 * np.sqrt(np.mean(alone**2))


FAN = {
    "nodes": {"motor": {"heat_capacity": "4 kJ/K"}, "body": {"heat_capacity": "15 kJ/K"},
              "room": {"temperature": "ambient"}},
    "links": {
        "flange": {"kind": "conduction", "between": ["motor", "body"], "conductance": "12 W/K"},
        "skin": {"kind": "convection", "between": ["body", "room"], "conductance": "5 W/K"},
        "fins": {"kind": "forced_convection", "between": ["motor", "room"], "conductance": "3 W/K", "gain": 6,
                 "exponent": 0.8, "reference_speed": "8000 rpm"},
    },
    "sources": {"loss": {"kind": "motor_loss", "into": {"motor": 1}, "copper": "60 W", "iron": "200 W",
                         "reference_speed": "8000 rpm"}},
    "tcp": {"z": {"grows": {"kind": "stretching", "of": "body", "length": "1 m", "expansion": "1e-5 1/K",
                            "direction": 1}}},
    "sensors": {"T": {"measures": "motor", "noise": "0.05 K"}, "dz": {"measures": "tcp.z", "noise": "0.25 um"}},
}  # fmt: skip


def fan(**more: Any) -> Correction:
    return make_correction(machine(**FAN), [scenario("day_of_work")], **more)


def test_a_conductance_that_an_input_drives_is_stepped_with_it() -> None:
    """All states lose what the step does, a tenth of it with a tenth of the step; the mean conductance loses more
    than twenty times as much."""
    losses = {step: fan(states=2, step=step).losses[0].by_axis["z"] for step in (20.0, 2.0)}
    assert losses[20.0] < 1e-6 and losses[2.0] == pytest.approx(losses[20.0] / 10, rel=0.3)
    made = fan(states=2)
    held = replace(made.filter, film_heat=0 * made.filter.film_heat)
    t, inputs = sample_inputs(made.filter, simulate(machine(**FAN), scenario("day_of_work")).schedule)
    read = np.full((len(t), 1), np.nan)
    apart = np.abs(held.run(inputs, read)[0] - made.filter.run(inputs, read)[0]).max()
    assert apart > 20 * 1e6 * made.losses[0].by_axis["z"]


def test_an_equilibrium_with_every_speed_is_that_of_the_full_model() -> None:
    """Held so long that nothing moves any more, the fan at its conductance and not at the mean one; a table is straight
    between its rows to 1e-4."""
    made = fan(states=2)
    for rpm in (0.0, 3000.0, 8000.0):
        long = Scenario.of("long", "100 h", {"speed": f"{rpm} rpm", "ambient": "25 degC"}, output="1 h")
        expected = simulate(machine(**FAN), long).tcp["z"][-1] * 1e6
        inputs = {"speed": np.full(36_000, rpm), "ambient": np.full(36_000, 25.0)}
        told, _ = made.filter.run(inputs, np.full((36_000, 1), np.nan), np.zeros(made.filter.states))
        assert told[-1, 0] == pytest.approx(expected, rel=1e-4)


def test_a_step_too_long_for_a_fan_is_refused() -> None:
    """At rest nearly all the time, 20 W/K leave 4 kJ/K; 170 W/K more at full speed overshoot without end where they are
    held for an hour, and not where they are for 10 s."""
    strong = machine(**{**FAN, "links": {**FAN["links"], "fins": {**FAN["links"]["fins"], "gain": 60}}})
    rests = Scenario.of("rests", "10 h", {"speed": [{"for": "9.8 h", "at": "0 rpm"}, {"at": "8000 rpm"}],
                                          "ambient": "20 degC"})  # fmt: skip
    assert make_correction(strong, [rests], states=2).filter.growth < 1
    with pytest.raises(Refused, match=r"--step: 3600 s is too long for conductances that inputs drive.*--step '720 s'"):
        make_correction(strong, [rests], states=2, step=3600.0)


RUNS = sorted((ROOT.parent / "shared" / "recordings" / "cnc-lathe").glob("run_*.csv"))


@pytest.mark.skipif(not RUNS, reason="the recordings in ../shared/recordings are not here")
def test_the_turning_centre_loses_less_than_half_a_micrometre(tmp_path: Path) -> None:
    """On days with 1000 and 2000 rpm, whose air the chuck stirs."""
    mapping = (ROOT / "tests" / "recordings" / "cnc_lathe.yaml").read_text(encoding="utf-8")
    line = next(line for line in mapping.splitlines() if line.startswith("file:"))
    days = []
    for run in (RUNS[0], RUNS[len(RUNS) // 2]):
        (tmp_path / f"{run.stem}.yaml").write_text(mapping.replace(line, f"file: {run}"), encoding="utf-8")
        days.append(load_recording(tmp_path / f"{run.stem}.yaml"))
    made = make_correction(shipped("cnc_lathe"), days)
    assert all(lost < 0.5e-6 for loss in made.losses for lost in loss.by_axis.values())


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("sources.fridge={kind: thermostat_cooling, into: {housing: 1}, watches: housing, set: 22 degC,"
         " hysteresis: 1 K, power: 90 W}", "sources.fridge switches, which no linear model does; replace it"),
        ("nodes.headstock.melts={at: 28 degC, over: 2 K, latent_heat: 180 kJ}", "nodes.headstock melts"),
        ("sources.lamp={kind: timed_source, into: {beam: 1}, power: 90 W, period: 1 h, duration: 5 min}",
         "sources.lamp follows the clock, which a control does not share"),
        ("sources.rub={kind: bearing_friction, into: {beam: 1}, torque: 1 N m, while: pump}",
         "sources.rub reads pump and speed, and a table has one input"),
    ],
)  # fmt: skip
def test_what_cannot_be_exported_is_told_with_its_entry(change: str, says: str) -> None:
    with pytest.raises(Refused) as refusal:
        make_correction(shipped("gantry_spindle", sets=[change]), [])
    assert says in str(refusal.value)


def test_a_screw_that_grows_as_far_as_its_nut_is_refused() -> None:
    with pytest.raises(Refused, match=r"tcp.x.screw grows grows as far as position says; give the place"):
        make_correction(shipped("ball_screw_axis"), [])


def test_the_command_tells_what_is_lost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = str(ROOT / "scenarios" / "warm_up_and_stop.yaml")
    words = ["export", str(ROOT / "machines" / "gantry_spindle.yaml"), run, "--as", "c"]
    main([*words, "-o", str(tmp_path)])
    out = capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {"correction.c", "export.json", "export.png"}
    told = json.loads((tmp_path / "export.json").read_text())
    lost = told["lost"][0]["axes"]["z"]
    assert lost["unit"] == "um" and 0 < lost["value"] < 0.125 and f"{lost['value']:.3g}"[:5] in out
    with pytest.raises(SystemExit) as end:
        main([*words, "--inputs", "sped", "-o", str(tmp_path)])
    assert end.value.code == 2 and "did you mean 'speed'" in capsys.readouterr().err


def test_the_readme_shows_what_comes_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = next(block for block in readme.split("```") if "multiplications a step" in block)
    runs = [str(ROOT / "scenarios" / f"{name}.yaml") for name in ("warm_up_and_stop", "day_of_work")]
    main(["export", str(ROOT / "machines" / "gantry_spindle.yaml"), *runs, "--as", "c", "-o", str(tmp_path)])
    assert shown.strip() in capsys.readouterr().out


# -- how many states ------------------------------------------------------------------------------------------------
def test_it_is_said_where_no_state_can_be_left_out() -> None:
    """Half the noise of the finest displacement channel decides; where all states lose more, how many are as good."""
    grows = {"kind": "stretching", "length": "1 m", "expansion": "1e-5 1/K", "direction": 1}
    two = machine(
        {"a": {"heat_capacity": "5 kJ/K"}, "b": {"heat_capacity": "80 kJ/K"}, "room": {"temperature": "20 degC"}},
        links={"joint": {"kind": "conduction", "between": ["a", "b"], "conductance": "5 W/K"},
               "skin": {"kind": "convection", "between": ["b", "room"], "conductance": "4 W/K"}},
        sources={"motor": {"kind": "heat_source", "into": {"a": 1}, "power": "90 W", "with": "running"}},
        tcp={"z": {"a grows": grows | {"of": "a"}, "b grows": grows | {"of": "b"}}},
    )  # fmt: skip
    steps = {"speed": [{"for": "1 h", "at": "500 rpm"}, {"for": "1 h", "at": "0 rpm"}, {"at": "500 rpm"}]}
    made = make_correction(two, [Scenario.of("steps", "3 h", steps)])
    assert made.filter.own == made.full == 2 and made.by_states[1] > 0.5e-6 > made.by_states[2]
    (told,) = [note for note in made.notes if "state" in note]
    lost = f"one fewer would lose {1e6 * made.by_states[1]:.3g} µm, more than"
    assert told.startswith(f"No state can be left out: {lost}")
    assert not any("state" in note for note in gantry().notes)
