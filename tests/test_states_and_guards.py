"""States and guards of entries: chillers, fans and valves against closed answers, other solvers and conservation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import build as small
import numpy as np
import pytest
from fits import recorded
from scipy.integrate import trapezoid

from network import Machine, calibrate
from network.analysis.diagnosis.candidates.candidates import kinds as searched
from network.catalogue.declaration import registry
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, place
from network.catalogue.mechanisms.base import Link, Stream
from network.catalogue.mechanisms.mechanism import Inputs, Relay, State, beyond
from network.catalogue.mechanisms.pi_cooling import PiCooling
from network.catalogue.mechanisms.switched_convection import SwitchedConvection
from network.engine.assembly import build
from network.engine.simulation import simulate
from network.engine.trajectory import Trajectory
from network.platform.refusal import Refused
from network.recordings.inputs import Start, constant

C, Q = 6000.0, 300.0
"""J/K of the one mass, W of its constant heat."""
AIR = constant("ambient", "degC", 20.0)
OTHERS = ("solve_ivp:LSODA", "solve_ivp:Radau")


def one_mass(links: Mapping[str, Any] | None = None, sources: Mapping[str, Any] | None = None) -> Machine:
    """A mass heated by Q beside air of 20 °C, at the reference of 22 °C."""
    heater = {"heater": {"kind": "heat_source", "into": {"tank": 1}, "power": f"{Q} W"}}
    loss = {"skin": {"kind": "convection", "between": ["tank", "air"], "conductance": "0 W/K"}}
    return small.machine(
        {"tank": {"heat_capacity": f"{C} J/K"}, "air": {"temperature": "ambient"}}, "22 degC",
        links={**loss, **(links or {})}, sources={**heater, **(sources or {})},
        sensors={"T": {"measures": "tank", "noise": "0.05 K"}},
    )  # fmt: skip


def run(machine: Machine, hours: float = 2.0, every: float = 10.0, **options: Any) -> Trajectory:
    made = simulate(machine, small.schedule(np.arange(0.0, hours * 3600 + 1, every), AIR), **options)
    assert abs(made.energy.closure) < 1e-6
    return made


# -- a chiller under PI control -------------------------------------------------------------------------------------
def chilled(**numbers: str) -> Machine:
    body = {"kind": "pi_cooling", "into": {"tank": 1}, "watches": "tank", "set": "22 degC"}
    return one_mass(sources={"chiller": {**body, "gain": "60 W/K", "reset_time": "100 s", **numbers}})


def second_order(t: Array, gain: float = 60.0, reset_time: float = 100.0) -> Array:
    """Excess of one mass under a step Q of heat: Q/(C ω) e^(−σt) sin ωt, real for ω² < 0 too."""
    decay = gain / (2 * C)
    omega = np.sqrt(complex(gain / (C * reset_time) - decay**2))
    return np.real(Q / (C * omega) * np.exp(-decay * t) * np.sin(omega * t))


@pytest.mark.parametrize("method", ["auto", "modal", "expm", "rosenbrock", *OTHERS])
def test_a_chiller_answers_as_a_second_order(method: str) -> None:
    made = run(chilled(), method=method)
    assert made.method == ("modal" if method == "auto" else method)
    close = 1e-9 if made.method in ("modal", "expm") else 2e-5
    assert made.shown("T") - 22 == pytest.approx(second_order(made.t), abs=close)


@pytest.mark.parametrize("reset_time", [25.0, 400.0, 401.0, 4000.0])
def test_it_swings_rests_and_creeps_as_its_damping_says(reset_time: float) -> None:
    """At t_i = 4C/G = 400 s two modes are one."""
    made = run(chilled(reset_time=f"{reset_time} s"))
    at = second_order(made.t, reset_time=reset_time if reset_time != 400 else 400.000001)
    assert made.shown("T") - 22 == pytest.approx(at, abs=1e-6)


def test_what_it_has_integrated_ends_as_the_load() -> None:
    """At rest G z = Q; the course of z is that of its integral."""
    made = run(chilled(), every=1.0)
    (path, unit_text, z), *_ = [c for c in made.part_columns_in_si() if c[0].startswith("sources.")]
    assert (path, unit_text) == ("sources.chiller.reset", "K")
    assert abs(z[0]) < 1e-12 and 60 * z[-1] == pytest.approx(Q, rel=1e-6)
    excess = made.shown("T") - 22
    summed = np.concatenate([[0.0], np.cumsum((excess[1:] + excess[:-1]) / 2)]) / 100
    assert z == pytest.approx(summed, abs=1e-3)


def test_a_steady_start_finds_it_at_its_set_point() -> None:
    schedule = small.schedule(np.arange(0.0, 3601.0, 60.0), AIR, start=Start(steady=True))
    made = simulate(chilled(), schedule)
    assert made.shown("T") == pytest.approx(22, abs=1e-9)
    assert made.states["sources.chiller.reset"] == pytest.approx(Q / 60, rel=1e-9)


def test_states_are_neither_parts_nor_heat() -> None:
    machine = chilled()
    made = run(machine)
    assert list(made.parts) == ["tank", "air"] and list(made.energy.absorbed) == ["tank"]
    assert set(made.energy.by_mechanism) == {"links.skin", "sources.heater", "sources.chiller"}
    assert made.energy.total_stored == pytest.approx(C * (made.shown("T")[-1] - 22), rel=1e-9, abs=1e-6)
    assert not any("reset" in warning for warning in made.warnings)
    assert build(machine).size == 3 and list(build(machine).bodies) == ["tank", "air"]


def test_a_chiller_at_its_limit_is_a_constant_loss() -> None:
    """Above it, T rises with (Q − P)/C; z has followed the limit, so the chiller lets go as soon as T is back."""
    made = run(chilled(limit="200 W"), hours=4)
    assert made.method == "rosenbrock" and "pi_cooling" in made.why
    late = made.t > 3600
    assert np.diff(made.shown("T")[late]) / 10 == pytest.approx((Q - 200) / C, rel=1e-6)
    assert made.states["sources.chiller.reset"][-1] == pytest.approx(200 / 60, rel=1e-6)


def test_a_far_limit_changes_nothing_and_never_heats() -> None:
    with_limit, without = run(chilled(limit="5 kW")), run(chilled())
    cooling = with_limit.states["sources.chiller.reset"] + with_limit.shown("T") - 22
    assert cooling.min() >= -1e-9, "over-damped runs of this size never ask for heat"
    assert with_limit.shown("T") == pytest.approx(without.shown("T"), abs=2e-5)


@pytest.mark.parametrize("method", OTHERS)
def test_solvers_agree_on_a_limited_chiller(method: str) -> None:
    machine = chilled(limit="400 W", reset_time="30 s")
    assert run(machine, method=method).shown("T") == pytest.approx(run(machine).shown("T"), abs=1e-4)


# -- a fan that a temperature switches ------------------------------------------------------------------------------
def fanned(**numbers: str) -> Machine:
    body = {"kind": "switched_convection", "between": ["tank", "air"], "watches": "tank", "set": "30 degC"}
    return one_mass(links={"fan": {**body, "hysteresis": "1 K", "conductance": "50 W/K", **numbers}})


def saw_tooth(G: float = 50.0, low: float = 29.0, high: float = 31.0) -> tuple[float, float]:
    """Times of one mass to warm by Q and to cool by G towards 20 °C + Q/G."""
    settled = 20 + Q / G
    return C * (high - low) / Q, C / G * np.log((high - settled) / (low - settled))


@pytest.mark.parametrize("method", ["auto", "solve_ivp:Radau"])
def test_a_fan_runs_the_saw_tooth(method: str) -> None:
    made = run(fanned(), method=method)
    if method == "auto":
        assert made.method == "rosenbrock"
        assert made.why.startswith("links.fan (switched_convection) changes a conductance as it switches")
    off, on = saw_tooth()
    first = C * (31 - 22) / Q
    expected = [first + k // 2 * (off + on) + (on if k % 2 else 0.0) for k in range(len(made.switches))]
    assert [t for t, _, _ in made.switches] == pytest.approx(expected, abs=0.01)
    assert [(name, is_on) for _, name, is_on in made.switches[:3]] == [("fan", True), ("fan", False), ("fan", True)]
    assert len(made.switches) > 20
    assert (made.shown("T").min(), made.shown("T")[made.t > first].min()) >= (22 - 1e-6, 29 - 1e-3)
    assert made.shown("T").max() <= 31 + 1e-3


def test_a_late_fan_overshoots_by_what_comes_meanwhile() -> None:
    made = run(fanned(delay="20 s"), every=1.0)
    settled, late = 20 + Q / 50, made.t > 1000
    assert made.shown("T").max() == pytest.approx(31 + Q * 20 / C, abs=0.06)
    assert made.shown("T")[late].min() == pytest.approx(settled + (29 - settled) * np.exp(-20 * 50 / C), abs=0.06)


def test_a_weak_fan_stays_on() -> None:
    made = run(fanned(conductance="25 W/K"), hours=6)
    assert len(made.switches) == 1
    assert made.shown("T")[-1] == pytest.approx(20 + Q / 25, abs=1e-3)


def test_a_fan_that_is_warm_begins_switched_on() -> None:
    made = simulate(fanned(), small.schedule(np.arange(0.0, 600.0, 10.0), AIR, start=Start(others=35.0)))
    settled = 20 + Q / 50
    falling = settled + (35 - settled) * np.exp(-50 / C * made.t)
    first = made.shown("T")[falling > 29]
    assert first == pytest.approx(falling[falling > 29], abs=1e-5)


def test_every_flow_goes_by_the_mode_of_its_own_relay() -> None:
    """A cooler that never starts, a fan that starts once, a fan that switches: heat of each from the temperatures."""
    cooler = {"kind": "thermostat_cooling", "into": {"tank": 1}, "watches": "tank", "set": "40 degC", "power": "900 W"}
    body = {"kind": "switched_convection", "between": ["tank", "air"], "watches": "tank", "hysteresis": "1 K"}
    weak = {**body, "set": "26 degC", "conductance": "10 W/K"}
    strong = {**body, "set": "34 degC", "conductance": "50 W/K"}
    made = run(one_mass({"weak": weak, "strong": strong}, {"cooler": {**cooler, "hysteresis": "1 K"}}), every=1.0)
    names = [name for _, name, _ in made.switches]
    assert set(names) == {"weak", "strong"} and names.count("weak") == 1
    brought = made.energy.by_mechanism
    assert brought["sources.cooler"] == 0
    begun = next(t for t, name, _ in made.switches if name == "weak")
    excess = np.where(made.t >= begun, made.shown("T") - 20, 0.0)
    assert brought["links.weak"] == pytest.approx(-10 * trapezoid(excess, made.t), rel=2e-3)
    assert sum(brought.values()) == pytest.approx(made.energy.total_stored, rel=1e-5)


def test_a_fan_on_a_bar_cools_each_lump_by_its_own_difference() -> None:
    bar = {"material": "steel", "length": "300 mm", "area": "100 cm^2", "lumps": 5}
    fan = {"kind": "switched_convection", "between": ["bar", "air"], "watches": "bar@0.9", "set": "30 degC"}
    heater = {"kind": "heat_source", "into": {"bar@0..0.2": 1}, "power": "600 W"}
    made = run(small.machine(
        {"bar": bar, "air": {"temperature": "ambient"}}, "22 degC",
        links={"fan": {**fan, "hysteresis": "0.5 K", "conductance": "60 W/K"}}, sources={"heater": heater},
        sensors={"T": {"measures": "bar@0.9", "noise": "0.05 K"}},
    ))  # fmt: skip
    assert len(made.switches) > 4
    late = made.t > made.switches[1][0]
    assert made.shown("T")[late].min() == pytest.approx(29.5, abs=0.1)


# -- the grammar: any mechanism, in one class -----------------------------------------------------------------------
@pytest.fixture
def own_kinds(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Kinds that a test declares are gone after it."""
    monkeypatch.setattr(registry, "_REGISTRY", {section: dict(kinds) for section, kinds in registry._REGISTRY.items()})
    yield


