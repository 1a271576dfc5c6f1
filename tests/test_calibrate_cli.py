"""`lptn calibrate` as a user meets it: its files, its refusals and warnings, planning ahead of a recording."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measured import BLOCKS, blocks, changed, recorded, steps

from network import Machine, Recording, Refused, calibrate, compare
from network.analysis.calibration import unit_mistakes
from network.analysis.calibration.estimated_constants import compare_estimating
from network.analysis.calibration.experiment_plan import foresee
from network.analysis.calibration.linearised import Linearised
from network.cli import main
from network.platform.yaml.document import dump
from network.recordings.csv_table import write_csv

TRUE = {"joint": "2.4 W/K", "hot skin": "0.6 W/K"}
SCENARIO = """scenario: steps
duration: 80 min
output: 10 s
inputs: {ambient: 22 degC, level: [{for: 40 min, at: 1}, {for: 40 min, at: 0}]}
"""
Values = np.ndarray[Any, Any]


def run(*words: str) -> int:
    """The exit status of `lptn words…`."""
    with pytest.raises(SystemExit) as end:
        main(words)
        raise SystemExit(0)
    return int(end.value.code or 0)


def truth() -> Machine:
    links = {name: {**BLOCKS["links"][name], "conductance": value} for name, value in TRUE.items()}  # type: ignore[index]
    return blocks(links=links)


def readings(seed: int = 0, name: str = "readings", minutes: int = 80) -> Recording:
    return recorded(truth(), steps(f"{minutes} min", output="10 s"), seed, name)


def save(recording: Recording, folder: Path) -> str:
    path = folder / f"{recording.name}.csv"
    write_csv(path, recording.t, {n: (c.unit, c.values) for n, c in recording.columns.items()})
    return str(path)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine, two recordings, a scenario."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "blocks.yaml").write_text(dump(BLOCKS))
    (tmp_path / "steps.yaml").write_text(SCENARIO)
    save(readings(), tmp_path)
    save(readings(4, "later"), tmp_path)
    return tmp_path


# -- files ----------------------------------------------------------------------------------------------------------
def test_the_result_is_a_machine_that_reproduces_the_residual(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("calibrate", "blocks.yaml", "readings.csv", "--holdout", "later.csv", "-o", "found", "--no-plots") == 0
    assert [p.name for p in Path("found").glob("*.yaml")] == ["machine.calibrated.yaml"]
    assert "Written: " in capsys.readouterr().out
    told = json.loads(Path("found/calibration.json").read_text())
    machine = Machine.load("found/machine.calibrated.yaml")
    for side, file in (("train", "readings.csv"), ("holdout", "later.csv")):
        again = compare(machine, Recording.load(file)).rmse_in_noise
        assert told["fit"][side]["after_as_stated"]["rmse_in_noise"] == pytest.approx(again, rel=1e-9)
        assert told["fit"][side]["before"]["rmse_in_noise"] > told["fit"][side]["after"]["rmse_in_noise"]
    estimated = compare_estimating(machine, [Recording.load("readings.csv")]).rmse_in_noise
    assert told["fit"]["train"]["after"]["rmse_in_noise"] == pytest.approx(estimated, rel=1e-6)
    assert set(told["fit"]["train"]["after"]["channels"]) == {"T_hot", "T_cold", "dz"}
    first = told["parameters"][0]
    assert first["path"] == "links.joint.conductance" and first["unit"] == "W/K"
    assert first["value"] == pytest.approx(2.4, rel=0.02) and first["std"] == pytest.approx(0.012, rel=0.6)
    assert machine.uncertain["links.joint.conductance"].spread == pytest.approx(first["std"] / first["value"], rel=0.01)
    assert "extends: ../blocks.yaml" in Path("found/machine.calibrated.yaml").read_text()


def test_pictures_and_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("calibrate", "blocks.yaml", "readings.csv", "--holdout", "later.csv", "-o", "found", "--json") == 0
    assert json.loads(capsys.readouterr().out)["seed"] == 0
    assert {p.name for p in Path("found").glob("*.png")} == {
        "fit-readings.png", "residual-readings.png", "holdout-fit-later.png", "holdout-residual-later.png",
        "shifts.png", "band-z.png",
    }  # fmt: skip
    assert not list(Path("found").glob(".*"))


def test_what_options_changed_is_in_the_result(folder: Path) -> None:
    (folder / "bar.yaml").write_text(
        "extends: blocks.yaml\nnodes:\n  hot: {material: aluminium, length: 100 mm, area: 16 cm^2}\n"
        "levels: {fine: {lumps: {hot: 3}}}\n"
    )
    option = ("--level", "fine", "--set", "links.cold skin.conductance=0.5 W/K", "--no-plots")
    assert run("calibrate", "bar.yaml", "readings.csv", "-o", "found", *option) == 0
    machine = Machine.load("found/machine.calibrated.yaml")
    assert machine.nodes["hot"].lumps == 3
    assert list(machine.uncertain) == ["links.joint.conductance", "links.hot skin.conductance"]
    told = json.loads(Path("found/calibration.json").read_text())["fit"]["train"]["after_as_stated"]["rmse_in_noise"]
    assert compare(machine, Recording.load("readings.csv")).rmse_in_noise == pytest.approx(told, rel=1e-9)


def test_a_calibrated_machine_is_not_written_over_itself(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("calibrate", "blocks.yaml", "readings.csv", "-o", "found", "--no-plots") == 0
    before = Path("found/machine.calibrated.yaml").read_text()
    assert run("calibrate", "found/machine.calibrated.yaml", "later.csv", "-o", "found", "--no-plots") == 2
    assert "that is a file the machine is made of; give another -o" in capsys.readouterr().err
    assert Path("found/machine.calibrated.yaml").read_text() == before
    assert run("calibrate", "found/machine.calibrated.yaml", "later.csv", "-o", "again", "--no-plots") == 0
    assert Machine.load("again/machine.calibrated.yaml").links["joint"].conductance == pytest.approx(2.4, rel=0.02)  # type: ignore[union-attr]


def test_pictures_of_the_result_before_go_with_it(folder: Path) -> None:
    assert run("calibrate", "blocks.yaml", "readings.csv", "--holdout", "later.csv", "-o", "found") == 0
    assert len([*Path("found").glob("*.png")]) > 4
    assert run("calibrate", "blocks.yaml", "readings.csv", "-o", "found", "--no-plots") == 0
    assert not [*Path("found").glob("*.png")]


def test_nothing_half_written_when_stopped(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import network.report.figures.canvas as canvas

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(canvas, "save", stop)
    assert run("calibrate", "blocks.yaml", "readings.csv", "-o", "found") == 130
    assert not Path("found").exists()


def test_numbers_inside_effects_and_temperatures_are_written_back(folder: Path) -> None:
    sensors = {
        "T_hot": {"measures": "hot", "noise": "0.05 K", "effects": [{"kind": "sensor_lag", "lag": "20 s ± 50 %"}]}
    }
    links = {"leak": {"kind": "convection", "between": ["hot", "cellar"], "conductance": "0.3 W/K"}}
    machine = blocks(sensors=sensors, nodes={"cellar": {"temperature": "18 degC ± 2 K"}}, links=links)
    real = {"T_hot": {"measures": "hot", "noise": "0.05 K", "effects": [{"kind": "sensor_lag", "lag": "45 s"}]}}
    true = machine.patched({"sensors": real, "nodes": {"cellar": {"temperature": "19.5 degC"}}})
    found = calibrate(machine, recorded(true, steps()))
    again = Machine.read(found.machine.tree, "again")
    assert again.sensors["T_hot"].effects[0].lag == pytest.approx(45, rel=0.1)  # type: ignore[attr-defined]
    assert again.nodes["cellar"].temperature == pytest.approx(19.5, abs=0.5)
    assert again.uncertain["nodes.cellar.temperature"].prior == "normal"


# -- bad input ------------------------------------------------------------------------------------------------------
def refusal(machine: Machine, *recordings: Recording, holdout: tuple[Recording, ...] = ()) -> str:
    with pytest.raises(Refused) as refused:
        calibrate(machine, recordings, holdout)
    return str(refused.value)


def test_all_numbers_fixed() -> None:
    links = {name: {**e, "conductance": "1 W/K"} for name, e in BLOCKS["links"].items()}  # type: ignore[attr-defined]
    told = refusal(blocks(links=links), readings())
    assert "every number of the machine is fixed" in told and "write ± behind" in told


def test_a_recording_shorter_than_the_fastest_time_constant() -> None:
    told = refusal(blocks(), readings(minutes=1))
    assert "readings.csv: lasts 60 s, shorter than the machine's fastest time constant of 6" in told


def test_a_recording_in_which_nothing_happens() -> None:
    still = recorded(truth(), steps(inputs={"ambient": "22 degC", "level": "0"}))
    assert "nothing moves beyond its noise" in refusal(blocks(), still)


def test_a_recording_held_out_and_calibrated_on() -> None:
    assert "is held out and calibrated on (the same file)" in refusal(blocks(), readings(), holdout=(readings(),))
    told = refusal(blocks(), readings(), holdout=(readings(name="copy"),))
    assert "copy.csv: is held out and calibrated on (the same readings as readings.csv)" in told
    assert "is given twice" in refusal(blocks(), readings(), readings())


def test_a_number_in_a_wrong_unit_is_named() -> None:
    """600 W/K instead of 600 mW/K; 12 mW instead of 12 W."""
    links = {"hot skin": {**BLOCKS["links"]["hot skin"], "conductance": "600 W/K ± 20 %"}}  # type: ignore[index]
    told = refusal(blocks(links=links), readings())
    assert "links.hot skin.conductance is 600 W/K, and with 0.6 W/K" in told and "check its unit" in told
    sources = {"heater": {**BLOCKS["sources"]["heater"], "power": "0.012 W ± 0.001 W"}}  # type: ignore[index]
    assert "sources.heater.power is 0.012 W, and with 12 W" in refusal(blocks(sources=sources), readings())


def test_a_number_in_a_wrong_unit_is_named_by_several_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """On all of them only those are tried that explain enough on the shortest."""
    asked, cost = list[int](), unit_mistakes.residual_cost

    def count(at: Linearised, theta: Values) -> float:
        asked.append(len(at.problem.data))
        return cost(at, theta)

    monkeypatch.setattr(unit_mistakes, "residual_cost", count)
    links = {"hot skin": {**BLOCKS["links"]["hot skin"], "conductance": "600 W/K ± 20 %"}}  # type: ignore[index]
    told = refusal(blocks(links=links), readings(), readings(4, "later"))
    assert "links.hot skin.conductance is 600 W/K, and with 0.6 W/K" in told
    assert asked.count(1) > 10 and 0 < asked.count(2) < 0.2 * asked.count(1)


def test_channels_in_a_wrong_unit_are_named() -> None:
    def in_millimetres(t: Values, values: Values) -> Values:
        return values * 1e3

    def in_kelvin(t: Values, values: Values) -> Values:
        return values + 273.15

    told = refusal(blocks(), changed(readings(), dz=in_millimetres))
    assert "dz reads 1e3 times what is simulated, in the same shape; check the unit in its header" in told
    told = calibrate(blocks(), changed(readings(), T_cold=in_kelvin)).warnings[-1]
    assert "T_cold reads as if it were told in K, above the other temperatures by 2" in told and "left out" in told


def test_a_flat_channel_is_left_out_with_a_warning() -> None:
    def flat(t: Values, values: Values) -> Values:
        return np.full(len(values), 22.0)

    found = calibrate(blocks(), changed(readings(), T_cold=flat))
    assert found.warnings[0] == "readings.csv: T_cold reads the same at all times; it is left out"
    assert np.exp(found.theta[0]) == pytest.approx(2.4, rel=0.05)
    assert "every channel reads the same" in refusal(blocks(), changed(readings(), T_hot=flat, T_cold=flat, dz=flat))


def test_a_channel_that_hangs_is_left_out_from_there() -> None:
    def hanging(t: Values, values: Values) -> Values:
        values[200:] = values[200]
        return values

    found = calibrate(blocks(), changed(readings(), T_cold=hanging))
    assert "readings.csv: T_cold is stuck from" in found.warnings[0]
    assert np.exp(found.theta[0]) == pytest.approx(2.4, rel=0.03)


def test_more_numbers_than_readings() -> None:
    recording = readings()
    few = changed(recording, **{n: (lambda t, v, k=k: np.where(np.arange(len(v)) % 400 == 60 + k, v, np.nan))
                                for k, n in enumerate(("T_hot", "T_cold", "dz"))})  # fmt: skip
    sources = {"heater": {**BLOCKS["sources"]["heater"], "power": "12 W ± 10 W"}}  # type: ignore[index]
    nodes = {n: {"heat_capacity": "400 J/K ± 20 %"} for n in ("hot", "cold")}
    found = calibrate(blocks(nodes=nodes, sources=sources), few)
    assert any("numbers are to be found from" in warning for warning in found.warnings)
    assert "Nothing in these recordings tells" in "\n".join(found.sentences)


def test_what_is_asked_wrongly(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("calibrate", "blocks.yaml") == 2
    assert "no recording is given" in capsys.readouterr().err
    assert run("calibrate", "blocks.yaml", "readings.csv", "--plan", "steps.yaml") == 2
    assert "leave one of the two away" in capsys.readouterr().err
    assert run("calibrate", "blocks.yaml", "readings.csv", "--holdout", "./readings.csv", "-o", "x") == 2
    assert "is held out and calibrated on" in capsys.readouterr().err
    assert not Path("x").exists()
    Path("lacking.csv").write_text("time [s],level [1],T_hot [degC]\n0,0,22\n60,1,22\n")
    assert run("calibrate", "blocks.yaml", "lacking.csv") == 2
    assert "the machine needs the input `ambient`" in capsys.readouterr().err


# -- ahead of a recording -------------------------------------------------------------------------------------------
def test_the_plan_foretells_the_standard_errors_of_the_recording(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("calibrate", "blocks.yaml", "--plan", "steps.yaml", "--json", "-o", "found") == 0
    told = json.loads(capsys.readouterr().out)
    assert json.loads(Path("found/plan.json").read_text()) == told
    found = calibrate(blocks(), recorded(blocks(), steps(output="10 s")))
    for parameter, std in zip(told["parameters"], found.std, strict=True):
        assert parameter["std"] == pytest.approx(std, rel=0.15) and parameter["verdict"] == "determined"


def test_the_plan_names_the_sensor_that_buys_most() -> None:
    sensors = {"T_cold": None}
    found = foresee(blocks(sensors=sensors, nodes={"hot": {"heat_capacity": "400 J/K ± 20 %"}}), steps())
    assert found.candidates[0].measures == "cold"
    assert "A sensor that would buy most: cold (noise 0.05 K)" in str(found)
    without = foresee(blocks(sensors={"T_cold": None, "T_hot": None, "dz": None}), steps())
    np.testing.assert_allclose(without.share, 1.0)
    assert {c.measures for c in without.candidates} == {"hot", "cold", "tcp.z"}
