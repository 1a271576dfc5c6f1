"""Simulations against answers from outside the program: closed solutions, limits, conservation, symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from build import RPM, machine, schedule
from scipy.integrate import trapezoid

from network import simulate
from network.engine.assembly import build
from network.engine.start import steady_state
from network.recordings.inputs import Start, constant, hold

METHODS = ("modal", "expm", "solve_ivp:LSODA", "solve_ivp:BDF", "solve_ivp:Radau", "solve_ivp:RK45")
EXACT = ("modal", "expm")
ROUNDING = 1e-11
"""Share of an energy that is lost to rounding in sums over some 1e4 intervals, in whatever order a BLAS adds: 1e4 ε is
2e-12."""


def two_masses(C_a: float, C_b: float, G: float):
    return machine(
        {"a": {"heat_capacity": f"{C_a} J/K"}, "b": {"heat_capacity": f"{C_b} J/K"}},
        links={"joint": {"kind": "conduction", "between": ["a", "b"], "conductance": f"{G} W/K"}},
        sensors={name: {"measures": name, "noise": "0.1 K"} for name in ("a", "b")},
    )


@pytest.mark.parametrize("method", METHODS)
def test_two_masses_meet_at_the_capacity_weighted_mean(method: str) -> None:
    """T_a − T_b falls as e^(−t/τ), 1/τ = G (1/C_a + 1/C_b); the weighted mean stays."""
    C_a, C_b, G, T_a, T_b = 5000.0, 20000.0, 12.0, 60.0, 20.0
    t = np.linspace(0, 4000, 201)
    run = simulate(two_masses(C_a, C_b, G), schedule(t, start=Start(nodes={"a": T_a, "b": T_b})), method=method)
    mean = (C_a * T_a + C_b * T_b) / (C_a + C_b)
    gap = (T_a - T_b) * np.exp(-t * G * (1 / C_a + 1 / C_b))
    tolerance = 1e-10 if method in EXACT else 3e-5
    np.testing.assert_allclose(run.sensors["a"], mean + gap * C_b / (C_a + C_b), atol=tolerance, rtol=0)
    np.testing.assert_allclose(run.sensors["b"], mean - gap * C_a / (C_a + C_b), atol=tolerance, rtol=0)


@pytest.mark.parametrize("method", METHODS)
def test_no_pulse_is_skipped(method: str) -> None:
    """600 s of 1 kW at 40 000 s in a day of nothing: the largest temperature of one mass in closed form."""
    C, G, P, begin, length, day = 20_000.0, 8.0, 1000.0, 40_000.0, 600.0, 86_400.0
    block = machine(
        {"block": {"heat_capacity": f"{C} J/K"}, "room": {"temperature": "20 degC"}},
        links={"skin": {"kind": "convection", "between": ["block", "room"], "conductance": f"{G} W/K"}},
        sources={"pulse": {"kind": "heat_source", "into": {"block": 1}, "power": f"{P} W", "with": "on", "at": "1"}},
        sensors={"T": {"measures": "block", "noise": "0.1 K"}},
    )
    pulse = hold("on", "1", np.array([0.0, begin, begin + length]), np.array([0.0, 1.0, 0.0]))
    run = simulate(block, schedule(np.arange(0, day + 1, 200.0), pulse), method=method)
    expected = 20 + P / G * (1 - np.exp(-G * length / C))
    assert run.sensors["T"].max() == pytest.approx(expected, abs=1e-9 if method in EXACT else 1e-4)


def spindle(**changes: str):
    return machine(
        {
            "shaft": {"heat_capacity": "9 kJ/K"}, "housing": {"heat_capacity": "40 kJ/K"}, "seat": {},
            "beam": {"heat_capacity": "300 kJ/K"}, "ambient": {"temperature": "ambient"},
        },
        links={
            "bearing": {"kind": "conduction", "between": ["shaft", "housing"], "conductance": "25 W/K"},
            "flange": {"kind": "conduction", "between": ["housing", "seat"], "conductance": "60 W/K"},
            "guide": {"kind": "conduction", "between": ["seat", "beam"], "conductance": "40 W/K"},
            "skin": {"kind": "convection", "between": ["housing", "ambient"], "conductance": "6 W/K"},
            "beam skin": {"kind": "convection", "between": ["beam", "ambient"], "conductance": "20 W/K"},
        },
        sources={
            "friction": {"kind": "bearing_friction", "into": {"shaft": 0.5, "housing": 0.5}, "torque": "520 N mm"}
            | changes
        },
        sensors={n: {"measures": n, "noise": "0.1 K"} for n in ("shaft", "housing", "seat", "beam")},
    )  # fmt: skip


HOT = np.array([0.0, 3600.0, 7200.0])


def spindle_inputs(rpm: tuple[float, float, float] = (6000, 0, 8000)):
    return hold("speed", "rpm", HOT, np.array(rpm) * RPM), constant("ambient", "degC", 20.0)


def test_steady_state_is_the_linear_solve() -> None:
    """Conductances and heats written down by hand; the massless seat is two conductances in series."""
    q = 6000 * RPM * 0.52
    series = 1 / (1 / 60 + 1 / 40)
    G = np.array([[-25, 25, 0], [25, -25 - series - 6, series], [0, series, -series - 20]], float)
    expected = np.linalg.solve(G, -np.array([q / 2, q / 2 + 6 * 20, 20 * 20.0]))
    network = build(spindle())
    u = {"speed": np.array(6000 * RPM), "ambient": np.array(20.0), "time": np.array(0.0)}
    T = np.full(network.size, 20.0)
    assert steady_state(network, T, u)[[0, 1, 3]] == pytest.approx(expected, abs=1e-9)
    run = simulate(spindle(), schedule([0, 1e6], *spindle_inputs((6000, 6000, 6000))))
    assert [run.sensors[n][-1] for n in ("shaft", "housing", "beam")] == pytest.approx(list(expected), abs=1e-9)


@pytest.mark.parametrize("method", METHODS[1:])
def test_all_methods_agree_with_the_modes(method: str) -> None:
    t = np.linspace(0, 4 * 3600, 289)
    ours = simulate(spindle(), schedule(t, *spindle_inputs()), method="modal")
    other = simulate(spindle(), schedule(t, *spindle_inputs()), method=method)
    for name, values in ours.sensors.items():
        np.testing.assert_allclose(other.sensors[name], values, atol=1e-9 if method == "expm" else 2e-5, rtol=0)
    assert abs(other.energy.closure) < (1e-11 if method == "expm" else 1e-5)


def test_heat_is_conserved_on_the_modal_path() -> None:
    """In, out and stored from closed integrals; the heat in is ω M t by hand, the parts' shares add up."""
    run = simulate(spindle(), schedule(np.arange(0, 14401, 10.0), *spindle_inputs()))
    by_hand = 0.52 * RPM * (6000 * 3600 + 8000 * 7200)
    assert run.energy.in_ == pytest.approx(by_hand, rel=ROUNDING)
    assert abs(run.energy.closure) < ROUNDING
    assert sum(run.energy.absorbed.values()) == pytest.approx(run.energy.total_stored, rel=1e-10)
    for part, heat in run.energy.absorbed.items():
        assert heat == pytest.approx(run.energy.stored[part], rel=1e-9, abs=1e-6)
    assert run.heat["housing"][-1] == pytest.approx(run.energy.absorbed["housing"], rel=1e-9)