def test_a_link_keeps_a_state(own_kinds: None) -> None:
    """A film that fouls, Q = G e^(−z) ΔT, dz/dt = 1/t_f: ln of an excess falls by G t_f/C (1 − e^(−t/t_f))."""

    class Fouling(Link, kind="fouling"):
        conductance = param("W/K", 0, 1e6, "conductance when clean")
        lasts = param("s", 0, 1e9, "time in which it falls to 1/e", positive=True)
        states = {"layer": State("1", "thickness")}
        affine = False

        def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
            Q: Array = self.conductance * np.exp(-own[0]) * (T_a - T_b)
            return Q

        def rate(self, u: Inputs, *own: Array) -> tuple[Array, ...]:
            return (1 / self.lasts + 0 * own[0],)

    film = {"kind": "fouling", "between": ["tank", "air"], "conductance": "20 W/K", "lasts": "600 s"}
    machine = one_mass(links={"film": film}).patched({"sources": {"heater": None}})
    schedule = small.schedule(np.arange(0.0, 3601.0, 10.0), AIR, start=Start(others=60.0))
    for method in ("auto", *OTHERS):
        made = simulate(machine, schedule, method=method)
        excess = 40 * np.exp(-20 * 600 / C * (1 - np.exp(-made.t / 600)))
        assert made.shown("T") - 20 == pytest.approx(excess, abs=2e-5)
        assert made.states["links.film.layer"] == pytest.approx(made.t / 600, abs=1e-6)
        assert abs(made.energy.closure) < 1e-6


