"""Joints that move along a bar: heat under the joint, regimes, conservation, refusals; by hand and by every method."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build import machine, position, schedule

from network import Machine, simulate
from network.engine.assembly import build
from network.engine.channels import readouts
from network.engine.solvers.linear import reduce
from network.engine.solvers.method_choice import make_plan
from network.platform.refusal import Refused
from network.recordings.inputs import Start, hold, linear
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

EXACT = ("modal", "expm")
METHODS = (*EXACT, "solve_ivp:LSODA", "solve_ivp:Radau")


def joint(lumps: int = 2, width: str = "100 mm", at: Any = "position", conductance: str = "10 W/K") -> Machine:
    """A nut held at 40 °C on a screw whose lumps exchange nothing: 1 m, C = 1000 J/K."""
    screw = {"material": "insulator", "length": "1 m", "area": "10 cm^2", "lumps": lumps}
    body = {"kind": "moving_contact", "between": ["nut", "screw"], "conductance": conductance, "at": at, "width": width}
    stuff = {"density": "1000 kg/m^3", "specific_heat": "1000 J/(kg K)", "conductivity": "1e-12 W/(m K)"}
    ends = [i / lumps for i in range(lumps + 1)]
    return machine(
        {"screw": screw, "nut": {"temperature": "40 degC"}},
        materials={"insulator": stuff | {"expansion": "0 1/K"}},
        links={"balls": body},
        sensors={f"T{i}": {"measures": f"screw@{a}..{b}", "noise": "0.1 K"} for i, (a, b) in enumerate(pairwise(ends))},
    )  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_heat_goes_into_the_lump_under_the_joint(method: str) -> None:
    """200 s over the first half, 100 s over the second, 100 s astride: T = 40 − 20 e^(−∫G dt/C), C = 500 J/K a lump,
    ∫G dt = 10 · 200 + 3/4 · 10 · 100 and 10 · 100 + 1/4 · 10 · 100 J/K; 75 mm of the 100 mm lie on the first half."""
    run = simulate(joint(), schedule([0, 200, 300, 400], position((0, 250), (200, 600), (300, 475))), method=method)
    expected = 40 - 20 * np.exp(-np.array([2750.0, 1250.0]) / 500)
    assert [run.sensors["T0"][-1], run.sensors["T1"][-1]] == pytest.approx(list(expected), abs=1e-6)
    assert run.sensors["T1"][1] == pytest.approx(20, abs=1e-6)
    warmed = 500 * (expected.sum() - 40)
    assert run.energy.by_mechanism["links.balls"] == pytest.approx(warmed, rel=1e-7)
    assert abs(run.energy.closure) < (1e-9 if method in EXACT else 1e-5)


def test_a_joint_that_runs_heats_both_by_the_time_it_is_there() -> None:
    """From 250 mm to 750 mm in 1000 s each half has it for 500 s: 1 W/K · 500 s/(500 J/K) is one time constant; after
    250 s the joint has not left the first half, which is half a time constant on its way."""
    ramp = linear("position", "mm", np.array([0, 1e3]), np.array([0.25, 0.75]))
    run = simulate(joint(conductance="1 W/K"), schedule([0, 250, 1000], ramp))
    assert run.method not in EXACT and "position" in run.why
    both = 40 - 20 * np.exp(-500 / 500)
    assert [run.sensors["T0"][-1], run.sensors["T1"][-1]] == pytest.approx([both, both], abs=1e-5)
    assert run.sensors["T0"][1] == pytest.approx(40 - 20 * np.exp(-250 / 500), abs=1e-5)


def test_at_its_end_the_whole_joint_stays_on_the_bar() -> None:
    """At 0 and beyond all of it lies on the first half; a joint longer than the bar covers all of it alike."""
    ends = ((0, "100 mm", (1, 0)), (-80, "100 mm", (1, 0)), (1000, "100 mm", (0, 1)), (300, "3 m", (0.5, 0.5)))
    for x, width, shares in ends:
        run = simulate(joint(width=width), schedule([0, 50.0], position((0, x))))
        expected = [40 - 20 * np.exp(-10 * share * 50 / 500) for share in shares]
        assert [run.sensors["T0"][-1], run.sensors["T1"][-1]] == pytest.approx(expected, abs=1e-9)
        assert len(run.warnings) == (x < 0)


def test_a_thousand_positions_are_as_many_regimes_as_there_are_patterns() -> None:
    """Two lumps and a joint inside one or the other: two sets of conductances, whatever the position."""
    built, t = joint(), np.arange(0, 1001.0)
    x = np.where(np.arange(1001) % 7 < 3, 0.1, 0.6) + 0.3 * (t / 1000)
    driver = schedule(t, hold("position", "mm", t, x))
    network = build(built)
    plan = make_plan(network, driver, np.array([20.0, 20.0, 40.0]))
    assert plan.method == "modal" and len(reduce(plan, readouts(network)).regimes) == 2
    modal, expm = (simulate(built, driver, method=method).sensors["T0"] for method in EXACT)
    assert modal == pytest.approx(expm, abs=1e-9)


def test_too_many_regimes_take_the_general_path() -> None:
    """On 100 lumps, 300 positions astride of them: 300 sets of conductances, 3 million numbers."""
    built, t = joint(100), np.arange(0, 301.0)
    driver = schedule(t, hold("position", "mm", t, 0.1 + 0.0017 * (t % 300)))
    run = simulate(built, driver)
    assert run.method not in EXACT and "'position' makes 300 sets of conductances" in run.why
    assert run.sensors["T30"] == pytest.approx(simulate(built, driver, method="modal").sensors["T30"], abs=1e-6)


def test_no_lump_gets_hotter_than_what_heats_it() -> None:
    """A part that moves along a warm bar, both with profiles of their own: what one end gives the other gets, and
    nothing leaves the range of temperatures at the start."""
    bars = {n: {"material": "steel", "length": "1 m", "area": "10 cm^2", "lumps": 8} for n in ("slide", "bed")}
    guide = {"kind": "moving_contact", "between": ["slide@0.2..0.9", "bed"], "at": "position", "width": "310 mm"}
    places = [f"{bar}@{i / 8}..{(i + 1) / 8}" for bar in bars for i in range(8)]
    sensors = {f"T{i}": {"measures": place, "noise": "1 K"} for i, place in enumerate(places)}
    built = machine(bars, links={"guide": guide | {"conductance": "200 W/K"}}, sensors=sensors)
    steps = position(*((60.0 * k, (370 * k) % 1000) for k in range(60)))
    run = simulate(built, schedule(np.arange(0, 3601, 10.0), steps, start=Start(nodes={"slide": 60, "bed": 20})))
    everything = np.array([*run.sensors.values()])
    assert everything.min() > 20 - 1e-9 and everything.max() < 60 + 1e-9
    assert run.energy.total_stored == pytest.approx(0, abs=1e-6) and run.energy.carried["links.guide"] > 1e4


def test_along_a_recording_a_position_holds_until_the_next_sample(tmp_path: Path) -> None:
    """An axis is where it goes within seconds: 200 s over each half, and no conductance on a ramp."""
    (tmp_path / "run.csv").write_text("time [s],position [mm]\n0,250\n200,600\n400,250\n")
    run = simulate(joint(), Recording.load(tmp_path / "run.csv"))
    expected = 40 - 20 * np.exp(-10 * 200 / 500)
    assert run.method == "modal"
    assert [run.sensors["T0"][-1], run.sensors["T1"][-1]] == pytest.approx([expected, expected], abs=1e-9)


def test_in_one_lump_the_position_changes_nothing() -> None:
    still = simulate(joint(1), schedule([0, 100.0], position((0, 500)))).sensors["T0"]
    moved = simulate(joint(1), schedule([0, 100.0], position((0, 0), (50, 900)))).sensors["T0"]
    assert moved == pytest.approx(still, abs=1e-12)


def test_a_range_on_the_bar_of_a_moving_joint_is_refused() -> None:
    body = joint().to_plain()["links"]["balls"] | {"between": ["nut", "screw@0.2..0.8"]}
    with pytest.raises(Refused, match=r"screw@0.2..0.8 is a part of the bar; write screw: `at` and `width` say where"):
        joint().patched({"links": {"balls": body}})


def test_a_position_in_another_unit_is_refused() -> None:
    for built, wrong in ((joint(), "0.5"), (joint(at="0 + position"), "300 mm")):
        with pytest.raises(Refused, match=r"the input `position` is in (1|mm), and the machine reads it in (m|1)"):
            simulate(built, Scenario.of("wrong", "1 min", {"position": wrong}))
    with pytest.raises(Refused, match="one input has one kind of unit"):
        joint(at="0 + position").patched({"links": {"two": joint().to_plain()["links"]["balls"]}})


def test_a_joint_beyond_its_bar_is_doubted() -> None:
    assert "`1200 mm` is 1200 mm along the 1000 mm of screw" in str(joint(at="1200 mm").warnings[0])