def test_a_spindle_turned_backwards_heats_the_same() -> None:
    t = np.arange(0, 14401, 60.0)
    forward = simulate(spindle(), schedule(t, *spindle_inputs((6000, 0, 8000))))
    backward = simulate(spindle(), schedule(t, *spindle_inputs((-6000, 0, -8000))))
    np.testing.assert_allclose(forward.sensors["shaft"], backward.sensors["shaft"], rtol=ROUNDING)


def test_newton_millimetres_and_newton_metres() -> None:
    """q = 1.047e-4 n M with M in N mm is 0.1047 n M with M in N m: 520 N mm at 6000 rpm give 326.7 W."""
    t = [0.0, 3600.0]
    mm = simulate(spindle(torque="520 N mm"), schedule(t, *spindle_inputs((6000, 6000, 6000))))
    m = simulate(spindle(torque="0.52 N m"), schedule(t, *spindle_inputs((6000, 6000, 6000))))
    assert mm.energy.in_ / 3600 == pytest.approx(1.0472e-4 * 6000 * 520, rel=1e-4)
    assert m.energy.in_ == pytest.approx(mm.energy.in_, rel=ROUNDING)


def test_superposition_and_reciprocity() -> None:
    """Rises add up over sources; a watt into a warms b as a watt into b warms a."""

    def rises(heats: dict[str, float]) -> dict[str, np.ndarray]:
        sources = {f"q{n}": {"kind": "heat_source", "into": {n: 1}, "power": f"{q} W"} for n, q in heats.items()}
        base = spindle().to_plain() | {"sources": sources}
        run = simulate(
            machine(base["nodes"], links=base["links"], sources=sources, sensors=base["sensors"]),
            schedule(np.linspace(0, 20_000, 50), *spindle_inputs()),
        )
        return {name: values - 20 for name, values in run.sensors.items()}

    shaft, beam, both = rises({"shaft": 100}), rises({"beam": 100}), rises({"shaft": 100, "beam": 100})
    np.testing.assert_allclose(both["housing"], shaft["housing"] + beam["housing"], atol=1e-10)
    np.testing.assert_allclose(shaft["beam"], beam["shaft"], atol=1e-10)


