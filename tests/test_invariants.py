"""What every answer obeys: rules that take a finding away, and that bar it from being told as sure."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_diagnosis import CONCEALED, HELD_OUT, LADDERS, LINKS, plant, recorded

from network.analysis.comparison.compare import Comparison, compare
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.diagnose import diagnose
from network.analysis.diagnosis.findings.invariants import (
    doubt_fitted,
    doubt_unseen,
    find_worse_runs,
    is_one_thing,
    is_worse,
    list_doubts,
    list_strains,
)
from network.analysis.diagnosis.findings.result import Fits
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.strength import strength_in_errors


@cache
def found(power: str = "60 W") -> tuple[Hypothesis, Candidate]:
    source = CONCEALED["source"]["sources"]["pump"] | {"power": power}
    case = Case(plant(), tuple(recorded(plant(sources={"pump": source}), x, i) for i, x in enumerate(LADDERS)))
    heats = [c for c in candidates(case.machine, case.drivers) if c.kind.kind == "heat_source"]
    c = next(c for c in heats if c.places == ("column",))
    return fit_hypothesis(case, c.machine, (c,), c.own), c


def told(by: float, where: slice = slice(None), seed: int = 0) -> Comparison:
    """A run whose residuals are noise, larger somewhere."""
    run = recorded(plant(), LADDERS[0], seed)
    noise = np.random.default_rng(1).standard_normal(len(run.t)) * 0.05
    noise[where] *= by
    comparison = compare(plant(), [run])
    (one,) = comparison.recordings
    channels = {n: replace(c, measured=c.simulated + noise) for n, c in one.channels.items()}
    return replace(comparison, recordings=(replace(one, channels=channels),))


def test_a_run_is_worse_where_that_is_more_than_the_scatter_of_its_blocks() -> None:
    assert find_worse_runs(told(1.0), told(1.1)) == ["run 0"]
    assert find_worse_runs(told(1.0), told(1.01)) == []
    assert find_worse_runs(told(1.1), told(1.0)) == []
    short = slice(0, len(recorded(plant(), LADDERS[0], 0).t) // 12)
    assert find_worse_runs(told(1.0), told(1.5, short)) == []
    assert find_worse_runs(None, told(1.0)) == []


@pytest.mark.parametrize(("channels", "runs"), [(1, 1), (8, 1), (8, 10)])
def test_runs_told_as_well_are_called_worse_as_seldom_as_is_said(channels: int, runs: int) -> None:
    """Whatever is left moves all channels alike, and there may be many runs: two errors, once in 44."""
    rng, said, times = np.random.default_rng(3), 0, 400
    for _ in range(times):
        pairs = [(_tell_left(rng, channels), _tell_left(rng, channels)) for _ in range(runs)]
        said += any(is_worse(before, after, runs) for before, after in pairs)
    assert 0.001 * times < said < 0.05 * times


def _tell_left(rng: np.random.Generator, channels: int) -> Any:
    """What a heat that comes and goes leaves of them in turn, and noise."""
    common = np.repeat(rng.normal(0, 2.0, 48), 10)
    each = {f"T{i}": SimpleNamespace(in_noise=common + rng.standard_normal(480)) for i in range(channels)}
    rms = float(np.sqrt(np.mean([np.mean(c.in_noise**2) for c in each.values()])))
    return SimpleNamespace(channels=each, rmse_in_noise=rms)


@pytest.mark.parametrize(("seen", "unseen", "told_so"), [(1.0, 1.3, False), (1.0, 2.0, True), (2.0, 2.6, False)])
def test_what_leaves_much_of_the_runs_left_out_is_not_all_of_the_truth(
    seen: float, unseen: float, told_so: bool
) -> None:
    assert ("held out" in doubt_unseen(Fits(told(9.0), told(seen), told(9.0), told(unseen)))) is told_so
    assert doubt_unseen(Fits(told(9.0), told(1.0), None, None)) == ""


@pytest.mark.parametrize(("seen", "told_so"), [(1.0, False), (1.4, False), (1.7, True)])
def test_what_leaves_much_of_the_runs_fitted_is_not_all_of_the_truth_whatever_noise_was_found(
    seen: float, told_so: bool
) -> None:
    assert ("of what was fitted" in doubt_fitted(Fits(told(9.0), told(seen), None, None))) is told_so


def test_that_runs_left_out_are_told_much_worse_is_said_where_nothing_else_is() -> None:
    warm = {"links": {"flange": {**LINKS["flange"], "conductance": "400 W/K"}}}
    runs = [recorded(plant(), x, i) for i, x in enumerate(LADDERS)]
    d = diagnose(plant(), runs, [recorded(plant(**warm), HELD_OUT, 9)], seed=1)
    assert not d.findings and any("What was held out is left at" in note for note in d.notes)


def test_a_strength_is_told_in_its_standard_errors() -> None:
    h, c = found()
    assert strength_in_errors(h, c) > 10 and not list(list_strains(h, c))
    faint, c = found("0.4 W")
    assert strength_in_errors(faint, c) < SETTINGS.errors
    assert any("standard errors" in why for why in list_strains(faint, c))


def test_a_number_at_its_bound_and_a_bent_file_are_said() -> None:
    h, c = found()
    first = h.fit.problem.parameters[-1]
    assert first.path == c.own[0].path
    at = h.linearised
    bounded = replace(h, fit=replace(at, theta=np.append(at.theta[:-1], first.high)))
    assert any("bound" in why for why in list_strains(bounded, c))
    bent = replace(h, fit=replace(at, theta=np.append(at.theta[0] + 4 * at.problem.parameters[0].spread, at.theta[1:])))
    assert any("bent" in why for why in list_strains(bent, c))


@pytest.mark.parametrize(
    ("ended", "checked", "runs", "why"),
    [("", True, 2, ""), ("budget", True, 2, "not tested"), ("", False, 2, "not tested"), ("", True, 1, "recording")],
)
def test_what_is_not_tested_to_the_end_is_not_sure(ended: str, checked: bool, runs: int, why: str) -> None:
    h, c = found()
    selection, case = SimpleNamespace(is_checked=checked), SimpleNamespace(recordings=h.case.recordings[:runs])
    search = SimpleNamespace(ended=ended, selection=selection, case=case, best=h)
    doubts = list(list_doubts(search, c))  # type: ignore[arg-type]
    assert (len(doubts) == 1 and why in doubts[0]) if why else not doubts


def test_findings_at_one_place_may_be_one_thing() -> None:
    """A pile of chips is a mass and a heat: neither is told as sure where both are found there."""
    machine = plant()
    by_name = {(c.kind.kind, c.places): c for c in candidates(machine, machine.inputs)}
    mass, heat = by_name["hidden_mass", ("column",)], by_name["heat_source", ("column",)]
    above = candidates(mass.machine, machine.inputs)
    on_it = [c for c in above if c.kind.kind == "heat_source" and not {*c.places} & {*machine.nodes}]
    elsewhere = next(c for (kind, places), c in by_name.items() if kind == "heat_source" and places != ("column",))
    assert is_one_thing(mass, heat) and on_it and all(is_one_thing(c, mass) for c in on_it)
    assert not is_one_thing(mass, elsewhere)
