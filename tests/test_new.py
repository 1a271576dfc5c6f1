"""`lptn new`: what it writes checks, runs, and holds what an engineer needs to start from."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from network import Machine, Scenario, simulate
from network.cli import main


def run(*words: str) -> int:
    try:
        main(words)
    except SystemExit as leave:
        return int(leave.code or 0)
    return 0


@pytest.fixture
def written(tmp_path: Path) -> Path:
    assert run("new", "-o", str(tmp_path / "mill.yaml")) == 0
    return tmp_path / "mill.yaml"


def test_what_is_written_checks_and_simulates_as_it_is(written: Path, capsys: pytest.CaptureFixture[str]) -> None:
    day = written.with_name("mill_day.yaml")
    assert run("check", str(written), str(day)) == 0
    told = capsys.readouterr()
    assert told.err == "" and "; fits" in told.out
    assert run("simulate", str(written), str(day), "-o", str(written.parent / "out"), "--no-plots") == 0
    assert (written.parent / "out" / "summary.json").is_file()


def test_it_has_three_axes_a_chiller_sensors_and_levels(written: Path) -> None:
    machine = Machine.load(written)
    assert set(machine.tcp) == {"x", "y", "z"}
    assert {"feed_x", "feed_y", "feed_z", "speed", "ambient"} == set(machine.inputs)
    assert machine.sources["chiller"].kind == "thermostat_cooling" and {"dx", "dy", "dz"} <= set(machine.sensors)
    ends = simulate(machine, Scenario.load(written.with_name("mill_day.yaml"))).shown("tcp.z")
    assert -60 < min(ends) < -20 and max(ends) < 30
    for level in ("coarse", "fine", "plain"):
        Machine.load(written, level=level)


def test_its_lumps_are_fine_enough_for_its_drift(written: Path) -> None:
    day = Scenario.load(written.with_name("mill_day.yaml"))
    usual, finer = (simulate(Machine.load(written, level=level), day) for level in (None, "fine"))
    for axis in ("x", "y", "z"):
        own, other = (run.shown(f"tcp.{axis}") for run in (usual, finer))
        assert max(abs(own - other)) < 0.05 * max(abs(other))


def test_its_signs_are_what_its_comments_say(written: Path) -> None:
    """Warm, each part alone moves the tool centre point as the comment beside it says."""
    machine = Machine.load(written)
    signs = {name: entry.direction for (_, name), entry in machine.expansions.items()}
    assert signs["column grows"] == 1 and signs["head grows"] == 1
    assert signs["screw z grows"] == signs["cartridge grows"] == signs["table rises"] == -1


def test_lines_that_are_commented_out_can_be_taken_in(written: Path) -> None:
    text = written.read_text(encoding="utf-8")
    spare = re.findall(r"^  # (\w[^:]*: +\{kind:.*)$", text, re.MULTILINE)
    assert spare
    for line in spare:
        text = text.replace(f"  # {line}", f"  {line}")
    written.write_text(text, encoding="utf-8")
    assert "cutting_power" in Machine.load(written).inputs


def test_nothing_that_is_there_is_replaced(written: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written.write_text("mine", encoding="utf-8")
    capsys.readouterr()
    assert run("new", "-o", str(written)) == 2
    assert "mill.yaml: is there already; give another -o" in capsys.readouterr().err
    assert written.read_text(encoding="utf-8") == "mine"
    assert run("new", "-o", str(written.parent / "mill.txt")) == 2


def test_without_a_name_it_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("new") == 0
    assert "machine: New machine" in capsys.readouterr().out
