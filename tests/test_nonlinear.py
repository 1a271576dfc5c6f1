"""Networks that are not linear in temperature: against closed solutions and against solve_ivp at 1e-10."""

from __future__ import annotations

import numpy as np
import pytest
from build import RPM, machine, schedule

from network import Failed, Refused, simulate
from network.recordings.inputs import Signal, Start, constant, linear

RADIATES = {"kind": "radiation", "between": ["a", "cold"], "emissivity_area": "0.7 m^2"}


def test_radiation_in_closed_form() -> None:
    """C dT/dt = −k (T⁴ − s⁴): k t/C = F(T₀) − F(T), F = ln((T − s)/(T + s))/(4s³) − atan(T/s)/(2s³), kelvin."""
    C, T0, s, t = 5000.0, 473.15, 223.15, np.linspace(0, 6000, 61)
    body = machine(
        {"a": {"heat_capacity": f"{C} J/K"}, "cold": {"temperature": "-50 degC"}},
        links={"sky": RADIATES}, sensors={"T": {"measures": "a", "noise": "0.1 K"}},
    )  # fmt: skip
    run = simulate(body, schedule(t, start=Start(nodes={"a": T0 - 273.15})))
    assert run.method == "rosenbrock"

    def F(T: np.ndarray) -> np.ndarray:
        return np.log((T - s) / (T + s)) / (4 * s**3) - np.arctan(T / s) / (2 * s**3)

    elapsed = (F(np.array(T0)) - F(run.sensors["T"] + 273.15)) * C / (0.7 * 5.670374419e-8)
    np.testing.assert_allclose(elapsed, t, atol=0.01)


def warm_machine():
    return machine(
        {
            "a": {"heat_capacity": "4 kJ/K"}, "seat": {}, "b": {"heat_capacity": "30 kJ/K"},
            "cold": {"temperature": "ambient"},
        },
        links={
            "sky": RADIATES,
            "seat in": {"kind": "conduction", "between": ["a", "seat"], "conductance": "9 W/K"},
            "seat out": {"kind": "conduction", "between": ["seat", "b"], "conductance": "14 W/K"},
            "seat skin": {
                "kind": "natural_convection", "between": ["seat", "cold"], "coefficient": "1.8 W/(m^2 K^1.25)",
                "area": "0.3 m^2",
            },
            "fan": {
                "kind": "forced_convection", "between": ["b", "cold"], "conductance": "3 W/K", "gain": "2",
                "exponent": "0.8", "reference_speed": "8000 rpm",
            },
        },
        sources={
            "bearing": {
                "kind": "viscous_friction", "into": {"a": 1}, "torque": "520 N mm", "thinning": "0.03 1/K",
                "reads": "a",
            },
            "motor": {
                "kind": "motor_loss", "into": {"b": 1}, "copper": "60 W", "iron": "200 W",
                "reference_speed": "8000 rpm",
            },
        },
        sensors={n: {"measures": n, "noise": "0.1 K"} for n in ("a", "b", "seat")}
        | {"slow": {"measures": "a", "noise": "0.1 K", "effects": [{"kind": "sensor_lag", "lag": "60 s"}]}},
    )  # fmt: skip


def warm_inputs():
    """Speed rests, ramps up through the bend of n^1.5, holds and drops; ambient drifts."""
    t = np.array([0.0, 600.0, 2400.0, 6000.0])
    rpm = np.array([0.0, 0.0, 8000.0, 3000.0]) * RPM
    ramped = Signal("speed", "rpm", t, rpm, np.array([0.0, 8000.0, 8000.0, 3000.0]) * RPM)
    return ramped, linear("ambient", "degC", np.array([0.0, 4000.0, 8000.0]), np.array([20.0, 22.0, 21.0]))


