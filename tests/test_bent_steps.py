"""A stretch of a bent course: recursions that mix modes, runs that end within it, and what is tried on few runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fits import ANOTHER, USUAL, problem_of, recorded, speeds
from test_calibration_slopes import MACHINES

from network.analysis.calibration.gauss_newton import linearise
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.few_runs import FEW, list_worst_runs, on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis_fit import state
from network.engine.response import bent_steps
from network.engine.response.parameters import centres
from network.engine.response.recursion import chain_blocks, recur_coupled
from network.engine.response.segments import Segment


@pytest.mark.parametrize("count", [1, 2, 7, 50])
def test_modes_that_mix_come_to_what_steps_one_by_one_come_to(count: int) -> None:
    rng = np.random.default_rng(count)
    through, push, x = rng.normal(0, 0.4, (count, 3, 3)), rng.normal(size=(count, 2, 3)), rng.normal(size=(2, 3))
    expected, now = [], x
    for A, f in zip(through, push, strict=True):
        expected.append(now)
        now = now @ A + f
    before, end = recur_coupled(through, push.copy(), x, chain_blocks(through))
    np.testing.assert_allclose(before, expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(end, now, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ["bent", "bent and late"])
def test_slopes_are_the_same_with_modes_mixed_and_apart(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = MACHINES[name]
    runs = [recorded(machine, speeds(*steps), None) for steps in (USUAL, ANOTHER)]

    def slopes() -> Any:
        problem = problem_of(machine, *runs)
        return linearise(problem, centres(problem.parameters)).rows.slopes.parts

    mixed = slopes()
    monkeypatch.setattr(bent_steps, "MIXED", 0)
    for one, other in zip(mixed, slopes(), strict=True):
        np.testing.assert_allclose(one.by_theta, other.by_theta, rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose(one.by_own, other.by_own, rtol=1e-8, atol=1e-9)


def test_what_a_run_does_last_is_seen_and_not_carried_on() -> None:
    factors = [np.full((3, 1), x) for x in (0.5, 0.2, 0.1)]
    whole = Segment(4, 7, 0, None, None, np.ones((1, 1)), *factors)  # type: ignore[arg-type]
    ended = whole.forget([5])
    assert ended.gain.ravel().tolist() == [0.5, 0.0, 0.5] and whole.gain.ravel().tolist() == [0.5] * 3
    for own, kept in zip(ended.factors, factors, strict=True):
        np.testing.assert_array_equal(own, kept)
    m, stop, _ = ended.march_pushes([], np.zeros((0, 1)))
    assert m.shape == (3, 0, 1) and stop.shape == (3, 0, 1) and whole.forget([]) is whole


def test_the_runs_told_worst_stand_for_all() -> None:
    machine = MACHINES["linear"]
    runs = [recorded(machine, speeds(*steps), None) for steps in (USUAL, ANOTHER, USUAL[:2])]
    case = Case(machine, tuple(runs))
    told = state(case, machine, {})
    few = on_few_runs(told)
    assert len(few.case.recordings) == FEW == len(list_worst_runs(told))
    assert [r.name for r in few.case.recordings] == [runs[i].name for i in list_worst_runs(told)]
    assert on_few_runs(few) is few and few.values == told.values
