"""Beside a running machine: the filter of the C file line by line, restarts, gaps, warnings, refusals."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest

from network import Machine, Scenario, simulate
from network.analysis.correction.correction import make_correction, sample_inputs
from network.analysis.correction.follower import Follower
from network.catalogue.declaration.declare import Array
from network.cli import main

ROOT = Path(__file__).parents[1]
GANTRY = str(ROOT / "machines" / "gantry_spindle.yaml")
WORK = ROOT / "scenarios" / "shift_at_one_speed.yaml"


def lines_of(tmp_path: Path, *changes: str) -> list[str]:
    """A noisy run of the machine, as changed, as lines of a recording: one every 10 s."""
    words = [word for change in changes for word in ("--set", change)]
    main(["simulate", GANTRY, str(WORK), "-o", str(tmp_path / "run"), "--no-plots", "--noise", "--seed", "3", *words])
    return (tmp_path / "run" / "results.csv").read_text(encoding="utf-8").splitlines()


def followed(
    lines: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *words: str
) -> tuple[Array, list[str], str]:
    """Numbers, warnings and what went to standard error."""
    capsys.readouterr()
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(lines) + "\n"))
    main(["follow", GANTRY, *words])
    told = capsys.readouterr()
    rows = [row.partition(',"') for row in told.out.splitlines()[1:]]
    numbers = np.array([[float(cell) for cell in head.rstrip(",").split(",")] for head, _, _ in rows])
    return numbers, [warning for _, _, warning in rows], told.err


def test_it_says_what_the_filter_of_the_c_file_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And that is the truth of the machine, within its band."""
    numbers, warnings, _ = followed(lines_of(tmp_path), capsys, monkeypatch)
    f = make_correction(Machine.load(GANTRY), []).filter
    from network import Recording

    recording = Recording.load(tmp_path / "run" / "results.csv")
    read = np.stack([recording.columns[name].values for name in f.sensors], axis=1)
    _, inputs = sample_inputs(f, recording.schedule(["ambient", "speed"]))
    told, _ = f.run(inputs, read)
    np.testing.assert_allclose(numbers[:, [1, 3]], told, rtol=1e-5, atol=1e-5)
    truth = simulate(Machine.load(GANTRY), Scenario.load(WORK))
    inside = np.abs(numbers[:, 1] - 1e6 * truth.tcp["z"]) <= numbers[:, 2]
    assert inside.mean() > 0.95 and not any(warnings)


def test_a_restart_goes_on_where_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    lines, state = lines_of(tmp_path), tmp_path / "state.json"
    whole, _, _ = followed(lines, capsys, monkeypatch)
    first, _, _ = followed(lines[:500], capsys, monkeypatch, "--state", str(state))
    assert json.loads(state.read_text())["t"] == 4980
    second, _, _ = followed([lines[0], *lines[500:]], capsys, monkeypatch, "--state", str(state))
    np.testing.assert_allclose(np.vstack([first, second]), whole, rtol=1e-9)
    state.write_text(state.read_text().replace('"filter": "', '"filter": "x'))
    with pytest.raises(SystemExit) as end:
        followed(lines, capsys, monkeypatch, "--state", str(state))
    assert end.value.code == 2 and "is the state of another filter" in capsys.readouterr().err


def test_rare_lines_and_gaps_are_bridged_and_hasty_lines_do_not_hurry_it() -> None:
    """A spindle that has run for two hours is told alike, whether a line came every 2, 10, 14 or 600 s."""
    f = make_correction(Machine.load(GANTRY), []).filter
    nothing, ends = np.full(len(f.sensors), np.nan), []
    for every in (2.0, 10.0, 14.0, 600.0):
        follower = Follower(f)
        for t in np.arange(0, 7200, every):
            follower.take(float(t), {"speed": 8000.0, "ambient": 21.6}, nothing)
        ends.append(follower.take(7200.0, {"speed": 8000.0, "ambient": 21.6}, nothing).moved)
    np.testing.assert_allclose(ends, [ends[1]] * 4, rtol=2e-3)


def test_what_the_model_has_not_is_warned_of_with_what_it_follows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bearing that rubs far beyond its ±: told by its name while the spindle turns."""
    lines = lines_of(tmp_path, "sources.front friction.torque=1.8 N m")
    picture = tmp_path / "follow.png"
    _, warnings, _ = followed(lines, capsys, monkeypatch, "--picture", str(picture))
    assert any(warnings) and not any(warnings[:6]) and any(warnings[:36])
    assert picture.stat().st_size > 10_000
    assert "more heat than the machine file has, most like that of front friction" in " ".join(warnings)


def test_what_it_follows_is_told_after_some_turns_of_it() -> None:
    """The same bearing, the spindle on and off by turns for a day: the heat that is missing follows the speed."""
    turns = [{"for": "90 min", "at": f"{rpm} rpm"} for _ in range(8) for rpm in (8000, 0)]
    day = Scenario.of("day", "24 h", {"speed": turns, "ambient": "21.6 degC"}, output="30 s")
    run = simulate(Machine.load(GANTRY, sets=["sources.front friction.torque=1.8 N m"]), day, noise_seed=1)
    f = make_correction(Machine.load(GANTRY), [], step=30.0).filter
    follower, told = Follower(f), list[str]()
    t, inputs = sample_inputs(f, run.schedule)
    read = np.stack([run.sensors[name] for name in f.sensors], axis=1)
    for k, now in enumerate(t.tolist()):
        told += follower.take(now, {name: values[k] for name, values in inputs.items()}, read[k]).warnings
    assert any("most like that of front friction" in warning for warning in told)
    assert any(warning.endswith("it follows speed") for warning in told)
    assert not any("it follows ambient" in warning for warning in told)


def test_numbers_within_their_uncertainty_are_not_warned_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for change in ("sources.front friction.torque=0.32 N m", "sources.motor loss.iron=180 W"):
        _, warnings, _ = followed(lines_of(tmp_path, change), capsys, monkeypatch)
        assert not any(warnings)


def test_lines_that_fail_are_told_and_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = lines_of(tmp_path)[:50]
    whole, _, _ = followed(lines, capsys, monkeypatch)
    cells = lines[20].split(",")
    broken = [*lines[:20], ",".join([*cells[:3], "n/a", *cells[4:]]), "", "1,2", *lines[21:]]
    numbers, _, error = followed(broken, capsys, monkeypatch)
    assert "line 23 has 2 fields" in error and len(numbers) == len(whole)
    np.testing.assert_allclose(numbers[:, 1], whole[:, 1], atol=0.5)


@pytest.mark.parametrize(
    ("head", "says"),
    [
        ("time [s],ambient [degC]", "has no column 'speed'"), ("speed [rpm],ambient [degC]", "has no column 'time'"),
        ("time [s],speed [degC],ambient [degC]", "'speed [degC]' is in another kind of unit; write `speed [rpm]`"),
    ],
)  # fmt: skip
def test_a_header_that_lacks_something_is_refused(
    head: str, says: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(SystemExit) as end:
        followed([head, "0,1,2"], capsys, monkeypatch)
    assert end.value.code == 2 and says in capsys.readouterr().err
