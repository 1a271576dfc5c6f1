"""Numbers that thermometers alone tell: what moves the tool centre point does not bend them, and shows about them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from build import machine
from test_diagnosis import LADDERS, LINKS, SENSORS, SOURCES, plant, recorded

from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.steps.thermometer_fit import (
    fit_thermometers,
    leaves_heat,
    score_by_thermometers,
)
from network.machine.machine import Machine
from network.recordings.columns import Column
from network.recordings.recording import Recording

IRON = {
    "density": "7200 kg/m^3",
    "specific_heat": "500 J/(kg K)",
    "conductivity": "47 W/(m K)",
    "expansion": "1.1e-5 1/K",
}
BARS = {
    "spindle": {"material": "iron", "length": "0.4 m", "area": "50 cm^2"},
    "housing": {"material": "iron", "length": "0.5 m", "area": "160 cm^2"},
    "column": {"material": "iron", "length": "0.9 m", "area": "280 cm^2"},
    "air": {"temperature": "ambient"},
}
GROWS = {"spindle grows": {"kind": "stretching", "of": "spindle", "length": "300 mm", "direction": 1}}
TILTS = {
    "kind": "tilt",
    "between": ["spindle", "column"],
    "distance": "0.3 m",
    "arm": "0.6 m",
    "length": "0.4 m",
    "direction": -1,
}


def tool(sources: dict[str, Any] | None = None, **more: Any) -> Machine:
    """Whose spindle grows, and whose column does not stand on the spindle."""
    sensors = {**SENSORS, "dz": {"measures": "tcp.z", "noise": "0.3 um"}}
    heat, moves = {**SOURCES, **(sources or {})}, {"z": {**GROWS, **more}}
    return machine(BARS, materials={"iron": IRON}, links=LINKS, sources=heat, sensors=sensors, tcp=moves)


def runs(truth: Machine) -> list[Recording]:
    made = [recorded(truth, ladder, i) for i, ladder in enumerate(LADDERS)]
    for r in made:
        r.columns["dz"] = Column("dz", "um", r.columns["dz"].values)
    return made


def fitted(truth: Machine) -> Hypothesis:
    return fit_hypothesis(Case(tool(), tuple(runs(truth))), tool())


def test_a_tilt_between_parts_that_do_not_touch_shows_about_numbers_that_it_does_not_bend() -> None:
    h = fitted(tool(tilt=TILTS))
    alone = fit_thermometers(h)
    assert alone is not None
    path, true = "links.flange.conductance", 40.0
    assert alone.values[path] == pytest.approx(true, rel=0.05)
    assert abs(h.values[path] / true - 1) > 3 * abs(alone.values[path] / true - 1)
    told = score_by_thermometers(h, candidates(h.machine, h.case.drivers, runs=h.case.runs), 1)
    assert told is not None and told.values == alone.values
    best = max(told.scores.values(), key=lambda s: s.gain).candidate
    assert best.kind.kind == "tilt" and {"spindle", "column"} <= {*best.key}
    (entry,) = (e for e in best.machine.tcp["z"].values() if e.kind == "tilt")
    assert entry.direction == TILTS["direction"]


def test_a_displacement_that_one_run_lacks_tells_nothing_of_it_in_the_others_either() -> None:
    first, second = runs(tool(tilt=TILTS))
    less = replace(first, columns={n: c for n, c in first.columns.items() if n != "dz"})
    alone = fit_thermometers(fit_hypothesis(Case(tool(), (less, second)), tool()))
    assert alone is not None and alone.values["links.flange.conductance"] == pytest.approx(40.0, rel=0.05)
    assert leaves_heat(alone) is False


def test_thermometers_alone_show_what_is_missing_of_the_heat() -> None:
    pump = {"pump": {"kind": "heat_source", "into": {"housing": 1}, "power": "90 W"}}
    alone = fit_thermometers(fitted(tool(sources=pump, tilt=TILTS)))
    assert alone is not None and leaves_heat(alone)


def test_thermometers_are_asked_only_where_a_displacement_leaves_much() -> None:
    h = fitted(tool())
    assert fit_thermometers(h) is None and score_by_thermometers(h, candidates(h.machine, h.case.drivers), 1) is None
    warm = fit_hypothesis(Case(plant(), (recorded(plant(), LADDERS[0], 0),)), plant())
    assert fit_thermometers(warm) is None
