"""Step by step solutions: layouts of the Jacobian, switchings within a step, melting; against references and limits."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest
from bench.bent_cases import bent_machine, run_bent
from bench.cases import chain_machine, speed_steps
from build import RPM, machine, schedule
from fits import two_blocks

from network import Machine, simulate
from network.catalogue.nodes import Melting
from network.engine.solvers.frozen_slopes import FrozenSlopes
from network.engine.solvers.plan import Plan
from network.engine.solvers.relay_modes import RelayModes
from network.engine.solvers.slope_layout import Banded, Dense, Layout, Sparse, lay_out
from network.engine.solvers.step_heat import StepHeat
from network.recordings.inputs import constant, linear

STEPS = speed_steps(8, hours=1, output=20.0)


def random_slopes(n: int, seed: int) -> np.ndarray:
    """A matrix that is stable, of a ring with some chords."""
    draw, J = np.random.default_rng(seed), np.zeros((n, n))
    for i in range(n):
        for j in {(i + 1) % n, (i + 7) % n}:
            J[i, j], J[j, i] = draw.uniform(0.1, 1, 2)
    return J - np.diag(J.sum(axis=1) + 0.5)


@pytest.mark.parametrize("kind", ["dense", "banded", "sparse"])
def test_every_layout_solves_the_same(kind: str) -> None:
    n = 30
    J = random_slopes(n, 1)
    i, j = np.nonzero(J)
    order = np.random.default_rng(2).permutation(n)
    layouts: dict[str, Layout] = {"dense": Dense(n), "banded": Banded(order, n - 1), "sparse": Sparse(n, i, j)}
    layout, b, mass = layouts[kind], np.arange(n) - 4.0, np.where(np.arange(n) == 3, 0.0, 2.0)
    slopes = np.zeros(layout.count)
    slopes[layout.places(i, j)] = J[i, j]
    assert layout.factorise(mass, slopes)(b) == pytest.approx(np.linalg.solve(np.diag(mass) - J, b), rel=1e-10)
    scaled = layout.factorise(mass, slopes * np.arange(1.0, n + 1)[layout.column])(b)
    assert scaled == pytest.approx(np.linalg.solve(np.diag(mass) - J * np.arange(1.0, n + 1), b), rel=1e-10)


def test_a_chain_is_a_band_and_what_is_joined_to_all_is_sparse() -> None:
    along = np.arange(199)
    chain = lay_out(200, along, along + 1)
    assert isinstance(chain, Banded) and chain.width == 1
    draw = np.random.default_rng(0)
    assert isinstance(lay_out(200, draw.integers(0, 200, 900), draw.integers(0, 200, 900)), Sparse)


@pytest.mark.parametrize("nodes", [8, 90])
def test_steps_agree_with_the_modes_of_a_linear_chain(nodes: int) -> None:
    chain = chain_machine(nodes)
    exact, run = simulate(chain, STEPS, method="modal"), simulate(chain, STEPS, method="rosenbrock", rtol=1e-9)
    for name, values in exact.parts.items():
        assert run.parts[name] == pytest.approx(values, abs=2e-6)
    assert run.T_end == pytest.approx(exact.T_end, abs=2e-6)


def test_a_radiating_mesh_agrees_with_solve_ivp_on_bare_arrays() -> None:
    bent = bent_machine(70, mesh=True)
    run, other = simulate(bent, STEPS), run_bent(bent, STEPS, "Radau", 1e-9)
    assert run.method == "rosenbrock"
    for i in range(5):
        assert run.sensors[f"T{i}"] == pytest.approx(other[:, i], abs=1e-4)


def test_what_bends_along_a_ramp_is_as_exact_in_modes_as_in_fine_steps() -> None:
    """Motor losses ∝ |n|^1.5 between speeds of both signs, in a network that is linear."""
    t, rpm = np.array([0.0, 600, 1800, 2400]), np.array([0.0, 8000, -8000, 3000]) * RPM
    ramps = linear("speed", "rpm", t, rpm), constant("ambient", "degC", 20.0)
    day = schedule(np.arange(0.0, 3001.0, 60.0), *ramps)
    exact, stepped = (simulate(two_blocks(), day, method=m, rtol=r) for m, r in (("auto", None), ("rosenbrock", 1e-10)))
    assert exact.method == "modal"
    assert exact.sensors["T_motor"] == pytest.approx(stepped.sensors["T_motor"], abs=1e-5)


LUMPS = 1500


def many_that_glow() -> Machine:
    nodes = {f"n{i}": {"heat_capacity": "1 kJ/K"} for i in range(LUMPS)} | {"room": {"temperature": "20 degC"}}
    glow = {"kind": "radiation", "emissivity_area": "1 m^2"}
    links = {f"g{i}": glow | {"between": [f"n{i}", "room"]} for i in range(LUMPS)}
    return machine(nodes, links=links, sensors={"T": {"measures": "n0", "noise": "0.1 K"}})


def test_large_machines_are_laid_out_without_zeros(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slopes of what radiates are found in less memory than one matrix of lumps against lumps would take."""
    peaks = []

    def measured(plan: Plan) -> StepHeat:
        tracemalloc.start()
        try:
            return StepHeat(plan)
        finally:
            peaks.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()

    monkeypatch.setattr("network.engine.solvers.rosenbrock.StepHeat", measured)
    glows = simulate(many_that_glow(), schedule([0.0, 10.0]))
    assert glows.method == "rosenbrock" and max(peaks) < 8 * LUMPS**2