def bar(lumps: int, **more):
    return machine(
        {
            "bar": {"material": "steel", "length": "1 m", "area": "78.54 cm^2", "lumps": lumps},
            "cold": {"temperature": "20 degC"},
        },
        **more,
    )


def test_bar_heated_at_one_end_converges_at_second_order() -> None:
    """Insulated bar, constant flux at x = 0, against Carslaw & Jaeger §3.8 eq. 3: mean of the far tenth.

    T = q t/(ρ c L) + (q L/k) [ (3(1−x/L)² − 1)/6 − (2/π²) Σ (−1)ⁿ/n² e^(−n²π²Fo) cos nπ(1−x/L) ].
    """
    L, S, k, rho_c, P, t = 1.0, 78.54e-4, 50.66, 7850 * 477.0, 10.0, 7200.0
    fourier, n = k / rho_c * t / L**2, np.arange(1, 400)
    xi = np.linspace(0, 0.1, 2001)  # distance from the far end over L
    inside = (3 * xi**2 - 1) / 6 - 2 / np.pi**2 * (
        (-1.0) ** n / n**2 * np.exp(-(n**2) * np.pi**2 * fourier) * np.cos(np.outer(xi, n) * np.pi)
    ).sum(axis=1)
    expected = 20 + float(trapezoid(P / S * t / (rho_c * L) + P / S * L / k * inside, xi) / 0.1)
    errors = []
    for lumps in (10, 20, 40, 80):
        heated = bar(
            lumps,
            links={"no loss": {"kind": "convection", "between": ["bar", "cold"], "conductance": "0 W/K"}},
            sources={"flux": {"kind": "heat_source", "into": {"bar@0": 1}, "power": f"{P} W"}},
            sensors={"far": {"measures": "bar@0.9..1", "noise": "0.1 K"}},
        )
        errors.append(abs(simulate(heated, schedule([0, t])).sensors["far"][-1] - expected))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.9).all() and (orders < 2.3).all(), (errors, orders)


