"""Where relays switch: the search for crossings, and whole runs against an integrator that steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from fit_networks import FAN, RADIATES, VISCOUS, cooler, ramped
from fits import problem_of, recorded, speeds, two_blocks

from network.engine.balance import affine_heat, affine_matrix, heat_into, list_tangent_offsets
from network.engine.response.parameters import centres
from network.engine.simulation import simulate
from network.engine.solvers.crossing import first_crossing


@dataclass(frozen=True)
class Sums:
    """Guards that are sums of decays and a constant: Σ c e^(−λτ)."""

    c: np.ndarray
    rates: np.ndarray

    def values(self, tau):
        return np.exp(-np.multiply.outer(tau, self.rates)) @ self.c

    def curvature(self, tau):
        return np.exp(-np.multiply.outer(tau, self.rates)) * self.rates**2 @ np.abs(self.c)

    def first(self, length):
        return first_crossing(self, 0.0, length, self.curvature(np.zeros(1))[0])


@pytest.mark.parametrize("above", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_crossing_is_found_however_short(above):
    """(e^(−τ) − e^(−2τ)) peaks at ln 2 with 1/4; over 1000 s all but the first pieces are empty."""
    guard = Sums(np.array([[1.0], [-1.0], [above - 0.25]]), np.array([1.0, 2.0, 0.0]))
    x = (1 - np.sqrt(1 - 4 * (0.25 - above))) / 2
    assert guard.first(1000.0) == pytest.approx(-np.log(1 - x), abs=1e-9 + 1e-16 / np.sqrt(above))
    assert Sums(guard.c - [[0], [0], [2 * above]], guard.rates).first(1000.0) is None


def test_the_first_of_three_crossings_in_one_piece():
    """(y − a)(y − b)(y − c) with y = e^(−τ) is below zero until y = c, and above it again from y = b to a."""
    a, b, c = np.exp(-np.array([0.043, 0.0427, 0.0421]))
    guard = Sums(-np.array([[1.0], [-(a + b + c)], [a * b + b * c + c * a], [-a * b * c]]), np.array([3.0, 2, 1, 0]))
    assert guard.first(16.0) == pytest.approx(0.0421, abs=1e-6)


def test_crossings_are_those_of_dense_samples():
    draw, t = np.random.default_rng(2), np.linspace(0, 50, 200_001)
    found = 0
    for _ in range(60):
        guard = Sums(draw.standard_normal((5, 2)) - [[0.0], [0], [0], [0], [0.6]], np.array([4.0, 1, 0.3, 0.1, 0]))
        above = (guard.values(t) > 0).any(axis=1)
        crossing = guard.first(50.0)
        assert (crossing is not None) == above.any()
        if crossing is not None:
            assert t[max(int(above.argmax()) - 1, 0)] - 1e-9 <= crossing <= t[above.argmax()] + 1e-9
            found += crossing > 0
    assert found > 10


def test_a_relay_that_heats_the_massless_junction_it_watches():
    seat = {
        "flange": {"kind": "conduction", "between": ["motor", "seat"], "conductance": "200 W/K"},
        "rest": {"kind": "conduction", "between": ["seat", "body"], "conductance": "300 W/K"},
    }
    relay = {**cooler("0 s"), "into": {"seat": 1}, "watches": "seat"}
    machine = two_blocks(nodes={"seat": {}}, links=seat, sources={"cooler": relay})
    schedule = speeds((0.0, 8000), (0.5, 4000), hours=1.5)
    runs = [simulate(machine, schedule, method=method) for method in ("switched", "solve_ivp:LSODA")]
    exact, stepped = (np.array([t for t, _, _ in run.switches]) for run in runs)
    assert len(exact) > 4
    np.testing.assert_allclose(exact, stepped, atol=0.05)


def test_relays_that_see_a_ramped_room_switch_as_an_integrator_says():
    relays = {"cooler": cooler("25 s"), "vent": {**cooler("40 s"), "watches": "air", "set": "21.3 degC"}}
    runs = [simulate(two_blocks(sources=relays), ramped(), method=m) for m in ("switched", "solve_ivp:LSODA")]
    assert [s[1:] for s in runs[0].switches] == [s[1:] for s in runs[1].switches]
    np.testing.assert_allclose([s[0] for s in runs[0].switches], [s[0] for s in runs[1].switches], atol=0.05)


def test_relays_go_on_where_speed_changes_what_is_conducted():
    """Every regime from the interval at which it begins, and every relay by what it watches itself: three regimes of
    the fan, two coolers and a heater in one run, against finer steps."""
    second = {**cooler("0 s"), "into": {"motor": 1}, "watches": "motor", "set": "32 degC", "power": "90 W"}
    heater = {**cooler("0 s"), "kind": "thermostat_heating", "watches": "motor", "set": "28 degC", "power": "80 W"}
    relays = {"cooler": {**cooler("0 s"), "set": "23 degC"}, "heater": heater, "second": second}
    machine = two_blocks(links={"fan": FAN}, sources=relays)
    schedule = speeds((0.0, 8000), (0.4, 3000), (0.6, 8000), (1.1, 5000), hours=1.6)
    exact, stepped = (
        simulate(machine, schedule, method=m, rtol=r) for m, r in (("switched", None), ("rosenbrock", 1e-9))
    )
    assert {name for _, name, _ in exact.switches} == {*relays}
    assert [s[1:] for s in exact.switches] == [s[1:] for s in stepped.switches]
    np.testing.assert_allclose([s[0] for s in exact.switches], [s[0] for s in stepped.switches], atol=1e-3)
    np.testing.assert_allclose(exact.sensors["T_motor"], stepped.sensors["T_motor"], atol=1e-5)


def test_tangents_touch_their_laws_beside_relays_gates_and_ramps() -> None:
    """What they bring at the temperatures that they are laid about is what the laws bring there, whatever is driven."""
    glow = {**RADIATES, "while": "speed"}
    machine = two_blocks(links={"glow": glow, "fins": FAN}, sources={"rub": VISCOUS, "cooler": cooler("25 s ± 20 %")})
    problem = problem_of(machine, recorded(machine, ramped(), None))
    plan = problem.model.predict(centres(problem.parameters))[0].course.problem.plan
    network, about, K = plan.network, plan.about, len(plan.steps)
    off, held = np.zeros((K, network.relay_count)), {name: u[:, None] for name, u in plan.left.items()}
    slopes = np.array([affine_matrix(network, {n: u[k] for n, u in plan.left.items()}, off[0], about) @ about
                       for k in range(K)])  # fmt: skip
    for u in plan.just_inside:
        own = np.zeros((K, network.size))
        for heat, spread in list_tangent_offsets(network, about, u, held):
            own += np.atleast_2d(heat) @ spread
        whole = heat_into(network, np.tile(about, (K, 1)), u, off) - slopes - affine_heat(network, u, off, K)
        free = np.isfinite(network.capacity)
        assert np.abs(whole[:, free]).max() > 1.0
        np.testing.assert_allclose(own[:, free], whole[:, free], atol=1e-9)
