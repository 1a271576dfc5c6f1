"""What to run next, and what recordings could not have shown, on machines of two and three parts."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import build as small
import numpy as np
import pytest
from build import RPM
from diagnosed import diagnosed
from fits import recorded, speeds, two_blocks

from network.analysis.calibration.gauss_newton import minimise
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.experiments.advice import experiments, in_doubt, revealing, separating
from network.analysis.diagnosis.experiments.experiment import CLEAR, Experiment
from network.analysis.diagnosis.experiments.programs import HOLDS, driver, programs
from network.analysis.diagnosis.experiments.separation import Pair, outcome
from network.analysis.diagnosis.findings.isolability import isolability, name_candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.screening.screen import Score, screen
from network.analysis.diagnosis.steps.ranking import distinct, shares
from network.recordings.columns import Column
from network.recordings.inputs import constant, hold
from network.recordings.recording import Recording
from network.report.words.diagnosis_words import advice_words

PUMP = {"sources": {"pump": {"kind": "heat_source", "into": {"body": 1}, "power": "20 W"}}}
STEADY = speeds((0.0, 6000), (3.8, 5800))


def proposed(case: Case, kind: str, *places: str) -> list[Candidate]:
    return [c for c in candidates(case.machine, case.drivers) if c.kind.kind == kind and {*places} <= {*c.places}]


def supposed(case: Case, kind: str, *places: str) -> Hypothesis:
    """The better of the proposals of a kind at some places and, if it can be, no others, fitted."""
    found = proposed(case, kind, *places)
    fewest = min(len(c.places) for c in found)
    fitted = [fit_hypothesis(case, c.machine, (c,), c.own) for c in found if len(c.places) == fewest]
    return max(fitted, key=lambda h: h.evidence)


@cache
def steady() -> Case:
    """A pump left out of the file, on a recording at hardly more than one speed."""
    return Case(two_blocks(), (recorded(two_blocks().patched(PUMP), STEADY, 1),))


@cache
def pair() -> Pair:
    """A constant heat and a friction that nearly one speed cannot tell apart."""
    return Pair(supposed(steady(), "heat_source", "body"), supposed(steady(), "bearing_friction", "body"))


def search_of(*ranked: Hypothesis, best: Hypothesis | None = None) -> Any:
    return SimpleNamespace(best=best or ranked[0], steps=(ranked,) if ranked else (), null=None)


def library(p: Pair) -> list[Any]:
    return programs([p.holds.machine, p.rival.machine], p.holds.case.recordings)


# -- separation -----------------------------------------------------------------------------------------------------
def cost_with(h: Hypothesis, run: Recording) -> float:
    case = replace(h.case, recordings=(*h.case.recordings, run))
    return minimise(case.problem(h.machine, h.fit.problem.parameters), h.fit.theta).cost - h.fit.cost


@pytest.mark.parametrize("i", [0, 2])
def test_separation_is_what_a_refit_to_the_run_itself_costs_the_rival(i: int) -> None:
    """A run of the machine that holds, without noise: how much J rises when each explanation is fitted to it too."""
    program = library(pair())[i]
    truth = pair().holds.numbers
    t = np.arange(0.0, 3600 * program.hours + 5, program.interval)
    run = recorded(truth, small.schedule(t, *program.signals.values()), None)
    rise = cost_with(pair().rival, run) - cost_with(pair().holds, run)
    sigma = outcome(pair(), program).sigma()
    assert sigma > CLEAR
    assert sigma**2 == pytest.approx(rise, rel=0.1)


def test_an_explanation_is_not_told_from_itself() -> None:
    same = Pair(pair().holds, pair().holds)
    assert outcome(same, library(same)[0]).sigma() == 0


def test_misfit_lessens_what_a_program_promises() -> None:
    program = library(pair())[0]
    worse = replace(pair().rival)
    worse.__dict__["chi"] = 2.0
    assert outcome(Pair(pair().holds, worse), program).sigma() == pytest.approx(outcome(pair(), program).sigma() / 2)


# -- choice ---------------------------------------------------------------------------------------------------------
def test_the_pair_in_doubt_is_told_apart_by_the_fastest_program() -> None:
    assert abs(pair().holds.evidence - pair().rival.evidence) < 3
    search = search_of(pair().holds, pair().rival, supposed(steady(), "radiation", "body"))
    (told,) = experiments(search)
    rates = [outcome(pair(), p).sigma() ** 2 / p.hours for p in library(pair())]
    assert told.text == library(pair())[int(np.argmax(rates))].text
    assert told.separates == ("heat source (body)", "bearing friction (body)")
    assert told.sigma > CLEAR and told.hours == 4


def test_what_is_far_from_its_rivals_or_has_none_needs_no_run() -> None:
    far = supposed(steady(), "radiation", "body")
    assert in_doubt(search_of(pair().holds, far)) == []
    assert in_doubt(search_of(pair().holds)) == [] == in_doubt(search_of(best=pair().holds))


def test_the_rival_stays_beside_a_finding_that_ranked_second() -> None:
    (found,) = in_doubt(search_of(pair().rival, pair().holds, best=pair().holds))
    assert (found.holds, found.rival) == (pair().holds, pair().rival)


def test_what_no_program_tells_apart_is_said_so() -> None:
    """On parts of one steel, both are a length times the difference of the same two temperatures."""
    bent = {"kind": "bending", "between": ["motor", "body"], "distance": "200 mm", "length": "1 m", "direction": 1,
            "expansion": "1.1e-5 1/K"}  # fmt: skip
    run = recorded(two_blocks().patched({"tcp": {"z": {"bent": bent}}}), STEADY, 2)
    case = Case(two_blocks(), (run,))
    (told,) = separating(Pair(supposed(case, "bending", "motor", "body"), supposed(case, "tilt", "motor", "body")))
    assert told.sigma < 1 and not told.scenario  # a run that tells nothing is not written
    assert told.text.startswith("No schedule that was tried tells bending (tcp.z, motor, body) from tilt")
    assert "nor does" not in told.text  # every part has a sensor
    assert "Nearest" not in told.text and advice_words(told) == f"{told.text}."


@cache
def twins() -> Pair:
    """Heat in one or the other of two equal parts without a sensor."""
    nodes = {
        "body": {"heat_capacity": "15 kJ/K"}, "left": {"heat_capacity": "5 kJ/K"},
        "right": {"heat_capacity": "5 kJ/K"}, "air": {"temperature": "ambient"},
    }  # fmt: skip
    links = {
        f"{n} joint": {"kind": "conduction", "between": [n, "body"], "conductance": "10 W/K ± 10 %"}
        for n in ("left", "right")
    }
    links |= {"skin": {"kind": "convection", "between": ["body", "air"], "conductance": "7 W/K ± 10 %"}}
    loss = {"loss": {"kind": "bearing_friction", "into": {"body": 1}, "torque": "200 N mm ± 10 %"}}
    sensors = {"T_body": {"measures": "body", "noise": "0.05 K"}}
    machine = small.machine(nodes, links=links, sources=loss, sensors=sensors)
    pump = {"sources": {"pump": {"kind": "heat_source", "into": {"left": 1}, "power": "40 W"}}}
    case = Case(machine, (recorded(machine.patched(pump), speeds((0.0, 6000), (2.0, 0)), 3),))
    return Pair(supposed(case, "heat_source", "left"), supposed(case, "heat_source", "right"))


def test_a_further_sensor_is_advised_where_it_tells_more_than_any_program() -> None:
    (told,) = separating(twins())
    assert told.text.startswith(("Put a temperature sensor on left. ", "Put a temperature sensor on right. "))
    assert max(outcome(twins(), p).sigma() for p in library(twins())) < 0.5 < CLEAR < told.sigma


# -- programs -------------------------------------------------------------------------------------------------------
def recording_of(minutes: float = 240, **inputs: tuple[str, Any]) -> Recording:
    t = np.arange(0.0, minutes * 60 + 1, 10.0)
    columns = {n: Column(n, unit, np.broadcast_to(values, t.shape)) for n, (unit, values) in inputs.items()}
    return Recording("made", "made.csv", t, columns)


def half(low: float, high: float, count: int = 1441) -> np.ndarray:
    return np.where(np.arange(count) < count / 2, low, high)


def test_programs_stay_in_the_recorded_range_and_keep_the_air_as_it_was() -> None:
    speed = np.repeat([0.0, 3000, 7985], [400, 400, 641]) * RPM
    runs = [recording_of(speed=("rpm", speed), ambient=("degC", half(20.0, 22.0)))]
    made = programs([two_blocks()], runs)
    assert [p.text for p in made] == [
        "Run speed at 8000 rpm for 2 h, then at 0 rpm for 2 h",
        "Run speed at 2000 rpm, 4000 rpm, 6000 rpm, 8000 rpm and 0 rpm, 48 min each",
        "Switch speed between 8000 rpm and 0 rpm, held for 40, 10, 20, 5, 15, 30, 5, 25, 10, 40, 15, 25 min in turn",
        "Leave speed at 0 rpm for 4 h",
    ]
    assert sum(HOLDS) == 48
    for p in made:
        assert p.hours == 4 and p.interval == 10 and p.start == pytest.approx(21, abs=0.01)
        assert p.signals["ambient"].at(np.array([0.0, 9e3])) == pytest.approx(21, abs=0.01)
        assert p.signals["speed"].start.min() >= 0 and p.signals["speed"].start.max() <= 8000.1 * RPM
    ends = made[2].signals["speed"]
    assert ends.t[1] == 2400 and np.all(np.diff(ends.t) >= 300) and len(ends.t) == len(HOLDS)


def test_a_switch_has_no_steps_and_short_recordings_make_short_programs() -> None:
    runs = [recording_of(70, speed=("rpm", half(0.0, 3000 * RPM, 421)), ambient=("degC", 20.0))]
    texts = [p.text for p in programs([two_blocks()], runs)]
    assert texts[0] == "Run speed at 3000 rpm for 30 min, then at 0 rpm for 30 min" and len(texts) == 3


def test_what_was_never_varied_and_temperatures_are_no_drivers() -> None:
    runs = [recording_of(speed=("rpm", 6000 * RPM), ambient=("degC", half(20, 24)), x=("mm", half(0.2, 0.6)))]
    assert programs([two_blocks()], runs) == []
    assert driver("ambient", runs) is None
    position = driver("x", runs)
    assert position is not None and position.rest == pytest.approx(0.2)  # a slide has no state of rest at zero


def test_a_constant_of_a_mapping_counts_as_recorded() -> None:
    t = np.arange(0.0, 4 * 3600 + 1, 10.0)
    signals = {"speed": hold("speed", "rpm", np.array([0.0, 7200.0]), np.array([0.0, 5000 * RPM])),
               "ambient": constant("ambient", "degC", 19.0)}  # fmt: skip
    made = programs([two_blocks()], [Recording("made", "made.csv", t, {}, signals)])
    assert made[0].start == 19 and "5000 rpm" in made[0].text


def test_inputs_that_matter_are_programmed_before_others() -> None:
    into = {"kind": "heat_source", "into": {"body": 1}, "power": "12 W", "at": "1 kW"}
    names = ["a", "b", "c", "cutting"]
    read = two_blocks().patched({"sources": {n: {**into, "with": n} for n in names}})
    runs = [recording_of(**{n: ("W", half(0, 900.0)) for n in names}, speed=("rpm", 100.0), ambient=("degC", 20.0))]
    usual, first = (programs([read], runs, matter)[0].text for matter in ((), ("cutting",)))
    assert usual.startswith("Run a at") and first.startswith("Run cutting at 900 W")


def test_two_drivers_are_switched_in_different_orders() -> None:
    screw = {"sources": {"screw": {"kind": "screw_friction", "into": {"body": 1}, "power_per_feed": "12 W/(m/min)"}}}
    runs = [recording_of(speed=("rpm", half(0, 6000 * RPM)), feed=("m/min", half(0.3, 0.0)), ambient=("degC", 20.0))]
    made = programs([two_blocks().patched(screw)], runs)
    both = next(p for p in made if p.text.startswith("Switch"))
    assert not np.array_equal(both.signals["speed"].t, both.signals["feed"].t)
    alone = next(p for p in made if p.text.startswith("Run feed"))
    assert not alone.signals["speed"].start.any() and alone.signals["feed"].start.any()


# -- ranking --------------------------------------------------------------------------------------------------------
def test_shares_add_up_and_count_each_kind_and_place_once() -> None:
    ranked = [pair().holds, pair().holds, pair().rival]
    assert distinct(ranked) == [pair().holds, pair().rival]
    assert shares(distinct(ranked)).sum() == pytest.approx(1)


# -- isolability ----------------------------------------------------------------------------------------------------
def scored(c: Candidate, *lean: float) -> Score:
    row = np.array(lean)
    return Score(c, 0.0, 1.0, float(np.linalg.norm(row)), row)


def test_what_could_not_be_seen_and_what_is_one_is_counted() -> None:
    kinds = ("heat_source", "bearing_friction", "natural_convection", "radiation", "hidden_mass")
    heat, rubs, skin, glow, tank = (proposed(steady(), kind, "body")[0] for kind in kinds)
    found = isolability([scored(heat, 10, 0), scored(rubs, 20, 1), scored(skin, -8, 0), scored(glow, 0, 2)], [tank])
    assert found.looked_at == 5 and found.unseen == (glow, tank)
    assert found.classes == ((rubs, heat),)
    assert found.sentence == (
        "2 of 5 possible effects are too small to show here, and 1 group of others looks alike. In detail: too small "
        "at their usual size: radiation (1), hidden mass (1); alike: bearing friction or heat source (1)."
    )
    assert isolability([scored(heat, 10, 0)]).sentence == ""


def classes_at(*steps: tuple[float, float]) -> list[set[str]]:
    case = Case(two_blocks(), (recorded(two_blocks(), speeds(*steps), 1),))
    null = fit_hypothesis(case, case.machine)
    known = candidates(null.machine, case.drivers)
    alike = isolability(screen(null.fit, known, null.values), known).classes
    return [{name_candidate(c) for c in group} for group in alike]


def test_what_one_speed_cannot_tell_apart_is_a_class_beforehand() -> None:
    pair = {"heat source (body)", "bearing friction (body)"}
    assert any(pair <= group for group in classes_at((0.0, 6000)))
    assert not any(pair <= group for group in classes_at((0.0, 8000), (1.0, 2000), (2.0, 5000), (3.0, 0)))


def test_a_program_is_advised_that_shows_what_could_not_be_seen() -> None:
    """Standing still tells nothing of what grows with speed."""
    quiet = two_blocks()
    case = Case(quiet, (recorded(quiet, speeds((0.0, 0), (3.9, 3000)), 1),))
    null = fit_hypothesis(case, quiet)
    fan = proposed(case, "forced_convection", "body")
    assert screen(null.fit, fan, null.values)[0].detectable < CLEAR
    (told,) = revealing(null, fan)
    assert told.separates == () and told.sigma > CLEAR and "3000 rpm" in told.text
    shown = "1 of 1 effects that these recordings could not show would be seen (forced convection (1))"
    assert told.text.endswith(shown)
    search: Any = SimpleNamespace(best=null, steps=(), screened=SimpleNamespace(before=null))
    assert list(experiments(search, fan)) == [told] and not list(experiments(search))


# -- words ----------------------------------------------------------------------------------------------------------
def test_the_report_tells_the_next_experiment(tmp_path: Any) -> None:
    run = Experiment("Run speed at 8000 rpm for 2 h, then at 0 rpm for 2 h", ("tilt (a)", "bending (b)"), 6.13, 4.0)
    told = " ".join(str(diagnosed(tmp_path, advice=(run,))).split())
    assert f"Next experiment: {run.text}. It would tell tilt (a) from bending (b) by 6.1 σ in 4 h." in told
    best = replace(run, text="No schedule tells them apart. Nearest comes: run speed at 8000 rpm for 4 h", sigma=1.66)
    told = " ".join(str(diagnosed(tmp_path, advice=(best,))).split())
    assert f"{best.text}, with 1.7 σ in 4 h." in told and "Next experiment" not in told