@pytest.mark.parametrize("place", ["bar@0", "bar@0.5", "bar@0.2..0.4"])
@pytest.mark.parametrize("lumps", [1, 12])
def test_stretching_does_not_depend_on_where_the_heat_enters(place: str, lumps: int) -> None:
    """ΔL = α E/(ρ c S), eq. 5; from temperatures and from the heat integrated without them."""
    entries = {
        method: {"kind": "stretching", "of": "bar", "direction": 1, "method": method}
        for method in ("temperature", "heat")
    }
    heated = bar(
        lumps, tcp={"z": entries},
        links={"skin": {"kind": "convection", "between": ["bar", "cold"], "conductance": "1.5 W/K"}},
        sources={"flux": {"kind": "heat_source", "into": {place: 1}, "power": "10 W"}},
    )  # fmt: skip
    run = simulate(heated, schedule(np.arange(0, 36001, 600.0)))
    from_temperature, from_heat = run.contributions["z", "temperature"], run.contributions["z", "heat"]
    np.testing.assert_allclose(from_heat, from_temperature, rtol=1e-9, atol=1e-18)
    assert from_heat[-1] == pytest.approx(1.13e-5 * run.energy.absorbed["bar"] / (7850 * 477 * 78.54e-4), rel=1e-9)


def test_a_point_link_cannot_cool_a_lump_below_its_surroundings() -> None:
    """Coupling mean temperatures would; elementary flows between lumps do not."""
    cooled = bar(
        10,
        links={"jacket": {"kind": "convection", "between": ["bar@0..0.5", "cold"], "conductance": "400 W/K"}},
        sources={"flux": {"kind": "heat_source", "into": {"bar@0": 1}, "power": "500 W"}},
    )
    run = simulate(cooled, schedule([0, 50_000]))
    assert run.T_end[build(cooled).parts["bar"]].min() >= 20.0


def relay(C: float, q: float, P: float, h: float, delay: float = 0.0):
    return machine(
        {"tank": {"heat_capacity": f"{C} J/K"}, "room": {"temperature": "20 degC"}},
        links={"none": {"kind": "convection", "between": ["tank", "room"], "conductance": "0 W/K"}},
        sources={
            "load": {"kind": "heat_source", "into": {"tank": 1}, "power": f"{q} W"},
            "cooler": {
                "kind": "thermostat_cooling", "into": {"tank": 1}, "watches": "tank", "set": "22 degC",
                "hysteresis": f"{h} K", "power": f"{P} W", "delay": f"{delay} s",
            },
        },
        sensors={"T": {"measures": "tank", "noise": "0.1 K"}},
    )  # fmt: skip


@pytest.mark.parametrize("delay", [0.0, 40.0])
def test_relay_period_of_one_mass(delay: float) -> None:
    """Without losses: off for 2hC/q, on for 2hC/(P − q); a delay d adds d P/(P − q) and d P/q (by hand)."""
    C, q, P, h = 65_000.0, 300.0, 800.0, 0.7
    run = simulate(relay(C, q, P, h, delay), schedule(np.arange(0, 20_000, 60.0)))
    switches = np.array([t for t, _, _ in run.switches])
    expected = 2 * h * C * (1 / q + 1 / (P - q)) + delay * (P / q + P / (P - q))
    np.testing.assert_allclose(switches[3:] - switches[1:-2], expected, rtol=1e-6)
    assert abs(run.energy.closure) < 1e-8


def test_relay_period_shortens_as_the_load_rises() -> None:
    periods = []
    for q in (150.0, 250.0, 350.0):
        run = simulate(relay(65_000, q, 800, 0.7), schedule([0.0, 30_000.0]))
        on = [t for t, _, mode in run.switches if mode]
        periods.append(on[2] - on[1])
    assert periods[0] > periods[1] > periods[2]


