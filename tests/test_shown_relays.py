"""Relays that readings show: their levels and instants are read, and where they switch often they are found by that."""

from __future__ import annotations

import numpy as np
import pytest
from fits import recorded, speeds, two_blocks

from network.analysis.calibration.hysteresis_swing import find_levels
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.switching.followed_search import search_shown_relays
from network.analysis.diagnosis.switching.shown_relays import read_relays
from network.catalogue.declaration.discovery import kinds
from network.machine.machine import Machine
from network.recordings.inputs import constant

COOLER = {"kind": "thermostat_cooling", "into": {"body": 1}, "watches": "body", "set": "24 degC", "hysteresis": "0.9 K",
          "power": "320 W"}  # fmt: skip
NOISE, LEAST = 0.05, 0.4
T = np.arange(0.0, 4 * 3600, 20.0)


def noisy(x: np.ndarray, seed: int = 1) -> np.ndarray:
    return x + NOISE * np.random.default_rng(seed).standard_normal(len(x))


def saw_tooth(low: float, high: float, period: float = 600.0) -> np.ndarray:
    share = np.abs(((T / period) % 1) * 2 - 1)
    return low + (high - low) * share


def switched(plain: Machine, case: Case) -> list[Candidate]:
    return [c for c in candidates(plain, case.drivers) if c.switches]


def test_levels_are_where_readings_turn() -> None:
    found = find_levels([(T, noisy(saw_tooth(23.1, 24.9))), (T, noisy(saw_tooth(23.1, 24.9, 900.0), 2))], LEAST)
    assert found == pytest.approx((23.1, 24.9), abs=0.02)


@pytest.mark.parametrize(
    "x",
    [pytest.param(np.full(len(T), 22.0), id="noise alone"),
     pytest.param(22 + 8 * (1 - np.exp(-T / 4000)), id="warming up"),
     pytest.param(22 + 3 * np.sin(T / 2000) * (1 + np.sin(T / 700)), id="loads of many sizes"),
     pytest.param(saw_tooth(23, 25, 12000.0), id="hardly a turn")],
)  # fmt: skip
def test_what_turns_at_no_level_is_no_relay(x: np.ndarray) -> None:
    assert find_levels([(T, noisy(x))], LEAST) is None


@pytest.mark.parametrize("kind", ["thermostat_cooling", "thermostat_heating"])
def test_the_levels_of_a_thermostat_are_its_set_point_and_hysteresis(kind: str) -> None:
    entry = two_blocks(sources={"own": {**COOLER, "kind": kind}}).sources["own"]
    _, *levels = entry.levels()
    again = two_blocks(sources={"own": {**COOLER, "kind": kind, **entry.keep_between(min(levels), max(levels))}})
    assert again.sources["own"].levels()[1:] == pytest.approx(levels)


@pytest.mark.parametrize("every", [10.0, 20.0])
def test_a_cooler_that_switches_often_is_read_and_keeps_step(every: float) -> None:
    """Every 20 s are eight readings between two switchings: means of three do not reach the levels by far."""
    plain = two_blocks()
    truth = plain.patched({"sources": {"cooler": COOLER}})
    ladders = (((0.0, 6000), (1.1, 3000), (2.3, 8000)), ((0.0, 4000), (1.7, 8000), (3.0, 5000)))
    case = Case(plain, tuple(recorded(truth, speeds(*ladder, every=every), i) for i, ladder in enumerate(ladders)))
    null, relays = fit_hypothesis(case, plain), switched(plain, case)
    shown = read_relays(case, relays)
    assert {s.candidate.places for s in shown} == {("body",)} and len(shown) < len(relays)
    levels = {path.rpartition(".")[2]: value for path, value in shown[0].levels.items()}
    assert levels == pytest.approx({"set": 24, "hysteresis": 0.9}, abs=0.05)
    found = search_shown_relays(case, null, relays, jobs=1)
    assert found[0].found[-1].kind is kinds("sources")["thermostat_cooling"] and found[0].chi < 1.05 < 2 < null.chi
    told = {path.rpartition(".")[2]: value for path, value in found[0].own_values.items()}
    assert told == pytest.approx({"power": 320, "set": 24, "hysteresis": 0.9}, rel=0.02)
    switchings = [len(mode.t) for mode in shown[0].modes.values()]
    assert len(switchings) == 2 and min(switchings) > 20, "a draw would have to keep step over all of them"


def test_runs_that_never_get_there_are_left_out_and_the_others_tell_when_it_began() -> None:
    plain = two_blocks()
    truth, ladder = plain.patched({"sources": {"cooler": COOLER}}), ((0.0, 6000), (1.1, 3000), (2.3, 8000))
    cold = constant("ambient", "degC", 5.0)
    runs = (
        recorded(truth, speeds(*ladder, every=10.0), 1),
        recorded(truth, speeds((0.0, 0), every=10.0, ambient=cold), 2),
    )
    case = Case(plain, runs)
    shown = next(s for s in read_relays(case, switched(plain, case)) if s.candidate.key[0] == COOLER["kind"])
    first = float(np.argmax(runs[0].columns["T_body"].values > 24.9)) / len(runs[0].t)
    assert {*shown.modes} == {0} and shown.onset(runs) == pytest.approx(first, abs=0.01)
    assert search_shown_relays(case, fit_hypothesis(case, plain), switched(plain, case), jobs=1)[0].chi < 1.05


def test_levels_that_no_thermostat_may_have_are_none() -> None:
    """Readings that fall out to 850 °C now and then."""
    plain, out = two_blocks(), np.where(np.arange(1441) % 300 < 12, 830.0, 0.0)
    case = Case(plain, (recorded(plain, speeds((0.0, 6000)), 1, {"T_body": out}),))
    assert read_relays(case, switched(plain, case)) == []


def test_no_relay_is_read_where_nothing_switches() -> None:
    plain = two_blocks()
    case = Case(plain, (recorded(plain, speeds((0.0, 6000), (0.5, 0), (1, 6000), (1.5, 0), (2, 6000), (2.5, 0)), 1),))
    assert read_relays(case, switched(plain, case)) == []
    assert search_shown_relays(case, fit_hypothesis(case, plain), switched(plain, case), jobs=1) == []
