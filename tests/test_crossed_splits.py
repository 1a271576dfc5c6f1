"""Chosen on one half of the recordings, tested on the other, crossed: p-values of linear problems, and of runs."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import kstest
from test_diagnosis import CONCEALED, HELD_OUT, LADDERS, plant, recorded

from network.analysis.diagnosis.diagnose import diagnose
from network.analysis.diagnosis.findings.invariants import list_doubts
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.lumps.lump_shapes import shapes_of_lumping
from network.analysis.diagnosis.screening.crossed_splits import CrossedSplits, UnseenTest, halve
from network.analysis.diagnosis.screening.refitted_half import RefittedHalf, effective_samples
from network.analysis.diagnosis.screening.screening import screen_candidates

ROWS, NUMBERS, SHAPES, MOST = 120, 5, 8, 30.0
SPREAD = np.array([0.02, 0.3, 1.0, 10.0, 1e4])


def courses(rng: np.random.Generator, count: int, rows: int = ROWS) -> Any:
    """Smooth courses over two runs: waves of any length and phase."""
    angle = rng.uniform(0.5, 12.0, (count, 1)) * np.linspace(0, np.pi, rows)
    return np.hstack([np.sin(angle + rng.uniform(0, np.pi, (count, 1))) for _ in range(2)])


def draw(
    rng: np.random.Generator, effect: float = 0.0, rho: float = 0.0, flips: bool = False, is_signed: bool = True
) -> UnseenTest:
    """The test of a linear problem with two runs whose numbers are drawn from their priors; effect: σ of the third
    shape that is concealed, of the other sign in the second run where it flips."""
    S, D = courses(rng, NUMBERS), courses(rng, SHAPES)
    noise = rng.standard_normal((2, ROWS))
    for i in range(1, ROWS):
        noise[:, i] = rho * noise[:, i - 1] + np.sqrt(1 - rho**2) * noise[:, i]
    rows, series = np.arange(2 * ROWS) < ROWS, np.repeat([0, 1], ROWS)
    concealed = effect * D[2] * np.where(rows | (not flips), 1.0, -1.0)
    left = (SPREAD * rng.standard_normal(NUMBERS)) @ S + noise.ravel() + concealed
    strain = np.zeros(NUMBERS)
    a, b, whole = (RefittedHalf.of(of, S, left, strain, SPREAD, series) for of in (rows, ~rows, rows | ~rows))
    splits = CrossedSplits((a, b), whole)
    kinds = [SimpleNamespace(kind=SimpleNamespace(kind=f"k{i}"), places=("bed",), channels=(), is_signed=is_signed)
             for i in range(SHAPES)]  # fmt: skip
    splits.look(kinds[:4], D[:4], MOST)  # type: ignore[arg-type]
    splits.look(kinds[4:], D[4:], MOST)  # type: ignore[arg-type]
    told = splits.test()
    assert told is not None
    return told


@pytest.mark.parametrize("is_signed", [True, pytest.param(False, marks=pytest.mark.proof)])
def test_where_nothing_is_missing_p_values_of_each_half_are_uniform_and_crossed_ones_no_smaller(
    is_signed: bool,
) -> None:
    rng = np.random.default_rng(1)
    told = [draw(rng, is_signed=is_signed) for _ in range(600)]
    for k in (0, 1):
        assert kstest([t.p_values[k] for t in told], "uniform").pvalue > 0.01
    crossed = np.array([t.p_value for t in told])
    assert all(np.mean(crossed <= x) <= x + 2 * np.sqrt(x * (1 - x) / len(told)) for x in (0.01, 0.05, 0.1, 0.2, 0.5))


def test_noise_that_lasts_counts_as_fewer_readings() -> None:
    x = np.random.default_rng(2).standard_normal((20, 2000))
    assert effective_samples([*x]) == pytest.approx(x.size, rel=0.1)
    for i in range(1, x.shape[1]):
        x[:, i] = 0.6 * x[:, i - 1] + 0.8 * x[:, i]
    assert effective_samples([*x]) == pytest.approx(x.size * (1 - 0.6) / (1 + 0.6), rel=0.15)
    assert effective_samples([np.zeros(5), np.ones(0)]) == 5
    rng = np.random.default_rng(3)
    told = np.array([draw(rng, rho=0.5).p_values for _ in range(300)]).ravel()
    assert np.mean(told <= 0.05) < 0.1 and np.mean(told <= 0.01) < 0.03


def test_what_is_in_both_halves_is_chosen_by_both_and_holds() -> None:
    told = [draw(np.random.default_rng([4, i]), effect=1.5) for i in range(20)]
    assert sum(t.chosen[0] == ("k2", "bed") and t.halves_agree and t.rejects and not t.doubt for t in told) > 16


def test_what_acts_the_other_way_in_the_other_half_does_not_hold() -> None:
    told = [draw(np.random.default_rng([4, i]), effect=1.5, flips=True) for i in range(20)]
    same = [t for t in told if t.chosen == (("k2", "bed"),) * 2]
    assert len(same) > 5 and all(t.p_value == 1.0 and "does not show in the other (p = 1)" in t.doubt for t in same)


def test_a_half_is_refitted_to_its_own_rows_alone() -> None:
    """Against the same by a dense inverse; numbers that it does not tell do not count."""
    rng = np.random.default_rng(5)
    S, rows = courses(rng, NUMBERS), np.arange(2 * ROWS) < ROWS
    S[1, :ROWS] = 0.0
    left, strain, series = rng.standard_normal(2 * ROWS), rng.standard_normal(NUMBERS), np.zeros(2 * ROWS)
    half = RefittedHalf.of(rows, S, left, strain, SPREAD, series)
    own, V = S[:, :ROWS], np.diag(SPREAD**2)
    M = np.linalg.inv(np.eye(ROWS) + own.T @ V @ own)
    step = np.linalg.solve(own @ own.T + np.linalg.inv(V), own @ left[:ROWS] + strain / SPREAD)
    np.testing.assert_allclose(half.left, left[:ROWS] - step @ own, atol=1e-6)
    assert half.taken == pytest.approx(ROWS - np.trace(M), rel=1e-5)
    d = courses(rng, 2)
    g, kappa = half.score(d)
    np.testing.assert_allclose(g, d[:, :ROWS] @ half.left)
    np.testing.assert_allclose(kappa, np.einsum("ij,jk,ik->i", d[:, :ROWS], M, d[:, :ROWS]), rtol=1e-4)


def null_of(*ladders: Any) -> Any:
    """The machine without a source fitted to runs that have it."""
    source = {"pump": CONCEALED["source"]["sources"]["pump"]}
    case = Case(plant(), tuple(recorded(plant(sources=source), x, i) for i, x in enumerate(ladders)))
    return fit_hypothesis(case, case.machine)


def test_both_halves_of_recordings_choose_what_is_concealed() -> None:
    told = screen_candidates(null_of(*LADDERS), 0, 1).unseen
    assert told is not None and told.halves_agree and told.rejects and not told.of_one
    assert "column" in told.chosen[0]
    assert told.summary() == {"p_unseen": told.p_value, "halves_agree": True}


def test_of_one_recording_the_cells_are_parted_and_it_stays_a_part() -> None:
    h = null_of(LADDERS[0])
    splits = halve(h.linearised, shapes_of_lumping(h, h))
    assert splits is not None and splits.of_one
    a, b = (half.rows for half in splits.halves)
    assert (a ^ b).all() and abs(int(a.sum()) - int(b.sum())) <= len(h.fit.problem.data[0].run.channels)
    told = screen_candidates(h, 0, 1).unseen
    search = SimpleNamespace(ended="", selection=SimpleNamespace(is_checked=True), case=h.case, best=h)
    c = SimpleNamespace(own=(), section="sources")
    assert told is not None and not told.doubt
    assert any("one recording" in why for why in list_doubts(search, c, told))  # type: ignore[arg-type]


def test_what_does_not_show_in_the_other_half_is_doubted() -> None:
    h = null_of(*LADDERS)
    search = SimpleNamespace(ended="", selection=SimpleNamespace(is_checked=True), case=h.case, best=h)
    c = SimpleNamespace(own=(), section="sources")
    before = [*list_doubts(search, c)]  # type: ignore[arg-type]
    seen, unseen = (UnseenTest((p, 0.004), (("tilt",), ("tilt",))) for p in (0.005, 0.007))
    assert [*list_doubts(search, c, seen)] == before  # type: ignore[arg-type]
    assert [*list_doubts(search, c, unseen)] == [*before, unseen.doubt]  # type: ignore[arg-type]
    assert unseen.doubt == "what one half of the recordings picks out does not show in the other (p = 0.011)"


def test_what_is_held_out_has_no_part_in_it() -> None:
    source = {"pump": CONCEALED["source"]["sources"]["pump"]}
    runs = [recorded(plant(sources=source), x, i) for i, x in enumerate(LADDERS)]
    other = recorded(plant(), HELD_OUT, 9)
    alone, beside = diagnose(plant(), runs, seed=1), diagnose(plant(), runs, [other], seed=1)
    told = alone.findings[0].summary()["evidence"]
    assert told["p_unseen"] < 0.01 and told["halves_agree"]
    assert not beside.findings or beside.findings[0].unseen == alone.findings[0].unseen