def test_bar_that_melts_stretches_on_while_its_temperature_stands() -> None:
    """Heat grows evenly, temperature pauses; stored heat is what was brought in."""
    melts = {"at": "28 degC", "over": "2 K", "latent_heat": "180 kJ"}
    block = machine(
        {"store": {"heat_capacity": "5 kJ/K", "melts": melts}, "room": {"temperature": "20 degC"}},
        links={"none": {"kind": "convection", "between": ["store", "room"], "conductance": "0 W/K"}},
        sources={"heater": {"kind": "heat_source", "into": {"store": 1}, "power": "100 W"}},
        sensors={"T": {"measures": "store", "noise": "0.1 K"}},
    )  # fmt: skip
    run = simulate(block, schedule(np.arange(0, 4001, 10.0)))
    assert run.method == "rosenbrock"
    assert run.sensors["T"][-1] == pytest.approx(20 + (400_000 - 180_000) / 5000, abs=1e-3)
    assert run.heat["store"][-1] == pytest.approx(400_000, rel=1e-6)
    middle = (run.t > 600) & (run.t < 2000)
    assert run.sensors["T"][middle].std() < 0.5


def test_sensor_lag_of_a_ramp_is_its_time_constant() -> None:
    """A mass without losses warms by P t/C; a lagged reading follows by P/C · lag (1 − e^(−t/lag))."""
    C, P, lag = 10_000.0, 50.0, 90.0
    block = machine(
        {"block": {"heat_capacity": f"{C} J/K"}},
        sources={"heater": {"kind": "heat_source", "into": {"block": 1}, "power": f"{P} W"}},
        sensors={
            "true": {"measures": "block", "noise": "0.1 K"},
            "slow": {
                "measures": "block", "noise": "0.1 K",
                "effects": [{"kind": "sensor_offset", "offset": "0.4 K"}, {"kind": "sensor_lag", "lag": f"{lag} s"}],
            },
        },
    )  # fmt: skip
    t = np.arange(0, 1001, 10.0)
    for method in ("modal", "expm"):
        run = simulate(block, schedule(t, start=Start(others=20.0)), method=method)
        behind = run.sensors["true"] + 0.4 - run.sensors["slow"]
        np.testing.assert_allclose(behind, P / C * lag * (1 - np.exp(-t / lag)), atol=1e-10)


def test_a_stream_loop_carries_heat_one_way_and_loses_none() -> None:
    """Steady: the jacket's outlet is P/W above its inlet; the loop as a whole neither makes nor loses heat."""
    W, P = 50.0, 400.0
    loop = machine(
        {
            "tank": {"heat_capacity": "20 kJ/K"}, "jacket": {"heat_capacity": "2 kJ/K"},
            "room": {"temperature": "20 degC"},
        },
        links={
            "loop": {
                "kind": "advection", "through": ["tank", "jacket", "tank"],
                "capacity_flow": f"{W} W/K", "delay": "30 s",
            },
            "tank skin": {"kind": "convection", "between": ["tank", "room"], "conductance": "40 W/K"},
        },
        sources={"spindle": {"kind": "heat_source", "into": {"jacket": 1}, "power": f"{P} W"}},
    )  # fmt: skip
    run = simulate(loop, schedule([0.0, 100_000.0]))
    assert run.parts["jacket"][-1] - run.parts["tank"][-1] == pytest.approx(P / W, abs=1e-6)
    assert run.parts["tank"][-1] == pytest.approx(20 + P / 40, abs=1e-6)
    assert abs(run.energy.by_mechanism["links.loop"]) < 1e-6 * run.energy.in_
    assert abs(run.energy.closure) < 1e-9


def test_heat_between_two_held_nodes_is_nobodys() -> None:
    """It passes the parts by and does not enter the account."""
    block = machine(
        {"block": {"heat_capacity": "5 kJ/K"}, "hot": {"temperature": "40 degC"}, "cold": {"temperature": "20 degC"}},
        links={
            "past": {"kind": "conduction", "between": ["hot", "cold"], "conductance": "100 W/K"},
            "skin": {"kind": "convection", "between": ["block", "hot"], "conductance": "8 W/K"},
        },
    )
    run = simulate(block, schedule([0.0, 600.0]))
    assert run.energy.by_mechanism["links.past"] == 0.0
    assert abs(run.energy.closure) < ROUNDING
