"""What a run delivers is worked out when it is asked for: the same numbers, and within the limits told beforehand."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from bench.cases import chain_machine, speed_steps
from bench.peers import expm_reference

from network.engine.assembly import build
from network.engine.simulation import simulate
from network.engine.solvers.carry_out import Outcome, solve_schedule
from network.engine.solvers.courses import LazyCourses
from network.engine.start import start_temperatures

CHAIN, STEPS = chain_machine(6), speed_steps(12, hours=2, output=5.0)


def solved(output: float = 5.0) -> Outcome:
    schedule = speed_steps(12, hours=2, output=output)
    network = build(CHAIN)
    return solve_schedule(network, schedule, start_temperatures(network, schedule))


@pytest.mark.parametrize("output", [5.0, 900.0])
def test_a_row_asked_for_alone_is_that_of_all(output: float) -> None:
    whole, alone = solved(output).courses.all(), solved(output).courses
    for row in reversed(range(alone.width)):
        assert alone[row] == pytest.approx(whole[row], abs=1e-10)
    assert solved(output).courses.rows(np.array([3, 1])) == pytest.approx(whole[[3, 1]], abs=1e-10)


def test_rows_are_those_of_matrix_exponentials() -> None:
    run, exact = simulate(CHAIN, STEPS), expm_reference(CHAIN, STEPS)
    for i in range(5):
        assert np.abs(run.parts[f"n{i}"] - exact[:, i]).max() < 1e-9
    assert run.parts["ambient"] == pytest.approx(np.full(len(run.t), 21.5), abs=1e-12)


@pytest.mark.parametrize("output", [5.0, 900.0])
def test_limits_hold_what_happens_and_not_much_more(output: float) -> None:
    outcome = solved(output)
    (low, high), y = outcome.limits, outcome.courses.all()
    assert (low <= y.min(axis=1) + 1e-9).all() and (y.max(axis=1) - 1e-9 <= high).all()
    assert (high - low < 3 * np.ptp(y, axis=1) + 20).all()


def test_parts_wait_until_they_are_asked_for_and_go_to_other_processes() -> None:
    asked: list[str] = []
    courses = LazyCourses({name: lambda name=name: asked.append(name) or np.zeros(2) for name in "ab"})
    assert list(courses) == ["a", "b"] and "a" in courses and not asked
    assert courses["a"] is courses["a"] and asked == ["a"]
    run = simulate(CHAIN, STEPS)
    sent = pickle.loads(pickle.dumps(dict(run.parts)))
    assert sent["n5"] == pytest.approx(run.parts["n5"])
    assert pickle.loads(pickle.dumps(run.heat))["n5"] == pytest.approx(run.heat["n5"])
