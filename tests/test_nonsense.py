"""Numbers that no machine has: refused with their place, or told with the entry that brought them, never taken."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build import machine, schedule

import network
from network import Failed, Machine, Recording, Refused, Scenario, simulate
from network.cli import main
from network.recordings.inputs import constant, hold
from network.recordings.recording import Column

NODES = {"block": {"heat_capacity": "1 kJ/K"}, "room": {"temperature": "ambient"}}
SKIN = {"skin": {"kind": "convection", "between": ["block", "room"], "conductance": "1 W/K"}}
HEATER = {"kind": "heat_source", "into": {"block": 1}, "power": "10 W", "with": "level", "at": "1"}
PROBE = {"T": {"measures": "block", "noise": "0.1 K"}}
TIMES = np.arange(0.0, 3601.0, 10.0)


def block(power: str = "10 W", **sections: Any) -> Machine:
    given = {"links": SKIN, "sources": {"heater": HEATER | {"power": power}}, "sensors": PROBE}
    return machine(NODES, **(given | sections))


def recorded(**readings: np.ndarray | float) -> Recording:
    columns = {n: Column(n, "1" if n == "level" else "degC", np.full(len(TIMES), v)) for n, v in readings.items()}
    return Recording("r", "r.csv", TIMES, columns)


# -- what drives ----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "text",
    [
        "78914 degC",
        "-201 degC",
        "900 degF",
        "[{for: 10 min, at: 20 degC}, {at: 500 degC}]",
        "{ramp: {from: 20 degC, to: 500 degC, for: 30 min}}",
        "{sine: {mean: 20 degC, amplitude: 500 K, period: 1 h}}",
    ],
)
def test_a_schedule_is_refused_with_the_line_of_a_temperature_that_nothing_has(text: str, tmp_path: Path) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(f"scenario: s\nduration: 1 h\ninputs:\n  level: 1\n  ambient: {text}\n")
    with pytest.raises(Refused, match=r"s\.yaml:5: inputs\.ambient: reaches .*give temperatures from -200 to 400 degC"):
        Scenario.load(file)


def test_kelvins_are_looked_at_where_they_are_known_to_be_a_temperature() -> None:
    """K may be a difference, of which the machine alone knows."""
    hot = Scenario.of("s", "1 h", {"level": "1", "ambient": "2000 K"})
    with pytest.raises(Refused, match="the input `ambient`: reaches 1727 degC"):
        simulate(block(), hot)
    assert simulate(block(), Scenario.of("s", "1 h", {"level": "1", "ambient": "293 K"})).T_end[0] > 20


def test_a_recording_that_cannot_be_true_is_refused_by_a_simulation_too() -> None:
    with pytest.raises(Refused, match=r"ambient reads 2200 degC, which no part of a machine tool has"):
        simulate(block(), recorded(ambient=2200.0, level=1.0, T=20.0))
    with pytest.raises(Refused, match=r"T reads 2200 degC, which no part of a machine tool has"):
        simulate(block(), recorded(ambient=20.0, level=1.0, T=2200.0))


def test_a_loose_contact_that_drives_a_run_is_told() -> None:
    spiked = np.where(TIMES == 1800, 2200.0, 20.0)
    run = simulate(block(), recorded(ambient=spiked, level=1))
    assert any("ambient reads up to 2200 degC" in warning for warning in run.warnings)
    assert not simulate(block(), recorded(ambient=20.0, level=1.0)).warnings


# -- what comes out -------------------------------------------------------------------------------------------------
def runs(power: str, level: np.ndarray, **sections: Any) -> Any:
    driver = schedule(TIMES, constant("ambient", "degC", 20.0), hold("level", "1", TIMES, level))
    return simulate(block(power, **sections), driver)


def test_a_part_that_was_too_hot_in_between_is_told() -> None:
    """4 kW for 10 min are some 1800 K; after that it cools by e^(−50/16.7)."""
    run = runs("4 kW", np.where(TIMES < 600, 1.0, 0.0))
    assert run.parts["block"].max() > 1400 > 400 > run.T_end[0]
    assert any(w.startswith("block reaches 1") and "check its heat sources" in w for w in run.warnings)
    assert not runs("10 W", np.ones(len(TIMES))).warnings


@pytest.mark.parametrize("level", [np.ones(len(TIMES)), np.where(TIMES < 600, 1.0, 0.0)], ids=["end", "between"])
def test_a_wrong_number_is_told_with_its_entry_and_not_as_something_that_grows(level: np.ndarray) -> None:
    fast = {"skin": SKIN["skin"] | {"conductance": "5 W/K"}}
    with pytest.raises(Failed) as caught:
        runs("90 kW", level, links=fast)
    told = str(caught.value)
    assert "block reaches " in told
    assert "sources.heater (test) brings most of the heat; check its numbers, the input level, the heat" in told
    assert "grows" not in told


def test_the_line_of_the_entry_is_told(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(
        "machine: m\nreference: 20 degC\nnodes:\n  a: {heat_capacity: 1 J/K}\n  b: {heat_capacity: 2 kJ/K}\n"
        "links:\n  l: {kind: conduction, between: [a, b], conductance: 1 W/K}\n"
        "sources:\n  small: {kind: heat_source, into: {b: 1}, power: 1 W}\n"
        "  large: {kind: heat_source, into: {a: 1}, power: 99 kW}\n"
    )
    with pytest.raises(Failed, match=r"a reaches .*sources\.large \(.*m\.yaml:10\) brings most of the heat"):
        simulate(Machine.load(file), Scenario.of("s", "1 h"))


def test_what_grows_with_its_temperature_is_told_so() -> None:
    """3.5 W/K more loss for each kelvin, and 1 W/K that carries it away."""
    copper = {"kind": "copper_temperature", "into": {"block": 1}, "power": "900 W", "slope": "0.0039 1/K"}
    driver = schedule(TIMES, constant("ambient", "degC", 20.0), constant("speed", "rpm", 800.0))
    with pytest.raises(Failed, match=r"sources\.motor .* most of the heat, which grows with its temperature"):
        simulate(block(sources={"motor": copper}), replace(driver, t=np.arange(0.0, 1e4, 100.0)))


def test_heat_that_grows_with_its_temperature_grows_by_every_method() -> None:
    """C dT/dt = P (1 + a (T − 20)) − G (T − 20): x = T − 20 goes as P/(a P − G) (e^((a P − G) t/C) − 1)."""
    copper = {"kind": "copper_temperature", "into": {"block": 1}, "power": "300 W", "slope": "0.005 1/K"}
    grows = block(sources={"motor": copper})
    driver = schedule(TIMES, constant("ambient", "degC", 20.0), constant("speed", "rpm", 800.0))
    expected = 20 + 300 / 0.5 * np.expm1(0.5 * TIMES / 1000)
    for method in ("modal", "expm", "solve_ivp:LSODA"):
        run = simulate(grows, driver, method=method)
        assert run.parts["block"] == pytest.approx(expected, rel=1e-6), method
        assert abs(run.energy.closure) < 1e-6


# -- what measures --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("noise", ["1e-300 K", "1e-7 K", "141 K", "1e30 K"])
def test_noise_that_no_thermometer_has_is_refused(noise: str) -> None:
    with pytest.raises(Refused, match=r"is no noise that a temperature is measured with; .* from 1e-06 to 140 K"):
        block(sensors={"T": {"measures": "block", "noise": noise}})


def test_a_thermometer_on_a_held_node_is_told() -> None:
    on_air = block(sensors={"T": {"measures": "room", "noise": "0.1 K"}})
    assert ["measures room, whose temperature is held" in str(w) for w in on_air.warnings] == [True]
    assert block().warnings == ()


# -- names and files ------------------------------------------------------------------------------------------------
def left(*words: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(words)
    return int(end.value.code or 0)


@pytest.mark.parametrize(
    "words",
    [
        ("simulate", "m.yaml", "s.yaml", "-o", ""), ("sweep", "m.yaml", "s.yaml", "-o", ""), ("demo", "-o", ""),
        ("compare", "m.yaml", "r.csv", "--json", ""), ("calibrate", "m.yaml", "r.csv", "-o", ""),
        ("diagnose", "m.yaml", "r.csv", "-o", ""), ("draw", "m.yaml", "-o", ""), ("prove", "-o", ""), ("check", ""),
    ],
)  # fmt: skip
def test_an_empty_name_is_not_the_working_folder(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert left(*words) == 2 and not [*tmp_path.iterdir()]
    assert "is empty; give the name of a file or a folder" in capsys.readouterr().err


SECRETS = ("xyzzy:x:0:0:xyzzy:/xyzzy:/bin/bash\ndaemon:x:1:1:daemon:/usr/sbin:/usr/sbin/nologin\n", "secret xyzzy\n",
           "the password is, xyzzy\nand so on, yes\n", "[xyzzy]\nkey = words\n")  # fmt: skip


@pytest.mark.parametrize("held", SECRETS)
@pytest.mark.parametrize("how", ['columns: {a: "T [degC]"}\ninterval: 1 s', 'columns: {a: "time [s]"}'])
def test_a_mapping_tells_nothing_of_a_file_that_is_no_table(held: str, how: str, tmp_path: Path) -> None:
    (tmp_path / "other").write_text(held)
    mapping = tmp_path / "m.yaml"
    mapping.write_text(f"recording: r\nfile: other\n{how}\n")
    for path in (mapping, tmp_path / "other"):
        with pytest.raises(Refused, match=r"is no table|has a header and no values") as caught:
            Recording.load(path)
        assert "xyzzy" not in str(caught.value)


def test_the_hint_for_a_heading_without_a_unit_is_one_that_would_be_read(tmp_path: Path) -> None:
    file = tmp_path / "r.csv"
    hints = {"Time (s)": "Time [s]", "spindle_speed": "spindle_speed [rpm]", "T_bed": "T_bed [degC]"}
    for heading, hint in hints.items():
        file.write_text(f"time [s],{heading}\n0,1\n1,2\n")
        with pytest.raises(Refused) as caught:
            Recording.load(file)
        assert f"as in `{hint}`" in str(caught.value)


def test_what_numpy_warns_of_does_not_reach_the_user(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(
        "machine: m\nreference: 20 degC\nnodes: {a: {heat_capacity: 1 J/K}, b: {temperature: 20 degC}}\n"
        "links: {l: {kind: conduction, between: [a, b], conductance: 1 W/K}}\n"
        "sources: {f: {kind: bearing_friction, into: {a: 1}, torque: 1 N m}}\n"
    )
    (tmp_path / "s.yaml").write_text("scenario: s\nduration: 1 h\ninputs: {speed: 1e307 rpm}\n")
    command = [sys.executable, "-m", "network.cli", "simulate", "m.yaml", "s.yaml", "--no-plots"]
    environment = {**os.environ, "PYTHONPATH": str(Path(network.__file__).parents[1])}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stderr.startswith("lptn: a reaches ") and done.stderr.count("\n") == 1
