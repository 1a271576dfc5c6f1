"""The command as a user meets it: what it prints, what it leaves, how it ends."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from network import Machine, Recording, compare
from network.cli import main

ROOT = Path(__file__).parents[1]
BLOCKS, STEPS = str(ROOT / "machines" / "two_blocks.yaml"), str(ROOT / "scenarios" / "heater_steps.yaml")
GANTRY, WARM_UP = str(ROOT / "machines" / "gantry_spindle.yaml"), str(ROOT / "scenarios" / "warm_up_and_stop.yaml")
RECORDED = str(ROOT / "scenarios" / "flagship_6000rpm.csv")


def run(*words: str) -> int:
    """The exit status of `lptn words…`."""
    with pytest.raises(SystemExit) as end:
        main(words)
        raise SystemExit(0)
    return int(end.value.code or 0)


def test_simulate_leaves_what_the_contract_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("simulate", GANTRY, WARM_UP, "-o", str(tmp_path), "--no-plots") == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["parts.csv", "results.csv", "summary.json"]
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert {"method", "why", "solve_seconds", "error_estimate", "energy", "tcp", "warnings"} <= summary.keys()
    assert summary["error_estimate"]["unit"] == "K" and summary["error_estimate"]["value"] < 1e-9
    assert abs(summary["energy"]["closure"]) < 1e-9
    assert set(summary["tcp"]["z"]) == {"max", "min", "final", "unit"} and summary["tcp"]["z"]["unit"] == "um"
    energy = summary["energy"]
    assert energy["in"] - energy["out"] == pytest.approx(energy["stored"], rel=1e-9)
    header = (tmp_path / "results.csv").read_text().splitlines()[0].split(",")
    assert header[0] == "time [s]"
    assert {"speed [rpm]", "ambient [degC]", "T_housing [degC]", "dz [um]", "tcp.z [um]"} <= set(header)
    assert "Written:" in capsys.readouterr().out


def test_parts_hold_heat_and_contributions(tmp_path: Path) -> None:
    """The contributions of an axis add up to it; heat is what the summary says was absorbed."""
    run("simulate", GANTRY, WARM_UP, "-o", str(tmp_path), "--no-plots")
    parts, results = (Recording.load(tmp_path / name).columns for name in ("parts.csv", "results.csv"))
    z = sum(column.values for name, column in parts.items() if name.startswith("tcp.z."))
    np.testing.assert_allclose(z, results["tcp.z"].values, atol=1e-11)
    absorbed = json.loads((tmp_path / "summary.json").read_text())["energy"]["absorbed"]
    assert parts["heat.housing"].values[-1] == pytest.approx(absorbed["housing"], rel=1e-5)
    assert parts["T.shaft"].values.max() > 30


def test_a_simulation_reads_back_as_a_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("simulate", GANTRY, WARM_UP, "-o", str(tmp_path), "--no-plots")
    assert run("compare", GANTRY, str(tmp_path / "results.csv"), "--json", "-") == 0
    out = capsys.readouterr().out
    compared = json.loads(out[out.index("{") :])
    assert compared["rmse_in_noise"] < 1e-3
    channel = compared["recordings"][0]["channels"]["dz"]
    assert set(channel) == {"rmse", "unit", "rmse_in_noise", "max", "n", "tests"} and channel["n"] == 1441


def test_compare_pools_residuals_in_noise(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A recording that is 0.1 K off in one of two channels of 0.05 K noise: √(4/2) in all."""
    machine = tmp_path / "m.yaml"
    machine.write_text(
        "machine: m\nreference: 20 degC\nnodes:\n  a: {heat_capacity: 1 kJ/K}\n  b: {heat_capacity: 1 kJ/K}\n"
        "links:\n  l: {kind: conduction, between: [a, b], conductance: 1 W/K}\n"
        "sensors:\n  A: {measures: a, noise: 0.05 K}\n  B: {measures: b, noise: 0.05 K}\n"
    )
    recording = tmp_path / "r.csv"
    recording.write_text("time [s],A [degC],B [degC]\n0,20.1,20\n10,20.1,20\n20,20.1,\n")
    target = tmp_path / "out" / "r.json"
    assert run("compare", str(machine), str(recording), "--start", "20 degC", "--json", str(target)) == 0
    compared = json.loads(target.read_text())
    assert compared["rmse_in_noise"] == pytest.approx(np.sqrt(3 * 4 / 5), rel=1e-9)
    still = compared["recordings"][0]["channels"]["B"]
    assert still["n"] == 2 and still["unit"] == "K" and still["max"] < 1e-12