def test_a_guard_switches_a_stream(own_kinds: None) -> None:
    """A valve in a supply of 20 °C: the tank cools by W as by a fan of that conductance."""

    class Valve(Stream, Relay, kind="valve"):
        capacity_flow = param("W/K", 0, 1e6, "capacity flow while open")
        set = param("degC", -50, 300, "set point")
        watches = place("the place whose temperature opens it")

        def transport(self) -> tuple[float, float]:
            return 0.0, float(self.capacity_flow)

        def heat_flow(self, T_a: Array, T_b: Array, u: Inputs, *own: Array) -> Array:
            Q: Array = self.capacity_flow * (T_a - T_b)
            return Q

        def guard(self, mode: Array, u: Inputs, *own: Array) -> Array:
            return beyond(mode, own[0], self.set, np.array(1.0))

        def pause(self) -> Array:
            return np.array(0.0)

    valve = {"kind": "valve", "through": ["air", "tank"], "watches": "tank", "set": "30 degC"}
    made, (off, on) = run(one_mass(links={"valve": {**valve, "capacity_flow": "50 W/K"}})), saw_tooth()
    instants = [t for t, _, _ in made.switches]
    assert np.diff(instants[:5]) == pytest.approx([on, off, on, off], abs=0.02)


# -- calibration and diagnosis --------------------------------------------------------------------------------------
def test_a_fit_finds_the_numbers_of_a_chiller() -> None:
    """On the exact path of a linear machine: the state answers to every number by heat, as a lump does."""
    truth, uncertain = (chilled(gain=gain, reset_time=time) for gain, time in
                        (("75 W/K", "480 s"), ("60 W/K ± 40 %", "600 s ± 40 %")))  # fmt: skip
    schedule = small.schedule(np.arange(0.0, 7201.0, 10.0), AIR, start=Start(others=20.0))
    found = calibrate(uncertain, recorded(truth, schedule, seed=None)).machine.sources["chiller"]
    assert float(found.gain) == pytest.approx(75, rel=2e-3)
    assert float(found.reset_time) == pytest.approx(480, rel=2e-3)