@pytest.mark.proof
def test_rosenbrock_keeps_its_tolerance() -> None:
    """Ramps, junctions, a reading with a state of its own, four kinds that are not linear."""
    t = np.arange(0, 8001, 50.0)
    truth = simulate(warm_machine(), schedule(t, *warm_inputs()), method="solve_ivp:Radau", rtol=1e-10)
    for tolerance, allowed in ((1e-5, 5e-3), (1e-6, 5e-4), (1e-7, 5e-5), (1e-8, 5e-6)):
        run = simulate(warm_machine(), schedule(t, *warm_inputs()), method="rosenbrock", rtol=tolerance)
        worst = max(np.abs(run.sensors[name] - truth.sensors[name]).max() for name in run.sensors)
        assert worst < allowed, tolerance
        assert abs(run.energy.closure) < 10 * tolerance, tolerance


def test_rosenbrock_serves_linear_networks_too() -> None:
    block = machine(
        {"a": {"heat_capacity": "5 kJ/K"}, "cold": {"temperature": "20 degC"}},
        links={"skin": {"kind": "convection", "between": ["a", "cold"], "conductance": "8 W/K"}},
        sources={"on": {"kind": "heat_source", "into": {"a": 1}, "power": "100 W"}},
        sensors={"T": {"measures": "a", "noise": "0.1 K"}},
    )
    t = np.linspace(0, 3000, 31)
    exact, run = (simulate(block, schedule(t), method=m) for m in ("modal", "rosenbrock"))
    np.testing.assert_allclose(run.sensors["T"], exact.sensors["T"], atol=1e-5)


def test_a_bearing_that_runs_away_is_said_not_crashed() -> None:
    from network import Failed

    hot = machine(
        {
            "inner": {"heat_capacity": "1 kJ/K"}, "outer": {"heat_capacity": "50 kJ/K"},
            "cold": {"temperature": "20 degC"},
        },
        links={
            "balls": {"kind": "conduction", "between": ["inner", "outer"], "conductance": "2 W/K"},
            "skin": {"kind": "convection", "between": ["outer", "cold"], "conductance": "5 W/K"},
        },
        sources={
            "bearing": {
                "kind": "preload_friction", "into": {"inner": 1}, "torque": "900 N mm", "growth": "0.1 1/K",
                "inner": "inner", "outer": "outer",
            }
        },
        sensors={"T": {"measures": "inner", "noise": "0.1 K"}},
    )  # fmt: skip
    driver = schedule(np.arange(0, 3601, 60.0), constant("speed", "rpm", 9000 * RPM))
    for method in ("rosenbrock", "solve_ivp:LSODA"):
        with pytest.raises(Failed, match=r"inner .* runs away"):
            simulate(hot, driver, method=method)


def test_an_explicit_method_over_a_jump_in_time_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("network.engine.solvers.reference.MOST_EVALUATIONS", 5000)
    block = machine(
        {"a": {"heat_capacity": "1 kJ/K"}, "cold": {"temperature": "20 degC"}},
        links={"skin": {"kind": "convection", "between": ["a", "cold"], "conductance": "10 W/K"}},
        sources={"on": {"kind": "heat_source", "into": {"a": 1}, "power": "100 W"}},
        sensors={"T": {"measures": "a", "noise": "0.1 K"}},
    )
    short, long = (np.array([0.0, 100.0, 100.0 + jump]) for jump in (1e3, 1e9))
    simulate(block, schedule(short), method="solve_ivp:RK45")
    with pytest.raises(Failed, match=r"RK45 has taken 5000 evaluations from 0 s on and is at .* s; take --method"):
        simulate(block, schedule(long), method="solve_ivp:RK45")
    simulate(block, schedule(long), method="solve_ivp:LSODA")


def test_what_a_method_cannot_do_is_refused() -> None:
    with pytest.raises(Refused, match=r"modal is for linear networks, and .* is not linear in temperature"):
        simulate(warm_machine(), schedule([0, 100.0], *warm_inputs()), method="modal")
    with pytest.raises(Refused, match=r"there is no method 'modle'; did you mean 'modal'\?"):
        simulate(warm_machine(), schedule([0, 100.0], *warm_inputs()), method="modle")
