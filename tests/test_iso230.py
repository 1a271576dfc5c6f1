"""ISO 230-3: figures of a drift against closed forms, tests on shipped machines and recordings, refusals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from network import Machine, Recording, Refused, Scenario
from network.analysis.acceptance.drift_measures import HOUR, find_range, find_stability, smooth_readings
from network.analysis.acceptance.motion import TITLES
from network.analysis.acceptance.thermal_test import ThermalTest, evaluate_thermal_test
from network.cli import main
from network.recordings.inputs import Start

ROOT = Path(__file__).parents[1]
MACHINES, PROGRAMS = ROOT / "machines", ROOT / "scenarios"
GANTRY = str(MACHINES / "gantry_spindle.yaml")
NEW = str(MACHINES / "new_machine.yaml")


def evaluate_on(machine: str, program: str, tool_length: float | None = None) -> ThermalTest:
    source = Scenario.load(PROGRAMS / f"iso230_{program}.yaml")
    return evaluate_thermal_test(Machine.load(MACHINES / f"{machine}.yaml"), source, tool_length=tool_length)


def status(*words: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(words)
        raise SystemExit(0)
    return int(end.value.code or 0)


@pytest.mark.parametrize("minutes", [30, 60, 90])
def test_an_exponential_is_stable_when_its_closed_form_says(minutes: float) -> None:
    """1 − e^(−t/τ): the change of an hour is e^(−(t − 60 min)/τ) of that of the first one; 15 % of it at
    60 min + τ ln(1/0.15)."""
    t = np.arange(0, 8 * HOUR, 20.0)
    course = 1 - np.exp(-t / (60 * minutes))
    expected = 60 + minutes * np.log(1 / 0.15)
    found = find_stability(t, course, 0.0, float(t[-1]))
    assert found is not None and expected <= found / 60 < expected + 1
    assert find_range(t, course, 0, HOUR) == pytest.approx(1 - np.exp(-60 / minutes))
    tenth = find_stability(t, course, 0.0, float(t[-1]), 0.1)
    assert tenth is not None and 60 + minutes * np.log(10) <= tenth / 60 < 61 + minutes * np.log(10)
    assert find_stability(t, t, 0.0, float(t[-1])) is None
    assert find_stability(t, course, 0.0, 1.9 * HOUR) is None


def test_readings_are_smoothed_so_that_noise_is_no_drift() -> None:
    """A straight drift is kept to its ends, also over gaps; of noise less than half is left."""
    rng = np.random.default_rng(0)
    t = np.arange(0, 4 * HOUR, 10.0)
    noisy = rng.normal(size=len(t))
    noisy[100:200] = np.nan
    smooth_t, smooth = smooth_readings(t, noisy)
    assert np.ptp(smooth) < (np.nanmax(noisy) - np.nanmin(noisy)) / 2 and len(smooth) < len(np.arange(0, 4 * HOUR, 60))
    smooth_t, smooth = smooth_readings(t, np.where(np.isnan(noisy), np.nan, 5 * t))
    np.testing.assert_allclose(smooth, 5 * smooth_t, rtol=1e-9, atol=1e-6)
    assert (smooth_t[0], smooth_t[-1]) == (t[0], t[-1])


@pytest.mark.parametrize(
    ("machine", "program", "test"),
    [
        ("vertical_mill", "etve", "etve"), ("gantry_spindle", "spindle_constant", "spindle_constant"),
        ("belt_lathe", "spindle_spectrum", "spindle_spectrum"), ("ball_screw_axis", "linear_axis", "linear_axis"),
        ("cnc_lathe", "spindle_constant", "spindle_constant"), ("cnc_lathe", "linear_axis", "linear_axis"),
        ("paper_8000", "spindle_constant", "spindle_constant"),
    ],
)  # fmt: skip
def test_programs_run_on_shipped_machines(machine: str, program: str, test: str) -> None:
    """The contract's keys; drift is the range of the simulated axis, first and last 60 min lie within it."""
    result = evaluate_on(machine, program)
    told = result.summary()
    assert told["test"] == test and TITLES[test] in told["title"] and told["from"] == "simulation"
    assert result.run is not None
    for axis, figures in told["axes"].items():
        assert {"drift", "first_60_min", "last_60_min", "stable_after_min", "tilt"} <= figures.keys()
        assert 0 <= figures["last_60_min"]["value"] <= figures["drift"]["value"]
        if test != "linear_axis":
            assert figures["drift"]["value"] == pytest.approx(1e6 * np.ptp(result.run.tcp[axis]))
    assert str(result).startswith(result.machine.name)


def test_a_table_that_turns_is_a_rotary_axis() -> None:
    """What reads another speed than the spindle's; the spindle, which the program does not name, rests."""
    table = "sources.table={kind: bearing_friction, into: {beam: 1}, torque: 40 N m, input: rotary_speed}"
    program = Scenario.load(PROGRAMS / "iso230_rotary_axis.yaml")
    told = evaluate_thermal_test(Machine.load(GANTRY, sets=[table]), program).summary()
    assert told["test"] == "rotary_axis" and told["axes"]["y"]["drift"]["value"] > 0.5
    assert told["motion_min"] == {"begin": 10, "end": 250}


