"""Sensors that are mixed up: found with the pair and the runs, from the numbers of the file; physics is no exchange."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from test_diagnosis import CONCEALED, HELD_OUT, LADDERS, LINKS, SENSORS, SOURCES, plant, recorded
from test_diagnosis_search import bars

from network.analysis.calibration.gauss_newton import linearise
from network.analysis.comparison.compare import compare
from network.analysis.diagnosis.diagnose import diagnose
from network.analysis.diagnosis.exchange import find_exchange as exchange_module
from network.analysis.diagnosis.exchange.exchange_fault import ExchangeFault
from network.analysis.diagnosis.exchange.exchange_scan import ExchangeScan
from network.analysis.diagnosis.exchange.exchanged_columns import exchange_columns
from network.analysis.diagnosis.exchange.find_exchange import find_exchange, find_exchange_on_lumps, list_pairs
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.time_budget import TimeBudget
from network.machine.machine import Machine
from network.recordings.recording import Recording
from network.report.words.catalogue_page import catalogue_page

PAIR = ("T_housing", "T_column")
GROWS = {"kind": "stretching", "length": "400 mm", "expansion": "1.1e-5 1/K", "direction": 1}
THIRD = (1000, 9000, 3000)


HELD_TIGHT = {
    "links": {"bearing": {**LINKS["bearing"], "between": ["spindle", "housing@0..0.15"]},
              "flange": {**LINKS["flange"], "conductance": "200 W/K ± 30 %",
                         "between": ["housing@0.8..1", "column@0..0.1"]}},
    "sources": {"friction": {**SOURCES["friction"], "torque": "30 N mm ± 30 %",
                             "into": {"spindle": 0.5, "housing@0..0.15": 0.5}}},
    "sensors": {"T_housing": {**SENSORS["T_housing"], "measures": "housing@0.3..0.4"},
                "T_column": {**SENSORS["T_column"], "measures": "column@0.2..0.3"}},
}  # fmt: skip
"""Bars that are hot at one end, with a lump each where they are given."""


def runs_of(truth: Machine) -> list[Recording]:
    return [recorded(truth, ladder, i) for i, ladder in enumerate((*LADDERS, THIRD))]


def exchanged(runs: list[Recording], *which: int, pair: tuple[str, str] = PAIR) -> list[Recording]:
    """The runs with two columns under each other's names in some of them, by default in all."""
    return [exchange_columns(r, pair) if i in which or not which else r for i, r in enumerate(runs)]


def fitted(runs: list[Recording], machine: Machine | None = None) -> Hypothesis:
    given = machine or plant()
    return fit_hypothesis(Case(given, tuple(runs)), given)


def told(h: Hypothesis) -> ExchangeFault | None:
    found = find_exchange(h, lambda _: 0.0)
    return found and found[0]


def test_two_that_are_exchanged_in_all_runs_are_found_and_are_the_machines() -> None:
    h = fitted(exchanged(runs_of(plant())))
    found = find_exchange(h, lambda _: 0.0)
    assert found is not None and found[0].channels == PAIR and found[0].runs == (True, True, True)
    assert found[1].chi < 1.1 < h.chi
    patched = plant().patched(found[0].patch, "test")
    assert compare(patched, exchanged(runs_of(plant()))[0]).rmse_in_noise < 1.2
    assert found[0].told == "T_housing and T_column are exchanged."


@pytest.mark.parametrize("which", [(1,), (0, 2)])
def test_exchanged_columns_of_some_runs_are_put_back_there(which: tuple[int, ...]) -> None:
    runs = exchanged(runs_of(plant()), *which)
    fault = told(fitted(runs))
    assert fault is not None and fault.channels == PAIR and not fault.patch
    assert fault.runs == tuple(i in which for i in range(3))
    right = fault.set_right(Case(plant(), tuple(runs))).recordings
    for put_back, true in zip(right, runs_of(plant()), strict=True):
        assert all(np.array_equal(put_back.columns[n].values, true.columns[n].values) for n in PAIR)
    assert f"in {' and '.join(f'run {i}' for i in which)}." in fault.told


def test_what_the_scan_leaves_is_what_a_fit_with_it_leaves() -> None:
    """About the true numbers J with the pair exchanged is that of a fit to the readings put back, and the other way."""
    true, wrong = fitted(runs_of(plant())), fitted(exchanged(runs_of(plant())))
    at_true = linearise(wrong.fit.problem, true.fit.theta)
    best = ExchangeScan(at_true, [PAIR]).best()[0]
    assert best.runs == (True, True, True) and best.cost == pytest.approx(true.fit.cost, rel=1e-3)
    assert ExchangeScan(true.linearised, [PAIR]).best()[0].runs == (False, False, False)


def test_two_that_coarse_lumps_hide_are_told_on_those_that_the_readings_put_back_take() -> None:
    """On coarse ones the two leave much, and lumps might tell all of it."""
    truth, given = bars(24).patched(HELD_TIGHT, "test"), bars().patched(HELD_TIGHT, "test")
    h = fitted(exchanged(runs_of(truth)), given)
    coarse = find_exchange(h, lambda _: 0.0)
    assert coarse is not None and coarse[1].chi > SETTINGS.doubtful
    assert find_exchange(h, lambda _: 0.0, is_refined=False) is None
    ranked = exchange_module._rank_pairs(h)
    late = replace(h, case=replace(h.case, budget=TimeBudget(9.0)))
    again = exchange_module._rank_pairs(late)  # finer lumps ask for the same
    assert ranked and [t.after.fit for t in again] == [t.after.fit for t in ranked]
    assert again[0].after.case.budget is late.case.budget
    found = find_exchange_on_lumps(h, h, lambda _: 0.0, 1)
    assert found is not None and found[0].channels == PAIR and found[0].is_machines
    assert found[1].chi < 1.1 < 10 < h.chi