def test_without_zeros_it_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = simulate(melter(), schedule(np.arange(0, 1801, 10.0)))
    monkeypatch.setattr("network.engine.solvers.step_heat.FULL", 1)
    thin = simulate(melter(), schedule(np.arange(0, 1801, 10.0)))
    assert thin.parts["store"] == pytest.approx(whole.parts["store"], abs=1e-9)


def melter() -> Machine:
    """A store that melts, kept by a cooler, and radiates: bent, switched and melting at once."""
    return machine(
        {"store": {"heat_capacity": "5 kJ/K", "melts": {"at": "28 degC", "over": "0.5 K", "latent_heat": "60 kJ"}},
         "case": {"heat_capacity": "9 kJ/K"}, "room": {"temperature": "20 degC"}},
        links={"wall": {"kind": "conduction", "between": ["store", "case"], "conductance": "20 W/K"},
               "glow": {"kind": "radiation", "between": ["case", "room"], "emissivity_area": "0.8 m^2"}},
        sources={"heater": {"kind": "heat_source", "into": {"store": 1}, "power": "150 W"},
                 "cooler": {"kind": "thermostat_cooling", "into": {"case": 1}, "watches": "case", "set": "26 degC",
                            "hysteresis": "0.5 K", "power": "260 W", "delay": "20 s"}},
        sensors={"T": {"measures": "store", "noise": "0.1 K"}},
    )  # fmt: skip


def test_what_bends_switches_and_melts_agrees_with_solve_ivp() -> None:
    run, other = (simulate(melter(), schedule(np.arange(0, 3601, 10.0)), method=m, rtol=r)
                  for m, r in (("auto", 1e-9), ("solve_ivp:LSODA", 1e-9)))  # fmt: skip
    assert run.method == "rosenbrock" and len(run.switches) == len(other.switches) > 4
    for (t, _, on), (at, _, too) in zip(run.switches, other.switches, strict=True):
        assert on == too and t == pytest.approx(at, abs=0.02)
    assert run.parts["store"] == pytest.approx(other.parts["store"], abs=1e-3)
    assert abs(run.energy.closure) < 1e-6
    assert run.heat["store"][-1] == pytest.approx(other.heat["store"][-1], rel=1e-6)


