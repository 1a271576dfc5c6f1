"""Latent heat as the honest rest: what a kind is worth beside it, and what it says of runs that were not seen."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from test_diagnosis import LADDERS, plant, recorded

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.few_runs import SEARCHED, on_all_runs, on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, fit_hypothesis
from network.analysis.diagnosis.latent_heat import latent_rest, locate
from network.analysis.diagnosis.latent_heat.lacking_heat import trace_lacking
from network.analysis.diagnosis.latent_heat.latent_rest import find_rest, share_of_rest
from network.analysis.diagnosis.latent_heat.locate import predict_unknown
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps import unseen_runs
from network.analysis.diagnosis.steps.backward_elimination import is_imitation
from network.analysis.diagnosis.steps.foretold_runs import ForetoldRuns
from network.analysis.diagnosis.steps.unseen_runs import Unseen, tell_unseen, unseen_misfit

PUMP = {"pump": {"kind": "heat_source", "into": {"column": 1}, "power": "60 W"}}
BURSTS = {
    f"burst {k}": {"kind": "timed_source", "into": {"column": 1}, "power": "150 W", "period": "10 h",
                   "duration": f"{5 + k} min", "phase": f"{20 + 23 * k} min"} for k in range(4)
}  # fmt: skip


def case_of(*ladders: tuple[float, ...], **concealed: Any) -> Case:
    return Case(plant(), tuple(recorded(plant(**concealed), ladder, i) for i, ladder in enumerate(ladders)))


def candidate_of(case: Case, kind: str, place: str) -> Candidate:
    return next(c for c in candidates(case.machine, case.drivers) if c.kind.kind == kind and c.places == (place,))


@cache
def fitted(truth: str, found: tuple[tuple[str, str], ...]) -> Hypothesis:
    case = case_of(*LADDERS, sources={"pump": PUMP, "bursts": BURSTS}[truth])
    told = fit_findings(case, case.machine, [candidate_of(case, *each) for each in found], {})
    assert told is not None
    return told


def test_the_kind_that_is_missing_is_worth_more_than_heat_of_any_course() -> None:
    """A constant 60 W: with it nothing is left, and heat of any course has to pay for every knot."""
    null, named = fitted("pump", ()), fitted("pump", (("heat_source", "column"),))
    alone, beside = find_rest(null), find_rest(named)
    assert alone.heat.gain > 100 and str(alone.heat.at) == "column"
    assert beside.evidence - alone.evidence > SETTINGS.alike
    assert share_of_rest(alone, beside) > 0.95


def test_the_numbers_are_refitted_together_with_the_heat() -> None:
    """Those of a fit without it are bent to the bursts; beside it they tell the recordings better."""
    null = fitted("bursts", ())
    first, best = find_rest(null, refit=False), find_rest(null)
    assert best.evidence > first.evidence and best.beside.linearised.theta is not null.linearised.theta
    assert np.abs(best.beside.shift).max() < np.abs(null.shift).max()


def test_all_that_a_part_lacks_is_told_where_what_was_found_is_a_part_of_it() -> None:
    """Of bursts that a steady heat stands for, with what this leaves, and at the numbers beside it; of what was found
    elsewhere, or between it and another part, nothing."""
    named = fitted("bursts", (("heat_source", "column"),))
    at = {u.at: u for u in locate.locate(named.linearised, named.machine)}
    whole = trace_lacking(named, column := at[Location(("column",))])
    assert whole is not None and whole.at == column.at and len(whole.t) == len(LADDERS)
    for t, heat in zip(whole.t, whole.heat, strict=True):
        truth = sum(150.0 * ((t >= (20 + 23 * k) * 60) & (t < (25 + 24 * k) * 60)) for k in range(4))
        assert np.corrcoef(truth, heat)[0, 1] > 0.7
    assert trace_lacking(named, at[Location(("spindle",))]) is None
    assert trace_lacking(fitted("bursts", ()), column) is None
    assert all(trace_lacking(named, u) is None for u in at.values() if u.at.kind == "link")


def test_a_second_kind_that_imitates_what_has_no_name_adds_nothing_beside_heat() -> None:
    """Bursts that no kind has: a loss with the cube of the speed lowers what is left, and heat without it as much."""
    one = fitted("bursts", (("heat_source", "column"),))
    two = fitted("bursts", (("heat_source", "column"), ("windage", "spindle")))
    assert two.evidence > one.evidence
    assert is_imitation(find_rest(two), one)
    right = fitted("pump", (("heat_source", "column"),))
    assert not is_imitation(find_rest(right), fitted("pump", ()))


def test_a_steady_heat_is_told_from_others() -> None:
    """From heat that something drives, too."""
    case = case_of(*LADDERS)
    told = [c for c in candidates(case.machine, case.drivers) if c.kind.kind == "heat_source"]
    assert {c.name for c in told if c.is_steady} == {
        f"heat_source ({name})" for name in ("spindle", "housing", "column")
    }
    assert len([c for c in told if not c.is_steady]) == 3
    others = (c for c in candidates(case.machine, case.drivers) if c.kind.kind != "heat_source")
    assert not any(c.is_steady for c in others)


def test_the_rest_may_be_surroundings_or_is_in_a_part(monkeypatch: pytest.MonkeyPatch) -> None:
    null, located = fitted("pump", ()), latent_rest.locate
    room = Location(("ambient",), is_held=True)

    def warm(*of: Any) -> Any:
        """As if the room explained most."""
        first, *others = located(*of)
        return (replace(first, at=room, gain=first.gain + 1e6), first, *others)

    monkeypatch.setattr(latent_rest, "locate", warm)
    assert find_rest(null, refit=False).heat.is_room
    told = find_rest(null, refit=False, in_rooms=False).heat
    assert not told.is_room and str(told.at) == "column"


def test_rivals_are_ranked_by_what_they_leave_to_heat_of_any_course(monkeypatch: pytest.MonkeyPatch) -> None:
    """The best of each kind and place; what is far behind without such heat keeps its place, and all do where nothing
    is left for such heat."""

    def rival(kind: str, evidence: float, chi: float = 2.0) -> Any:
        found = SimpleNamespace(kind=SimpleNamespace(kind=kind), places=("column",), channels=())
        return SimpleNamespace(found=(found,), evidence=evidence, weighed=evidence, beside=None, chi=chi)

    bent, right, again, last = rival("bent", 90.0), rival("right", 80.0), rival("bent", 85.0), rival("last", 10.0)
    beside = {"bent": 95.0, "right": 120.0, "last": 200.0}

    def weigh(h: Any, beside: float) -> Any:
        h.beside = h.weighed = beside
        return h

    monkeypatch.setattr(latent_rest, "RANKED", 2)
    monkeypatch.setattr(latent_rest, "replace", weigh)

    def rest_of(h: Any, in_rooms: bool) -> Any:
        assert not in_rooms, "surroundings of any course are one of the rivals"
        return SimpleNamespace(evidence=beside[h.found[-1].kind.kind])

    monkeypatch.setattr(latent_rest, "find_rest", rest_of)
    told = latent_rest.rank_beside_rest([bent, again, right, last])
    assert [h is x for h, x in zip(told, (right, bent, again, last), strict=True)] == [True] * 4
    bent.chi = SETTINGS.noise
    told = latent_rest.rank_beside_rest([bent, again, right, last])
    assert [h is x for h, x in zip(told, (bent, again, right, last), strict=True)] == [True] * 4


@pytest.mark.parametrize(("is_known", "size"), [(True, 12.0), (False, 12.0), (False, 0.1)])
def test_runs_told_by_others_are_as_probable_as_gaussians_have_them(
    is_known: bool, size: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """ln N(r; 0, I + Sᵀ V S + Θᵀ Σ Θ + Gᵀ K G) without G, then with it, r what is left at the numbers of the others and
    the most probable constants S of the runs; what these are strained by counts beyond chance alone."""
    draw = np.random.default_rng(5)
    own, answers, spread, knots = draw.standard_normal((2, 9)), draw.standard_normal((3, 9)), np.array([0.5, 2.0]), 3
    numbers, raw = draw.standard_normal((2, 9)), draw.standard_normal(9) * size
    root = draw.standard_normal((2, 2)) * (1e-6 if is_known else 1.0)
    known, held = own @ own.T + np.diag(spread**-2.0), np.array([4.0, 7.0])
    eta = np.linalg.solve(known, own @ raw)
    apart = np.eye(9) - own.T @ np.linalg.solve(known, own)
    t = np.linspace(0.0, 1800.0, knots)
    seen: Any = SimpleNamespace(
        slopes=np.vstack([numbers, own]), free=2, left=raw - eta @ own, eta=eta,
        reduced=(numbers @ apart @ numbers.T + np.diag(held**-2.0),),
        problem=SimpleNamespace(data=(None,), prior=(np.zeros(4), np.array([*held, *spread]))),
    )  # fmt: skip
    told = ForetoldRuns(seen, np.linalg.inv(root @ root.T))
    monkeypatch.setattr(locate, "heat_knots", lambda data, step: t)
    monkeypatch.setattr(locate, "_place", lambda fit, at, knots: SimpleNamespace(answers=[answers]))
    heat = UnknownHeat(Location(("a",)), 1.0, 1.0, 1.0, (t,), (t,), (t,), size=1.7, ell=900.0)
    K = 1.7**2 * np.exp(-np.abs(t[:, None] - t[None]) / 900.0)
    bare = np.eye(9) + own.T @ np.diag(spread**2) @ own
    without = bare + numbers.T @ root @ root.T @ numbers
    densities = [multivariate_normal(np.zeros(9), c).logpdf(raw) for c in (without + answers.T @ K @ answers, without)]
    more = predict_unknown(seen, heat, told.precision, told.left)
    assert more == pytest.approx(densities[0] - densities[1])
    constant = multivariate_normal(np.zeros(9), bare).logpdf(np.zeros(9))
    step = np.linalg.solve(told.precision, [*(numbers @ seen.left), 0.0, 0.0])
    strain = float(np.sum(((eta + step[2:]) / spread) ** 2))
    beyond_chance = max(strain - 2, 0.0) - strain
    assert told.density == pytest.approx(densities[1] - constant - beyond_chance / 2, rel=1e-4)


def test_what_runs_left_out_say_counts_heat_of_any_course_where_it_helps() -> None:
    null, named = fitted("pump", ()), fitted("pump", (("heat_source", "column"),))
    bare, beside = tell_unseen(null, with_rest=False), tell_unseen(null)
    assert beside.density > bare.density and beside.chi == bare.chi == unseen_misfit(null)
    assert tell_unseen(named).density > beside.density


def test_what_acts_all_along_a_single_run_is_told_at_its_end_by_its_beginning() -> None:
    """Its own number hardly moves: the beginning knows it."""
    case = case_of(LADDERS[0], sources=PUMP)
    null = fit_hypothesis(case, case.machine)
    found = fit_findings(case, case.machine, [candidate_of(case, "heat_source", "column")], null.values)
    assert found is not None
    before, after = tell_unseen(null), tell_unseen(found)
    assert after.chi < 2 < 50 < before.chi and after.density > before.density


def test_a_run_that_breaks_down_is_told_by_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(*_: object) -> None:
        raise np.linalg.LinAlgError

    monkeypatch.setattr(unseen_runs, "linearise", breaks)
    told = tell_unseen(fitted("pump", ()))
    assert told.chi == np.inf and told.density == -np.inf


def test_a_search_over_many_runs_stands_on_those_told_worst_and_is_tested_on_all() -> None:
    """The source is on in two runs of five; what is found there is fitted to all of them."""
    whole, bare = (case_of(*(LADDERS * 3)[:5], sources=s) for s in (PUMP, {}))
    case = Case(plant(), (*bare.recordings[:3], *whole.recordings[3:]))
    null = fit_hypothesis(case, case.machine)
    few = on_few_runs(null, SEARCHED)
    assert len(few.case.recordings) == SEARCHED < len(case.recordings)
    assert on_all_runs(null, few) is null
    found = fit_findings(few.case, case.machine, [candidate_of(case, "heat_source", "column")], few.values)
    assert found is not None
    told = on_all_runs(null, found)
    assert told.found and len(told.case.recordings) == 5
    direct = fit_findings(case, case.machine, told.found, null.values)
    assert direct is not None and told.own_values == pytest.approx(direct.own_values, rel=1e-2)


def test_a_run_that_nothing_tells_does_not_outweigh_those_that_are_told() -> None:
    """Readings of the second run are off by 8 σ, for a sensor came loose: heat of any course beside nothing tells them
    better there, and what was found tells the others."""
    found = Unseen.together([Unseen(9.0 * 100, 100, -450.0), Unseen(64.0 * 100, 100, -6000.0)])
    nothing = Unseen.together([Unseen(25.0 * 100, 100, -1250.0), Unseen(100.0 * 100, 100, -3000.0)])
    assert nothing.density > found.density
    assert found.gain_over(nothing) == pytest.approx(800 / 9 - 3000 / 64)
    assert found.gain_over(nothing) == -nothing.gain_over(found)
    assert Unseen(50.0, 100, -20.0).gain_over(Unseen(90.0, 100, -40.0)) == 20.0
    assert Unseen.broken().gain_over(found) == -np.inf and found.gain_over(Unseen.broken()) == np.inf
    assert Unseen.broken().gain_over(Unseen.broken()) == 0.0
