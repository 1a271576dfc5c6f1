"""The shortest warm-up: against a closed form, against two runs one after the other, and what is told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from build import RPM, machine

from network import Machine, Refused, Scenario, simulate
from network.analysis.sweep.warm_up import find_warm_up
from network.cli import main

ROOT = Path(__file__).parents[1]
GANTRY, SHIFT = ROOT / "machines" / "gantry_spindle.yaml", ROOT / "scenarios" / "shift_at_one_speed.yaml"
CAPACITY, SKIN, TORQUE = 12_000.0, 4.0, 1.0
PER_KELVIN = 0.4 * 1e-5


def spindle() -> Machine:
    """One part with τ = 50 min that friction heats, 1 N m."""
    rub = {"kind": "bearing_friction", "into": {"a": 1}, "torque": "1 N m"}
    skin = {"kind": "convection", "between": ["a", "air"], "conductance": "4 W/K"}
    grows = {"kind": "stretching", "of": "a", "length": "400 mm", "expansion": "1e-5 1/K", "direction": 1}
    nodes = {"a": {"heat_capacity": "12 kJ/K"}, "air": {"temperature": "20 degC"}}
    return machine(nodes, links={"skin": skin}, sources={"rub": rub}, tcp={"z": {"grows": grows}})


def work(speed: str = "2000 rpm") -> Scenario:
    return Scenario.of("work", "6 h", {"speed": speed}, output="20 s")


@pytest.mark.parametrize("tolerance", [20.0, 50.0, 120.0])
def test_one_part_needs_what_its_closed_form_says(tolerance: float) -> None:
    """After w of the same speed what is left of ΔT∞ (1 − e^(−t/τ)) is ΔT∞ (e^(−w/τ) − e^(−(w + 6 h)/τ))."""
    final = 2000 * RPM * TORQUE / SKIN * PER_KELVIN * 1e6
    tau = CAPACITY / SKIN
    expected = tau * np.log(final * (1 - np.exp(-6 * 3600 / tau)) / tolerance)
    found = find_warm_up(spindle(), work(), f"{tolerance} um", speeds="2000 rpm")
    shortest = found.chosen.shortest
    assert shortest is not None and expected <= shortest <= expected + 61
    assert found.chosen.leaves <= tolerance * 1e-6 and found.none == pytest.approx(final * 1e-6, rel=1e-3)


def test_twice_the_speed_is_sooner_and_can_be_too_long() -> None:
    """At twice the heat the part has its final temperature after τ ln 2, and overshoots beyond."""
    found = find_warm_up(spindle(), work(), "20 um", speeds="2000, 4000 rpm")
    slow, fast = found.attempts
    assert fast.shortest is not None and slow.shortest is not None and fast.shortest < slow.shortest
    assert found.chosen is fast
    never = find_warm_up(spindle(), work(), "0.001 um", speeds="4000 rpm").chosen
    assert never.shortest is None and abs(never.best - CAPACITY / SKIN * np.log(2)) <= 60
    assert never.left[-1] > 3 * never.left.min()


def test_a_warm_up_goes_before_the_scenario_as_it_stands() -> None:
    """Ramps, steps and a room that warms begin later: the same as two runs, the second from where the first ended."""
    day = Scenario.load(ROOT / "scenarios" / "day_of_work.yaml")
    gantry = Machine.load(GANTRY)
    found = find_warm_up(gantry, day, "0.1 um", speeds="6000 rpm", longest=1200.0)
    warm = Scenario.of("warm", "20 min", {"speed": [{"for": "1 s", "at": "0 rpm"}, {"at": "6000 rpm"}],
                                          "ambient": "21.6 degC"})  # fmt: skip
    first = simulate(gantry, warm)
    ends = {name: f"{values[-1]:.12f} degC" for name, values in first.parts.items() if gantry.nodes[name].is_part}
    ranges = [np.ptp(v) for v in _run_from(gantry, day, ends).values()]
    assert found.attempts[0].left[-1] == pytest.approx(max(ranges), rel=2e-3)


def _run_from(gantry: Machine, day: Scenario, ends: dict[str, str]) -> dict[str, np.ndarray]:
    from network.recordings.yaml_values import start_of

    text = "{" + ", ".join(f"{name}: {value}" for name, value in ends.items()) + "}"
    return dict(simulate(gantry, day, start=start_of(text)).tcp)


def test_no_warm_up_is_told_where_none_is_needed() -> None:
    found = find_warm_up(spindle(), work(), "1 mm", speeds="2000 rpm")
    told = found.summary()
    assert told["minutes"] == 0 and told["schedule"] == [] and "No warm-up is needed" in str(found)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ({"tolerance": "2"}, "has no unit"), ({"tolerance": "2 K"}, "no movement of this machine's tool centre point"),
        ({"tolerance": "2 um", "speeds": "2000"}, "'2000' has no unit"),
        ({"tolerance": "2 um", "speeds": "0, 2000 rpm"}, "not above zero"),
        ({"tolerance": "2 um", "driven": "sped"}, "did you mean 'speed'"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(words: dict[str, str], says: str) -> None:
    with pytest.raises(Refused, match=says):
        find_warm_up(spindle(), work(), **words)
    with pytest.raises(Refused, match=r"give them, as in --speeds '4000, 8000 rpm'"):
        find_warm_up(spindle(), work("0 rpm"), "2 um")


def test_what_is_too_long_is_refused_before_anything_is_simulated(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("network.engine.simulation.MOST_VALUES", 5000)
    monkeypatch.delattr("network.analysis.sweep.warm_up.simulate")
    with pytest.raises(Refused, match=r"1081 samples of 8 courses .* give one sample in 2"):
        find_warm_up(spindle(), work(), "20 um")


def test_the_command_tells_draws_and_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["warmup", str(GANTRY), str(SHIFT), "--tolerance", "6 um", "--speeds", "3000, 4500, 6000 rpm"]
    main([*words, "-o", str(tmp_path)])
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = next(block for block in readme.split("```") if "min at 6000 rpm leave" in block)
    assert shown.strip() in capsys.readouterr().out
    told = json.loads((tmp_path / "warmup.json").read_text())
    assert 30 < told["minutes"] < 32 and told["left"]["unit"] == "um" and told["left"]["value"] <= 6
    assert told["schedule"][0]["speed"] == {"value": pytest.approx(6000), "unit": "rpm"}
    assert (tmp_path / "warmup.png").stat().st_size > 10_000