def test_a_room_that_changes_at_every_sample_is_stepped_through_on_known_slopes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As exact as with the slopes of every step, relays and what melts included, and most steps need none."""
    t = np.arange(0, 4801, 10.0)
    room = 20 + np.cumsum(0.05 * np.random.default_rng(4).standard_normal(len(t)))
    along, took = schedule(t, linear("ambient", "degC", t, room)), list[bool]()
    melts, inner = melter().patched({"nodes": {"room": {"temperature": "ambient"}}}), FrozenSlopes.step

    def count(*of: Any) -> Any:
        made = inner(*of)
        took.append(made is not None)
        return made

    exact = simulate(melts, along, method="solve_ivp:LSODA", rtol=1e-9)
    monkeypatch.setattr(FrozenSlopes, "step", count)
    short = simulate(melts, along, rtol=1e-7)
    assert short.method == "rosenbrock" and np.mean(took) > 0.5 and len(took) > 500
    assert len(short.switches) == len(exact.switches) > 4
    for name in ("store", "case"):
        assert np.abs(short.parts[name] - exact.parts[name]).max() < 1e-3
    assert abs(short.energy.closure) < 1e-5
    monkeypatch.setattr(FrozenSlopes, "step", lambda *of: None)
    plain = simulate(melts, along, rtol=1e-7)
    assert np.abs(plain.parts["store"] - short.parts["store"]).max() < 1e-4


def test_a_relay_without_delay_switches_between_two_samples() -> None:
    """A guard that is crossed on known slopes is found again where the step is made anew."""
    t = np.arange(0, 3601, 10.0)
    room = 20 + np.cumsum(0.05 * np.random.default_rng(4).standard_normal(len(t)))
    prompt = {"nodes": {"room": {"temperature": "ambient"}}, "sources": {"cooler": {"delay": "0 s"}}}
    along, cools = schedule(t, linear("ambient", "degC", t, room)), melter().patched(prompt)
    run, other = (simulate(cools, along, method=m, rtol=1e-8) for m in ("auto", "solve_ivp:LSODA"))
    assert len(run.switches) == len(other.switches) > 4
    for (at, _, on), (told, _, too) in zip(run.switches, other.switches, strict=True):
        assert on == too and at == pytest.approx(told, abs=0.02)


def test_heat_that_goes_with_the_square_of_an_input_that_ramps_is_all_counted() -> None:
    t = np.arange(0, 1801, 10.0)
    current = np.abs(1 + 0.3 * np.random.default_rng(5).standard_normal(len(t)))
    loss = {"kind": "heat_source", "into": {"case": 1}, "power": "80 W", "with": "current", "at": "1 A", "exponent": 2}
    heated = melter().patched({"sources": {"loss": loss, "cooler": None}})
    along = schedule(t, linear("current", "A", t, current))
    run, other = (simulate(heated, along, method=m, rtol=1e-8) for m in ("auto", "solve_ivp:LSODA"))
    assert np.abs(run.parts["case"] - other.parts["case"]).max() < 1e-3
    assert abs(run.energy.closure) < 1e-5


def test_two_crossings_within_one_step_are_seen() -> None:
    """A guard that rises above zero between two looks and falls again: its top is found by a parabola."""

    class Hill(RelayModes):
        def __init__(self) -> None:
            self.pending, self.on = {}, np.zeros(1)

        def _values(self, seen: object, s: np.ndarray) -> np.ndarray:
            return (0.002 - (s - 0.375) ** 2)[:, None]

    found = Hill().first_crossing(lambda s: (s, {}), 40.0)
    assert found is not None and found[1] == 0
    assert found[0] == pytest.approx(0.375 - 0.002**0.5, abs=1e-9)


@pytest.mark.parametrize("over", [0.001, 0.5, 20.0])
def test_temperature_is_the_inverse_of_heat(over: float) -> None:
    melts = Melting(at=28.0, over=over, latent_heat=60e3)
    T = np.concatenate([np.linspace(10, 50, 400), 28 + over * np.linspace(-0.51, 0.51, 400)])
    apparent = T + melts.compute_latent_heat(T) / 5000.0
    assert melts.temperature(apparent, 5000.0) == pytest.approx(T, abs=1e-9)
