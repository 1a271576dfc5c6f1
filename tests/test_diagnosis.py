"""Diagnosis on small machines whose recordings lack or hold one effect, made with the simulator itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from build import RPM, machine

from network.analysis.diagnosis.candidates.candidates import candidates, kinds
from network.analysis.diagnosis.diagnose import diagnose
from network.analysis.diagnosis.findings.result import Diagnosis
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.search_record import Search
from network.analysis.diagnosis.settings import SETTINGS, Settings
from network.analysis.diagnosis.time_budget import TimeBudget
from network.engine.simulation import simulate
from network.machine.machine import Machine
from network.recordings.columns import Column
from network.recordings.inputs import Schedule, Start, hold, linear
from network.recordings.recording import Recording

NODES = {
    "spindle": {"heat_capacity": "8 kJ/K"}, "housing": {"heat_capacity": "30 kJ/K"},
    "column": {"heat_capacity": "90 kJ/K"}, "air": {"temperature": "ambient"},
}  # fmt: skip
LINKS = {
    "bearing": {"kind": "conduction", "between": ["spindle", "housing"], "conductance": "30 W/K ± 30 %"},
    "flange": {"kind": "conduction", "between": ["housing", "column"], "conductance": "40 W/K ± 30 %"},
    "housing skin": {"kind": "convection", "between": ["housing", "air"], "conductance": "6 W/K ± 30 %"},
    "column skin": {"kind": "convection", "between": ["column", "air"], "conductance": "12 W/K ± 30 %"},
}
SOURCES = {
    "friction": {"kind": "bearing_friction", "into": {"spindle": 0.5, "housing": 0.5}, "torque": "500 N mm ± 30 %"}
}
SENSORS = {f"T_{n}": {"measures": n, "noise": "0.05 K"} for n in ("spindle", "housing", "column")}
MOTOR = {"kind": "motor_loss", "into": {"column": 1}, "iron": "150 W", "reference_speed": "8000 rpm"}
MINUTES = 150


def plant(**more: Any) -> Machine:
    sections = {"links": LINKS, "sources": SOURCES, "sensors": SENSORS}
    return machine(NODES, **{s: {**sections[s], **more.get(s, {})} for s in sections})


def recorded(truth: Machine, speeds: tuple[float, ...], seed: int, start: float = 20.0) -> Recording:
    """One run of a machine: equal times at some speeds [rpm], with its sensors' noise."""
    t = np.arange(0, MINUTES * 60.0 + 1, 20.0)
    steps = np.linspace(0, t[-1], len(speeds) + 1)[:-1] // 20 * 20
    ambient = 20 + np.sin(2 * np.pi * t / 9000)
    signals = [hold("speed", "rpm", steps, np.array(speeds) * RPM), linear("ambient", "degC", t, ambient)]
    schedule = Schedule("made", "made", t, {s.name: s for s in signals}, Start(others=start))
    run = simulate(truth, schedule, noise_seed=seed)
    columns = {n: Column(n, "degC", v) for n, v in run.sensors.items()}
    columns |= {n: Column(n, schedule.signals[n].unit, v) for n, v in run.inputs.items()}
    return Recording(f"run {seed}", f"run{seed}.csv", t, columns)


LADDERS = ((0, 3000, 6000, 2000), (5000, 0, 8000, 4000))
HELD_OUT = (2000, 7000, 0)


@cache
def found(name: str) -> Diagnosis:
    truth = plant(**CONCEALED[name])
    runs = [recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)]
    return diagnose(plant(), runs, [recorded(truth, HELD_OUT, 9)], seed=1)


CONCEALED: dict[str, dict[str, Any]] = {
    "nothing": {"links": {"flange": {**LINKS["flange"], "conductance": "52 W/K"}}},
    "source": {"sources": {"pump": {"kind": "heat_source", "into": {"column": 1}, "power": "60 W"}}},
    "motor": {"sources": {"motor": {**MOTOR, "copper": "60 W"}}},
    "eddies": {"sources": {"motor": {**MOTOR, "copper": "0 W"}}},
    "fan": {"links": {"housing skin": {"kind": "forced_convection", "between": ["housing", "air"],
                                       "conductance": "6 W/K", "gain": 5, "reference_speed": "8000 rpm"}}},
    "slow": {"sensors": {"T_housing": {**SENSORS["T_housing"], "effects": [{"kind": "sensor_lag", "lag": "400 s"}]}}},
}  # fmt: skip


def test_nothing_missing_is_said_so() -> None:
    d = found("nothing")
    assert d.verdict == "parameters_only" and not d.findings
    assert d.fits.holdout_after is not None and d.fits.holdout_after.rmse_in_noise < 1.1


@pytest.mark.parametrize(
    ("name", "kind", "where", "verdict"),
    [
        ("source", "heat_source", "column", "missing_physics"),
        ("motor", "motor_loss", "column", "missing_physics"),
        ("eddies", "motor_loss", "column", "missing_physics"),
        ("fan", "forced_convection", "housing", "missing_physics"),
        ("slow", "sensor_lag", "T_housing", "sensor_fault"),
    ],
)
def test_the_concealed_effect_is_named_at_its_place(name: str, kind: str, where: str, verdict: str) -> None:
    d = found(name)
    assert d.verdict == verdict
    assert d.findings[0].kind == kind and where in (*d.findings[0].places, *d.findings[0].channels)
    assert d.findings[0].gain > d.findings[0].threshold
    assert d.findings[0].part == "whole" and d.explained > 0.9
    assert d.findings[0].members[0].startswith(f"{kind}@")
    held = d.fits.holdout_before, d.fits.holdout_after
    assert held[0] is not None and held[1] is not None
    assert held[1].rmse_in_noise < 1.4 < held[0].rmse_in_noise  # a tenth of the run tells how it began


