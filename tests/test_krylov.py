"""Large networks in a small subspace: within the error that is told, from the exact solution in all modes."""

from __future__ import annotations

import numpy as np
import pytest
from bench.cases import bars_machine, chain_machine, speed_steps
from build import machine

from network import Failed, Machine, Scenario, simulate
from network.engine.solvers import krylov
from network.engine.trajectory import Trajectory

STEPS = speed_steps(20, hours=8, output=20.0)


def furthest(a: Trajectory, b: Trajectory) -> float:
    """Largest difference of a temperature [K]."""
    sensed = [n for n, s in a.machine.sensors.items() if s.place is not None]
    return max(*(float(np.abs(a.parts[n] - b.parts[n]).max()) for n in a.parts),
               *(float(np.abs(a.sensors[n] - b.sensors[n]).max()) for n in sensed))  # fmt: skip


def awkward() -> Machine:
    """Bars with a junction, a sensor that lags and a fan that changes a film with the speed."""
    bars = {f"b{i}": {"material": "steel", "length": "1 m", "area": "60 cm^2", "lumps": 210} for i in range(2)}
    return machine(
        {**bars, "joint": {}, "air": {"temperature": "ambient"}},
        links={"left": {"kind": "conduction", "between": ["b0@1", "joint"], "conductance": "40 W/K"},
               "right": {"kind": "conduction", "between": ["joint", "b1@0"], "conductance": "30 W/K"},
               "skin": {"kind": "convection", "between": ["b0", "air"], "conductance": "4 W/K"},
               "fan": {"kind": "forced_convection", "between": ["b1", "air"], "conductance": "3 W/K", "gain": "2",
                       "reference_speed": "10000 rpm"}},
        sources={"heater": {"kind": "heat_source", "into": {"b0@0.1..0.2": 0.7, "joint": 0.3}, "power": "200 W",
                            "with": "speed", "at": "6000 rpm"}},
        tcp={"z": {"grows": {"kind": "stretching", "of": "b0@0.2..0.9", "direction": 1, "length": "700 mm"}}},
        sensors={"T": {"measures": "b0@0.3", "noise": "0.05 K", "effects": [{"kind": "sensor_lag", "lag": "60 s"}]},
                 "J": {"measures": "joint", "noise": "0.05 K"}},
    )  # fmt: skip


def warming() -> Scenario:
    return Scenario.of("day", "8 h", output="20 s", inputs={
        "speed": [{"for": "1 h", "at": "0 rpm"}, {"for": "2 h", "at": "6000 rpm"}, {"for": "30 min", "at": "3000 rpm"},
                  {"at": "0 rpm"}],
        "ambient": {"ramp": {"from": "20 degC", "to": "26 degC", "for": "8 h"}}})  # fmt: skip


@pytest.mark.parametrize("lumps", [bars_machine(450), chain_machine(420)], ids=["bars", "chain"])
def test_the_error_that_is_told_holds_and_is_small(lumps: Machine) -> None:
    small, exact = simulate(lumps, STEPS), simulate(lumps, STEPS, method="modal")
    assert (small.method, exact.method) == ("krylov", "modal")
    assert furthest(small, exact) <= small.error <= 1e-5
    assert abs(small.energy.closure) < 1e-9
    assert np.abs(small.T_end - exact.T_end).max() < 1e-5
    for axis in small.tcp:
        assert small.tcp[axis] == pytest.approx(exact.tcp[axis], abs=1e-10)


def test_junctions_lags_two_regimes_and_ramps_go_into_the_subspace() -> None:
    small, exact = simulate(awkward(), warming()), simulate(awkward(), warming(), method="modal")
    assert small.method == "krylov" and furthest(small, exact) <= small.error <= 1e-5
    assert np.ptp(exact.sensors["J"]) > 5
    assert small.sensors["T"] == pytest.approx(exact.sensors["T"], abs=1e-5)


def test_what_follows_no_small_subspace_is_solved_in_all_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    import network.engine.solvers.krylov as krylov

    monkeypatch.setattr(krylov, "SHIFTS", (3, 3))
    run = simulate(chain_machine(420), STEPS)
    assert run.method == "modal" and "subspace leaves out too much" in run.why


def test_what_is_too_large_for_full_matrices_says_so() -> None:
    large = bars_machine(5000)
    assert simulate(large, speed_steps(4, hours=1, output=20.0), parts=False).method == "krylov"
    with pytest.raises(Failed, match="5001 lumps are too many where every one is set against every other"):
        simulate(large, STEPS, method="modal")


def test_no_more_columns_span_it_than_there_is_room_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of each of two regimes twice as many for every shift, as these are complex."""
    room = list[int]()
    monkeypatch.setattr(krylov, "_span", lambda plan, sides, starts, count: room.append(count))
    columns = krylov._starts
    monkeypatch.setattr(krylov, "_starts", lambda *of: room.append(columns(*of).shape[1]) or columns(*of))
    simulate(awkward(), warming())
    (wide, count), room = room, []
    monkeypatch.setattr(krylov, "MOST_COLUMNS", 2 * 2 * count * wide - 1)
    simulate(awkward(), warming())
    assert room == [wide]