def test_noise_is_added_only_when_asked_and_repeats(tmp_path: Path) -> None:
    def dz(*words: str) -> np.ndarray:
        assert run("simulate", GANTRY, WARM_UP, "-o", str(tmp_path), "--no-plots", *words) == 0
        return Recording.load(tmp_path / "results.csv").columns["dz"].values

    plain = dz()
    one, same, other = (dz("--noise", "--seed", seed) for seed in ("1", "1", "2"))
    np.testing.assert_array_equal(one, same)
    assert np.std(one - plain) == pytest.approx(0.25e-6, rel=0.1)
    assert not np.array_equal(one, other)


def test_all_errors_are_told_on_stderr_and_nothing_is_left(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text(Path(BLOCKS).read_text().replace("W/K", "W").replace("lumps", "lumbs"))
    assert run("simulate", str(bad), STEPS, "-o", str(tmp_path / "out")) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert all(line.startswith(f"{bad}:") and "; " in line for line in told.err.splitlines())
    assert len(told.err.splitlines()) >= 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["simulate", BLOCKS, STEPS, "--seed", "x"], "'--seed': 'x' is not one; give a whole number from 0"),
        (["sweep", BLOCKS, STEPS, "--jobs", "0"], "'--jobs': '0' is not one; give a whole number from 1"),
        (
            ["check", "gone/two_blocks.yaml"],
            f"a machine file (one of that name comes with lptn: {BLOCKS})",
        ),
        (["compare", BLOCKS, "flagship_6000rpm.csv"], "(one of that name comes with lptn: "),
        (["check", "nope.yaml"], "nope.yaml: there is no such file; give the path of a machine file"),
        (
            ["simulate", BLOCKS, BLOCKS],
            "is a machine file; give a scenario or a recording here; the machine stands first",
        ),
        (["simulate", STEPS, BLOCKS], f"{STEPS}:1: is a scenario; a machine file is needed here"),
        (["check", RECORDED], f"{RECORDED}:1: is a recording; a machine file is needed here"),
        (["check", GANTRY, "--set", "links.flange=60 W/K"], "did you mean links.flange.conductance=60 W/K?"),
        (["check", GANTRY, "--set", "sources.motor loss=60 W"], "name one of sources.motor loss.copper, sources.motor"),
        (["compare", BLOCKS, STEPS], "is a scenario; give a recording"),
        (["simulate", BLOCKS, STEPS, "--method", "modall"], "there is no method 'modall'; did you mean 'modal'?"),
        (["simulate", BLOCKS, STEPS, "--level", "fine"], "there is no level 'fine'"),
        (["simulate", BLOCKS, STEPS, "--start", "{lef: 22 degC}"], "start names 'lef', which is no node"),
        (["simulate", GANTRY, STEPS], "the machine needs the input `speed`, which is not there"),
        (["draw", BLOCKS, "-o", "picture.doc"], "picture.doc: is no picture that can be drawn"),
        (["catalogue", "radiatoin"], "did you mean 'radiation'?"),
    ],
)
def test_refusals_end_with_two(words: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*words) == 2
    captured = capsys.readouterr()
    assert told in captured.err and captured.out == ""


def test_arguments_in_the_wrong_order_are_told_in_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("simulate", STEPS, BLOCKS) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_misspelt_section_is_told_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, above = tmp_path / "m.yaml", tmp_path / "above.yaml"
    file.write_text(Path(BLOCKS).read_text().replace("\nnodes:", "\nnodez:").replace("\nlinks:", "\nlinkss:"))
    above.write_text("extends: m.yaml\nsensor:\n  T_new: {measures: nowhere, noise: 0.05 K}\n")
    line = 1 + file.read_text().splitlines().index("nodez:")
    assert run("check", str(file)) == 2
    told = capsys.readouterr().err.splitlines()
    assert f"{file}:{line}: unknown section 'nodez'; did you mean 'nodes'?" in told and len(told) == 2
    assert run("check", str(above)) == 2
    told = capsys.readouterr().err.splitlines()
    assert "sensors.T_new: there is no node 'nowhere'" in told[1] and len(told) == 4


def test_an_unknown_number_is_refused_with_the_remedy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    unknown = "links.flange.conductance=unknown 10..90 W/K"
    assert run("simulate", GANTRY, WARM_UP, "--set", unknown, "-o", str(tmp_path / "o")) == 2
    assert "links.flange: conductance is unknown; calibrate it on a recording, or give --set" in capsys.readouterr().err