def test_a_fit_finds_the_limit_of_a_chiller() -> None:
    """Not linear: by corrected rounds, as with friction that thins."""
    truth, uncertain = (chilled(limit=text) for text in ("230 W", "300 W ± 40 %"))
    schedule = small.schedule(np.arange(0.0, 3601.0, 10.0), AIR, start=Start(others=20.0))
    found = calibrate(uncertain, recorded(truth, schedule, seed=3)).machine.sources["chiller"]
    assert float(found.limit) == pytest.approx(230, rel=0.01)


def test_a_fit_refuses_a_switched_conductance() -> None:
    machine = fanned(conductance="50 W/K ± 30 %")
    schedule = small.schedule(np.arange(0.0, 7201.0, 10.0), AIR, start=Start(others=20.0))
    with pytest.raises(Refused) as caught:
        calibrate(machine, recorded(machine, schedule, seed=1))
    assert str(caught.value) == (
        "test: links.fan (switched_convection) switches a conductance, which a fit cannot follow; a fit follows relays "
        "that switch a heat; simulate and compare serve this machine as it is"
    )


def test_a_fit_refuses_a_limited_chiller_beside_a_relay() -> None:
    cooler = {"kind": "thermostat_cooling", "into": {"tank": 1}, "watches": "tank", "set": "25 degC", "power": "500 W"}
    both = {"sources": {"cooler": {**cooler, "hysteresis": "1 K"}}}
    schedule = small.schedule(np.arange(0.0, 7201.0, 10.0), AIR, start=Start(others=20.0))
    linear, limited = (chilled(gain="60 W/K ± 30 %", **more).patched(both) for more in ({}, {"limit": "200 W"}))
    with pytest.raises(Refused, match=r"sources.chiller \(pi_cooling\) is not linear, .* beside a relay; "):
        calibrate(limited, recorded(limited, schedule, seed=1))
    assert float(calibrate(linear, recorded(linear, schedule, seed=1)).machine.sources["chiller"].gain) > 0


def test_a_diagnosis_looks_for_neither() -> None:
    kinds = {*searched()}
    assert kinds.isdisjoint({SwitchedConvection, PiCooling})
    assert {"thermostat_cooling", "forced_convection", "hidden_mass"} <= {cls.kind for cls in kinds}
