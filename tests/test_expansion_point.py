"""A fit of runs whose rooms are far from where they were stated is the least of J with these rooms laid out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from fits import ANOTHER, USUAL, problem_of, recorded, speeds, two_blocks

from network.analysis.calibration import gauss_newton
from network.analysis.calibration.expansion_point import expand_anew, move_inputs, move_starts
from network.analysis.calibration.gauss_newton import Problem, chi_of, linearise, minimise
from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.multistart import _search_beside, draw_beginnings, has_seen_enough
from network.engine.response.parameters import centres
from network.recordings.inputs import constant
from network.recordings.recording import Recording

GLOW = {"glow": {"kind": "radiation", "between": ["body", "air"], "emissivity_area": "0.5 m^2"}}
WARM = constant("ambient", "degC", 32.0)


def misplaced(recording: Recording) -> Recording:
    """The room of a run at 32 °C told as 20 °C ± 6 K."""
    columns = {n: c for n, c in recording.columns.items() if n != "ambient"}
    return replace(recording, columns=columns, constants={"ambient": constant("ambient", "degC", 20.0, 6.0)})


@pytest.fixture(scope="module")
def problem() -> Problem:
    """Of a machine that lacks how its body glows, in a room that is 12 K off."""
    schedules = (speeds(*steps, every=60.0, ambient=WARM) for steps in (USUAL, ANOTHER))
    truth = two_blocks(links=GLOW)
    return problem_of(two_blocks(), *(misplaced(recorded(truth, s, seed)) for seed, s in enumerate(schedules)))


def laid_out(at: Linearised) -> float:
    """J about the constants that are most probable there."""
    return expand_anew(expand_anew(at)).cost


def test_laid_out_anew_a_run_of_a_straight_machine_is_told_alike(problem: Problem) -> None:
    at = linearise(problem, centres(problem.parameters))
    anew = expand_anew(at)
    assert anew.cost == pytest.approx(at.cost, rel=1e-6) and anew.problem.moves
    for told in (move_starts, move_inputs):
        for one, other in zip(told(at), told(anew), strict=True):
            assert one == pytest.approx(other, abs=1e-3)


def test_a_fit_is_the_least_with_its_rooms_laid_out(problem: Problem) -> None:
    at = minimise(problem)
    chi, std = chi_of(at), np.sqrt(np.diag(at.covariance)[: at.free])
    least = laid_out(at)
    for theta in beside(at.theta, chi * std):
        assert laid_out(linearise(at.problem, theta).temper(1.0, chi)) > least - chi**2


def beside(theta: np.ndarray, std: np.ndarray) -> Iterator[np.ndarray]:
    """One standard error up and down of every number by itself."""
    for j, s in enumerate(std):
        for by in (-s, s):
            yield theta + by * (np.arange(len(theta)) == j)


def test_fits_from_anywhere_end_alike(problem: Problem) -> None:
    drawn = draw_beginnings(problem.parameters, 0)
    costs = [minimise(problem, next(drawn)).cost for _ in range(4)]
    assert np.ptp(costs) < chi_of(minimise(problem)) ** 2


def test_a_further_search_ends_where_it_comes_to_a_minimum_that_is_known(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    known, drawn, steps = minimise(problem), next(draw_beginnings(problem.parameters, 0)), list[Linearised]()
    improve = gauss_newton._improve
    monkeypatch.setattr(gauss_newton, "_improve", lambda at, *rest: steps.append(at) or improve(at, *rest))
    (at,) = _search_beside(problem, drawn, [known])
    taken = len(steps)
    minimise(known.problem, drawn)
    assert taken < len(steps) - taken
    assert has_seen_enough([known, at, at, at])