def diagnosed_without(section: str, name: str, **truth: Any) -> Diagnosis:
    """By a machine that lacks an entry."""
    made = plant(**truth)
    runs = [recorded(made, ladder, i) for i, ladder in enumerate(LADDERS)]
    whole = {"links": LINKS, "sources": SOURCES, "sensors": SENSORS}
    less = {**whole, section: {n: body for n, body in whole[section].items() if n != name}}
    return diagnose(machine(NODES, **less), runs, seed=1)


def test_a_bearing_that_is_missing_heats_both_of_its_rings() -> None:
    (f,) = diagnosed_without("sources", "friction").findings
    assert (f.kind, f.places, f.part) == ("bearing_friction", ("spindle", "housing"), "whole")
    assert f.parameters["torque"].value == pytest.approx(0.5, rel=0.02)


@pytest.mark.proof
def test_a_film_that_is_missing_is_told_by_its_law_alone() -> None:
    (f,) = diagnosed_without("links", "housing skin", **CONCEALED["fan"]).findings
    assert (f.kind, f.places) == ("forced_convection", ("housing", "air"))
    assert {"conductance", "gain"} <= {*f.parameters}


def test_a_sensor_that_is_far_off_strains_the_fit() -> None:
    runs = [recorded(plant(), ladder, i) for i, ladder in enumerate(LADDERS)]
    true = fit_hypothesis(case := Case(plant(), tuple(runs)), case.machine)
    off = [replace(r, columns={**r.columns, "T_column": shifted(r.columns["T_column"], 0.8)}) for r in runs]
    wrong = fit_hypothesis(Case(plant(), tuple(off)), case.machine)
    assert true.offset_pull < 1.5 < SETTINGS.strained < wrong.offset_pull


def shifted(column: Column, by: float) -> Column:
    return replace(column, values=column.values + by)


def test_what_tells_recordings_worse_when_simulated_is_no_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    harsh = replace(SETTINGS, worse=0.01, paired=-1e9)
    monkeypatch.setattr("network.analysis.diagnosis.findings.invariants.SETTINGS", harsh)
    d = found.__wrapped__("source")
    assert [told.startswith("with what was found run") for told in d.refuted] == [True] * 3
    assert d.verdict == "unexplained" and [f.kind for f in d.findings] == ["unknown"]
    assert d.after.to_plain() == d.before.to_plain()
    assert d.fits.train_after.rmse_in_noise == d.fits.train_before.rmse_in_noise


def test_what_time_cuts_off_is_told_as_far_as_it_came() -> None:
    truth = plant(**CONCEALED["source"])
    runs = [recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)]
    d = diagnose(plant(), runs, seed=1, seconds=1e-3)
    assert d.ended == "budget" and d.summary()["budget_reached"] and not any(f.part == "whole" for f in d.findings)
    assert [f.kind for f in d.findings] == ["unknown"] and not d.advice


def test_what_was_found_until_the_time_was_up_is_not_told_as_not_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def cut(states: Iterator[Search], budget: TimeBudget) -> Search:
        return replace(next(now for now in states if now.best.found), ended="budget")

    monkeypatch.setattr("network.analysis.diagnosis.diagnose.last_of", cut)
    d = found.__wrapped__("source")
    (rest,) = d.unsearched
    assert [f.kind for f in d.findings] == ["heat_source"] and {r.kind for r in d.tried} >= {"heat_source"}
    assert "windage" in rest.kinds and not {*rest.kinds} & {r.kind for r in d.tried}


def test_every_number_that_steers_says_where_it_comes_from() -> None:
    told = found("source").summary()["settings"]
    origins = {each["origin"].partition(":")[0] for each in told.values()}
    assert origins <= {"convention", "prior", "budget", "derived", "bench"} and len(told) <= 30
    assert all(each["unit"] and each["meaning"] and each["group"] for each in Settings().summary().values())


def test_one_run_tells_a_part_at_most() -> None:
    truth = plant(**CONCEALED["source"])
    (told,) = diagnose(plant(), recorded(truth, LADDERS[0], 0), seed=1).findings
    assert (told.kind, told.part) == ("heat_source", "part") and told.confidence <= 0.5 and told.doubts


def test_strength_is_recovered_within_its_uncertainty() -> None:
    power = found("source").findings[0].parameters["power"]
    assert abs(power.value - 60) < 4 * power.std
    lag = found("slow").findings[0].parameters["lag"]
    assert abs(lag.value - 400) < 4 * lag.std


def test_the_same_seed_gives_the_same_diagnosis() -> None:
    again = found.__wrapped__("source")
    first, second = (d.summary() | {"seconds": 0} for d in (found("source"), again))
    assert first == second


def test_every_kind_with_a_strength_is_proposed_from_its_declaration() -> None:
    proposed = {c.kind for c in candidates(plant(), ("speed", "ambient", "feed"))}
    assert proposed <= set(kinds()) and len(proposed) > 10
    assert all(c.own and c.own[0].path for c in candidates(plant(), ("speed", "ambient")))