def test_a_moving_axis_is_told_at_both_ends_of_its_travel() -> None:
    """The screw grows from its fixed bearing: what stands further off moves more, in the ratio of the lengths that
    carry heat at most."""
    x = evaluate_on("ball_screw_axis", "linear_axis").axes["x"]
    near, far = x.targets.values()
    assert list(x.targets) == pytest.approx([0.0, 0.6]) and x.drift == far.drift > 2 * near.drift
    assert x.stable_after is not None and x.first > 0.8 * x.drift


def test_an_axis_is_named_as_the_machine_calls_it(capsys: pytest.CaptureFixture[str]) -> None:
    """Each of three axes along the program shipped: its own drifts alone, scaled before it is renamed."""
    told = {}
    for axis in "xz":
        words = ("--input", f"feed=feed_{axis}", "--top", "feed=20 m/min")
        assert status("iso230", NEW, "linear_axis", *words, "--json") == 0
        told[axis] = json.loads(capsys.readouterr().out)
        assert told[axis]["test"] == "linear_axis"
        assert status("iso230", NEW, "linear_axis", *words) == 0
        shown = capsys.readouterr().out
        assert f"feed_{axis} from 10 to 250 min" in shown and "x up to 0.0019" not in shown
    drifts = {axis: test["axes"]["x"]["drift"]["value"] for axis, test in told.items()}
    assert drifts["x"] > 1 > 1e-2 > drifts["z"]


def test_a_longer_tool_is_carried_by_the_rotation() -> None:
    """x − b L: as twice the length makes the range of x − 2 b L, not twice that of x − b L."""
    results = {length: evaluate_on("belt_lathe", "spindle_constant", length).axes["x"] for length in (0.0, 0.15, 0.3)}
    run = evaluate_on("belt_lathe", "spindle_constant").run
    assert run is not None
    for length, drift in results.items():
        assert drift.offset == pytest.approx(np.ptp(run.tcp["x"] - length * run.tcp["b"]))
        assert drift.tilt == pytest.approx(np.ptp(run.tcp["b"]))


def test_where_it_begins_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """A pump that is always on has warmed what it warms: 100 W into a bar that its skins alone cool. Cold is cold."""
    pump = "sources.pump={kind: heat_source, into: {beam: 1}, power: 100 W, with: always}"
    words = "iso230", GANTRY, "spindle_constant", "--set", pump
    assert status(*words) == 0
    told = capsys.readouterr().out
    assert "It begins in equilibrium with the room at rest, what is always on having run for long: parts from " in told
    assert "(beam); `--start '20 degC'` begins cold." in told
    assert status(*words, "--start", "20 degC") == 0
    cold = capsys.readouterr().out
    assert "It begins as stated: all parts at 20 °C.\n" in cold and "begins cold" not in cold
    machine = Machine.load(GANTRY, sets=[pump])
    program = Scenario.load(PROGRAMS / "iso230_spindle_constant.yaml")
    warm, cool = (evaluate_thermal_test(machine, program, start=start) for start in (None, Start(others=20.0)))
    assert warm.run is not None and warm.run.parts["beam"][0] == pytest.approx(warm.run.parts["beam"][10], abs=0.01)
    assert warm.begins == "in equilibrium" and cool.begins == "as stated"
    assert cool.axes["y"].drift > warm.axes["y"].drift  # what the pump does comes on top
    assert json.loads(json.dumps(cool.summary()))["begins"] == "as stated"


def test_a_recording_tells_what_was_measured_and_beside_it_the_machine(tmp_path: Path) -> None:
    """A noisy run of the same machine: measured and simulated agree to a micrometre, four σ of a sample."""
    program = str(PROGRAMS / "iso230_spindle_constant.yaml")
    main(["simulate", GANTRY, program, "-o", str(tmp_path), "--no-plots", "--noise", "--seed", "1"])
    recording = Recording.load(tmp_path / "results.csv")
    result = evaluate_thermal_test(Machine.load(GANTRY), recording)
    told = result.summary()
    assert told["from"] == "recording" and told["test"] == "spindle_constant"
    for axis in ("z", "y"):
        measured, simulated = told["axes"][axis], told["simulated"][axis]
        for key in ("drift", "first_60_min", "last_60_min"):
            assert measured[key]["value"] == pytest.approx(simulated[key]["value"], abs=1.0)


