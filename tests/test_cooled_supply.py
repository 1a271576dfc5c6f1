"""Coolant loops: the delay of a closed loop, a supply under PI control, alone and concealed."""

from __future__ import annotations

import build as small
import numpy as np
import pytest
from fits import recorded, speeds, two_blocks
from scipy.integrate import solve_ivp
from scipy.stats import gamma
from test_concealed_kinds import LADDERS, explain, own, proposed, said

from network import simulate
from network.analysis.diagnosis.hypotheses.case import Case
from network.catalogue.mechanisms.advection import Advection
from network.recordings.inputs import constant, hold

CELLS = Advection.cells
W, DELAY = 400.0, 120.0


def test_a_loop_comes_back_after_its_delay() -> None:
    """A large tank warms at once by 10 K; what reaches a small one behind it is the distribution of n tanks in series
    (Levenspiel), mean DELAY/2 for each of two legs, standard deviation over mean 1/√n."""
    machine = small.machine(
        {"tank": {"temperature": "supply"}, "jacket": {"heat_capacity": "0.01 J/K"}},
        links={"loop": {"kind": "advection", "through": ["tank", "jacket", "tank"], "capacity_flow": f"{W} W/K",
                        "delay": f"{DELAY} s"}},
        sensors={"T": {"measures": "jacket", "noise": "0.1 K"}},
    )  # fmt: skip
    t = np.arange(0.0, 401.0, 5.0)
    step = hold("supply", "degC", np.array([0.0, 100.0]), np.array([20.0, 30.0]))
    T = simulate(machine, small.schedule(t, step)).shown("T")
    leg = DELAY / 2
    assert pytest.approx(10 * gamma.cdf(t - 100, CELLS, scale=leg / CELLS), abs=1e-3) == T - 20


SUPPLY = {
    "nodes": {"supply": {"heat_capacity": "20 kJ/K"}},
    "links": {
        "loop": {
            "kind": "advection", "through": ["supply", "body", "supply"], "capacity_flow": "80 W/K", "delay": "60 s",
        },
    },
    "sources": {
        "chiller": {
            "kind": "pi_cooling", "into": {"supply": 1}, "watches": "supply", "set": "19 degC", "gain": "60 W/K",
            "reset_time": "400 s",
        },
    },
}  # fmt: skip


def test_a_supply_under_pi_control_in_a_delayed_loop() -> None:
    """Tank, two chains of cells, body, and the integral, by another solver written out by hand."""
    machine = small.machine(
        {"body": {"heat_capacity": "15 kJ/K"}, **SUPPLY["nodes"]}, links=SUPPLY["links"],
        sources={**SUPPLY["sources"], "heat": {"kind": "heat_source", "into": {"body": 1}, "power": "500 W"}},
        sensors={"T": {"measures": "supply", "noise": "0.1 K"}},
    )  # fmt: skip
    made = simulate(machine, small.schedule(np.arange(0.0, 7201.0, 60.0), constant("ambient", "degC", 20.0)))
    cell = 80 * 60 / (2 * CELLS)

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        tank, body, z, there, back = y[0], y[1], y[2], y[3 : 3 + CELLS], y[3 + CELLS :]
        flow = 80.0
        fed, returned = np.append(tank, there[:-1]), np.append(body, back[:-1])
        return np.concatenate([
            [(flow * (back[-1] - tank) - 60 * (tank - 19 + z)) / 20e3, (500 + flow * (there[-1] - body)) / 15e3,
             (tank - 19) / 400],
            flow * (fed - there) / cell, flow * (returned - back) / cell,
        ])  # fmt: skip

    y0 = np.full(3 + 2 * CELLS, 20.0)
    y0[2] = 0.0
    other = solve_ivp(rate, (0, 7200), y0, t_eval=made.t, method="LSODA", rtol=1e-10, atol=1e-10)
    assert made.method in ("modal", "expm")
    assert made.shown("T") == pytest.approx(other.y[0], abs=1e-6)
    assert made.shown("T")[-1] == pytest.approx(19, abs=0.05), "no offset is left under PI control"


def test_a_held_coolant_that_is_a_chilled_tank() -> None:
    jacket = {"kind": "convection", "between": ["body", "coolant"], "conductance": "25 W/K ± 20 %"}
    plain = two_blocks(nodes={"coolant": {"temperature": "19 degC"}}, links={"jacket": jacket})
    tank = {
        "nodes": {"coolant": {"heat_capacity": "12 kJ/K"}},
        "links": {"to room": {"kind": "convection", "between": ["coolant", "air"], "conductance": "3 W/K"}},
        "sources": {"chiller": {**SUPPLY["sources"]["chiller"], "into": {"coolant": 1}, "watches": "coolant"}},
    }  # fmt: skip
    runs = (recorded(plain.patched(tank), speeds(*ladder), seed) for seed, ladder in enumerate(LADDERS))
    case = Case(plain, tuple(runs))
    found = explain(case, proposed(case, "suspects", "pi_cooling", "coolant", "air"))
    told = own(found)
    assert told["set"] == pytest.approx(19, abs=0.1)
    assert told["gain"] / told["reset_time"] == pytest.approx(60 / 400, rel=0.3)
    assert "under PI control" in said(found)