def test_check_tells_all_files_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong, worse = tmp_path / "a.csv", tmp_path / "b.csv"
    wrong.write_text("time [s];speed [rpm]\n0;0\n1;0\n")
    worse.write_text("speed [rpm],ambient [degC]\n0,20\n1,20\n")
    assert run("check", GANTRY, str(wrong), str(worse)) == 2
    err = capsys.readouterr().err
    assert "the machine needs the input `ambient`, which the recording lacks" in err and "has no time column" in err


def test_check_json_names_what_is_in_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("check", GANTRY, "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["inputs"] == {"ambient": "degC", "speed": "rpm"}
    assert "links.flange.conductance" in summary["uncertain"]


def test_set_lumps_and_level_change_the_machine(tmp_path: Path) -> None:
    assert Machine.load(GANTRY, lumps=["3"]).nodes["beam"].lumps == 3
    assert run("simulate", GANTRY, WARM_UP, "--level", "fine", "--set", "links.flange.conductance=60 W/K",
               "--lumps", "beam=5", "--no-plots", "-o", str(tmp_path)) == 0  # fmt: skip


@pytest.mark.parametrize("words", [["--version"], ["--help"], ["simulate", "--help"]])
def test_help_and_version_answer(words: list[str]) -> None:
    done = subprocess.run([sys.executable, "-m", "network.cli", *words], capture_output=True, text=True, check=True)
    assert done.stdout and not done.stderr


def test_a_file_in_the_way_of_the_results_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "out").write_text("mine")
    assert run("simulate", BLOCKS, STEPS, "-o", str(tmp_path / "out"), "--no-plots") == 2
    assert "cannot be a folder" in capsys.readouterr().err
    assert (tmp_path / "out").read_text() == "mine"


@pytest.mark.skipif(os.name != "posix", reason="pipes")
def test_a_closed_pipe_is_no_failure(tmp_path: Path) -> None:
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "network.cli", "demo", "-o", str(tmp_path)]
    done = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert done.returncode == 0 and not done.stderr


@pytest.mark.parametrize("command", ["simulate", "compare", "sweep", "calibrate", "diagnose", "demo", "prove", "draw"])
def test_a_folder_that_cannot_be_is_refused_before_anything_is_read(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("afile").write_text("mine")
    words = [] if command in ("demo", "prove") else ["no.yaml"] if command == "draw" else ["no.yaml", "no.csv"]
    assert run(command, *words, "-o", "afile/x/y.png" if command == "draw" else "afile/x") == 2
    assert capsys.readouterr().err == "afile/x: cannot be a folder, afile is a file; give another -o\n"
    assert not words or run(command, *words, "-o", "new/p.png") == 2
    assert Path("afile").read_text() == "mine" and not Path("new").exists()


def test_only_plain_files_are_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("simulate", BLOCKS, WARM_UP, "-o", str(tmp_path), "--no-plots")
    target, link = tmp_path / "real.json", tmp_path / "link.json"
    link.symlink_to(target)
    assert run("compare", BLOCKS, str(tmp_path / "results.csv"), "--json", str(link)) == 0
    assert link.is_symlink() and "rmse_in_noise" in target.read_text()
    assert run("compare", BLOCKS, str(tmp_path / "results.csv"), "--json", str(tmp_path)) == 2
    assert "is not a plain file" in capsys.readouterr().err


def test_check_looks_at_every_level(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(Path(BLOCKS).read_text() + "levels:\n  c: {merge: {u: [hot, nope]}}\n  d: {lumps: {room: 3}}\n")
    assert run("check", str(file)) == 2
    err = capsys.readouterr().err
    assert "merge.u: 'nope' is no part" in err and "'room' is not a bar" in err


def test_one_recording_may_be_given_alone(tmp_path: Path) -> None:
    run("simulate", BLOCKS, WARM_UP, "-o", str(tmp_path), "--no-plots")
    recording = Recording.load(tmp_path / "results.csv")
    assert compare(Machine.load(BLOCKS), recording).rmse_in_noise < 1e-3


def test_the_relay_method_needs_a_relay(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("simulate", BLOCKS, WARM_UP, "--method", "switched") == 2
    assert "switched needs a relay, and this machine has none" in capsys.readouterr().err


def test_an_input_named_like_a_node_is_doubted(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(Path(BLOCKS).read_text().replace("{temperature: ambient}", "{temperature: cold}"))
    assert any("a node has that name too" in str(warning) for warning in Machine.load(file).warnings)