def test_the_share_that_counts_as_stable_is_a_setting_with_its_origin(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A lower share is reached later, by τ ln(15/10) where one time constant is left; the page says whose it is."""
    told = {}
    for words in ([], ["--stable", "10 %"]):
        assert status("iso230", GANTRY, "spindle_constant", *words, "-o", str(tmp_path / "out"), "--json") == 0
        told[len(words)] = json.loads(capsys.readouterr().out)
        page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
        assert ("10 % of the largest" in page and "as asked for" in page) is bool(words)
        assert ("15 % of the largest" in page and "unverified" in page) is not bool(words)
    assert told[0]["stable"]["share"] == 0.15 and "unverified" in told[0]["stable"]["origin"]
    assert told[2]["stable"] == {"share": 0.1, "origin": "as asked for"}
    assert told[2]["axes"]["z"]["stable_after_min"] > told[0]["axes"]["z"]["stable_after_min"] + 10


@pytest.mark.parametrize(("option", "said"), [
    (("--stable", "150 %"), "--stable: '150 %' is no share of a drift; a share above 0 and below 100 %"),
    (("--stable", "5 K"), "--stable: '5 K' has a unit; a share above 0"),
    (("--tool-length", "5 K"), "--tool-length: '5 K' is in K; a unit like mm is needed"),
])  # fmt: skip
def test_an_option_that_cannot_be_is_refused_once(
    option: tuple[str, str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status("iso230", GANTRY, "spindle_constant", *option) == 2
    assert said in capsys.readouterr().err


def test_the_drifts_of_linear_axes_are_combined() -> None:
    """√(x² + y² + z²), without the rotations; nothing to combine where one axis moves alone."""
    lathe = evaluate_on("belt_lathe", "spindle_constant")
    linear = [drift.drift for axis, drift in lathe.axes.items() if axis in "xyz"]
    assert len(linear) > 1 and len(lathe.axes) > len(linear)
    assert lathe.combined == pytest.approx(np.linalg.norm(linear))
    assert lathe.summary()["combined"]["value"] == pytest.approx(1e6 * np.linalg.norm(linear))
    assert evaluate_on("ball_screw_axis", "linear_axis").combined is None


def test_the_command_leaves_a_page_with_everything_in_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["iso230", GANTRY, "spindle_spectrum", "--top", "speed=8000 rpm", "-o", str(tmp_path)]
    assert status(*words) == 0 and "last 60 min" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {"report.html", "iso230.json", "iso230.png"}
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    drift = json.loads((tmp_path / "iso230.json").read_text())["axes"]["z"]["drift"]["value"]
    assert f"{drift:.1f}" in page and "data:image/png;base64" in page and "http:" not in page and "https:" not in page
    assert status(*words[:5], "--json") == 0
    assert json.loads(capsys.readouterr().out)["axes"]["z"]["drift"]["value"] == pytest.approx(drift)


def test_the_readme_shows_what_comes_out(capsys: pytest.CaptureFixture[str]) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = next(block for block in readme.split("```") if block.startswith("\nSimulated along"))
    assert status("iso230", GANTRY, "spindle_constant", "--top", "speed=8000 rpm") == 0
    assert shown.strip() in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((GANTRY, "rotary_axis"), "rotary_speed, which this machine does not read; give a program that moves speed"),
        ((NEW, "linear_axis"), "say which one it is, as in `--input feed=feed_x`, give a program"),
        ((NEW, "linear_axis", "--input", "fed=feed_x"), "names the input 'fed', which is not there; did you"),
        ((NEW, "linear_axis", "--input", "feed"), "does not say what feed is; write PROGRAM's name, ="),
        ((NEW, "linear_axis", "--input", "feed=position"), "calls feed 'position', which is there already"),
        ((str(MACHINES / "specimen_bar.yaml"), "etve"), "needs the input `heater`"),
        ((str(MACHINES / "toaster_oven.yaml"), "etve"), "moves no tool centre point"),
        ((GANTRY, "spindel_constant"), "no program that comes with lptn; did you mean 'spindle_constant'?"),
        ((str(MACHINES / "specimen_bar.yaml"), "etve"), "came with lptn; copy it into your folder, change and name"),
        ((GANTRY, "iso230_rst.yaml"), "give the path of a scenario or a recording's mapping (did you mean iso230_rest"),
        ((GANTRY, "spindle_constant", "--tool-length", "150 mm"), "has no rotation a or b"),
        ((GANTRY, "spindle_constant", "--tool-length", "150"), "'150' has no unit"),
        ((GANTRY, "spindle_constant", "--top", "sped=8000 rpm"), "did you mean 'speed'"),
        ((GANTRY, "iso230_rest.yaml", "--top", "speed=8 rpm"), "scales 'speed', which is zero throughout"),
    ],
)  # fmt: skip
@pytest.mark.usefixtures("rest")
def test_bad_input_is_refused(words: tuple[str, ...], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert status("iso230", *words) == 2
    assert says in capsys.readouterr().err


@pytest.fixture
def rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("iso230_rest.yaml").write_text("scenario: rest\nduration: 4 h\ninputs: {speed: 0 rpm, ambient: 20 degC}\n")


def test_a_recording_without_displacement_is_refused(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("time [s],speed [rpm],ambient [degC]\n0,0,20\n60,8000,20\n")
    with pytest.raises(Refused, match="record one of the displacement channels of this machine: dz, dy"):
        evaluate_thermal_test(Machine.load(GANTRY), Recording.load(tmp_path / "r.csv"))