def test_on_finer_lumps_they_are_put_back_in_the_runs_that_say_so() -> None:
    truth, given = bars(24).patched(HELD_TIGHT, "test"), bars().patched(HELD_TIGHT, "test")
    h = fitted(exchanged(runs_of(truth), 0, 2), given)
    found = find_exchange_on_lumps(h, h, lambda _: 0.0, 1)
    assert found is not None and found[0].runs == (True, False, True) and not found[0].is_machines
    assert found[1].chi < 1.1 and found[1].machine.lumps > h.machine.lumps


@pytest.mark.parametrize("more", [{}, CONCEALED["source"]])
def test_what_lumps_or_physics_leave_is_no_exchange_on_finer_ones(more: dict[str, Any]) -> None:
    truth, given = bars(24).patched(HELD_TIGHT, "test"), bars().patched(HELD_TIGHT, "test")
    h = fitted(runs_of(truth.patched(more, "test") if more else truth), given)
    assert h.chi > 5
    assert find_exchange_on_lumps(h, h, lambda _: 0.0, 1) is None


def test_two_probes_are_found_exchanged_too() -> None:
    axes = {axis: {"grows": {**GROWS, "of": part}} for axis, part in (("x", "housing"), ("z", "column"))}
    probes = {f"d{axis}": {"measures": f"tcp.{axis}", "noise": "0.3 um"} for axis in axes}
    machine = plant().patched({"tcp": axes, "sensors": probes}, "test")
    fault = told(fitted(exchanged(runs_of(machine), pair=("dx", "dz")), machine))
    assert fault is not None and fault.channels == ("dx", "dz")


def test_only_what_reads_the_same_quantity_is_paired() -> None:
    more = {"sensors": {"dz": {"measures": "tcp.z", "noise": "0.3 um"}, "T_twin": SENSORS["T_housing"]}}
    machine = plant().patched({"tcp": {"z": {"grows": {**GROWS, "of": "column"}}}, **more}, "test")
    pairs = {frozenset(pair) for pair in list_pairs(machine)}
    assert not any("dz" in pair for pair in pairs)
    assert frozenset({"T_twin", "T_housing"}) not in pairs and len(pairs) == 5


def test_two_that_hardly_differ_are_not_told() -> None:
    """A column that follows the housing as closely as the sensors resolve: exchanged or not, nothing tells."""
    tight = {"links": {"flange": {"kind": "conduction", "between": ["housing", "column"], "conductance": "5e5 W/K"}}}
    runs = exchanged(runs_of(plant(**tight)))
    assert told(fitted(runs, plant(**tight))) is None


@pytest.mark.parametrize("name", [*CONCEALED])
def test_what_is_missing_is_no_exchange(name: str) -> None:
    assert told(fitted(runs_of(plant(**CONCEALED[name])))) is None


@pytest.mark.parametrize("error", [2.0, -3.0])
def test_a_sensor_that_is_off_is_no_exchange(error: float) -> None:
    runs = [shift(r, "T_column", error) for r in runs_of(plant())]
    assert told(fitted(runs)) is None


def shift(run: Recording, name: str, by: float) -> Recording:
    column = run.columns[name]
    return replace(run, columns={**run.columns, name: replace(column, values=column.values + by)})


def test_a_diagnosis_names_them_and_the_machine_it_writes_tells_unseen_runs() -> None:
    runs, held = exchanged(runs_of(plant())), exchanged([recorded(plant(), HELD_OUT, 9)])
    d = diagnose(plant(), runs, held, seed=1)
    assert d.verdict == "sensor_fault" and [f.kind for f in d.findings] == ["sensor_swap"]
    first = d.findings[0]
    assert first.channels == PAIR and first.part == "whole" and first.confidence > 0.9
    assert first.sentence == "T_housing and T_column are exchanged."
    assert d.fits.holdout_before is not None and d.fits.holdout_after is not None
    assert d.fits.holdout_after.rmse_in_noise < 1.2 < 5 < d.fits.holdout_before.rmse_in_noise
    assert compare(d.after, held[0]).rmse_in_noise < 1.5
    assert not d.refuted


@pytest.mark.proof
def test_a_diagnosis_finds_what_else_is_missing_beside_them() -> None:
    truth = plant(**CONCEALED["source"])
    d = diagnose(plant(), exchanged(runs_of(truth)), exchanged([recorded(truth, HELD_OUT, 9)]), seed=1)
    assert [f.kind for f in d.findings] == ["sensor_swap", "heat_source"]
    assert d.findings[1].places == ("column",)
    assert d.fits.holdout_after is not None and d.fits.holdout_after.rmse_in_noise < 1.2


def test_what_a_run_that_was_not_seen_refutes_is_not_told() -> None:
    d = diagnose(plant(), exchanged(runs_of(plant())), [recorded(plant(), HELD_OUT, 9)], seed=1)
    assert not any(f.kind == "sensor_swap" for f in d.findings) and d.refuted
    assert d.fits.holdout_after is not None and d.fits.holdout_before is not None
    assert d.fits.holdout_after.rmse_in_noise <= 1.02 * d.fits.holdout_before.rmse_in_noise


@pytest.mark.parametrize(("kind", "is_looked_for"), [("sensor_swap", True), ("displacement_step", True),
                                                     ("clock_shift", True), ("pi_cooling", False)])  # fmt: skip
def test_the_catalogue_says_whether_a_diagnosis_looks_for_it(kind: str, is_looked_for: bool) -> None:
    assert ("A diagnosis does not look for it." in catalogue_page(kind)) is not is_looked_for
