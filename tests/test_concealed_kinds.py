"""Kinds concealed and found: a machine with the effect makes recordings, its file does without it, and of the proposals
for that file the one at its place explains them and says how large it is."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
import pytest
from fits import recorded, speeds, two_blocks

from network import Machine
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, fit_hypothesis
from network.analysis.diagnosis.screening.screen import score_candidates
from network.analysis.diagnosis.steps.backward_elimination import share_explained
from network.analysis.diagnosis.steps.unseen_runs import tell_unseen
from network.catalogue.declaration.discovery import kinds
from network.catalogue.declaration.fields import Place
from network.catalogue.suspects.interposed_mass import InterposedMass
from network.catalogue.suspects.post import Post
from network.engine.response.parameters import at_values
from network.platform.quantities.units import unit
from network.recordings.inputs import Signal, hold, linear

LADDERS = (((0.0, 6000), (0.8, 2000), (1.6, 8000), (2.7, 0)), ((0.0, 3000), (0.5, 8000), (1.9, 5000), (3.1, 1000)))
HALF_HOUR = 1800.0


def levels(name: str, text: str, *values: float) -> Signal:
    """Held in turn for half an hour each."""
    of = unit(text)
    return hold(name, text, HALF_HOUR * np.arange(len(values)), np.array([of.to_si(v) for v in values]))


def bed() -> Signal:
    """The temperature of a heated bed, which swings between 40 and 60 °C."""
    t = np.arange(0.0, 4 * 3600 + 1, 60.0)
    return linear("bed", "degC", t, 50 + 10 * np.sin(2 * np.pi * t / 7000))


def supply() -> Signal:
    """A power that climbs and falls."""
    return linear("supply", "W", HALF_HOUR * np.arange(9.0), np.array([0.0, 300, 50, 600, 150, 0, 450, 100, 0]))


MORE: Mapping[str, Signal] = {
    "bed": bed(), "supply": supply(), "current": levels("current", "A", 1, 0, 3, 2, 0, 4, 1, 0),
    "pump": levels("pump", "1", 0, 1, 0, 1, 1, 0, 0, 1),
}  # fmt: skip


def conceal(plain: Machine, truth: Machine) -> Case:
    runs = (recorded(truth, speeds(*ladder, **MORE), seed) for seed, ladder in enumerate(LADDERS))
    return Case(plain, tuple(runs))


def proposed(case: Case, section: str, kind: str, *places: str, has: str = "") -> Candidate:
    """The candidate of a kind at places, whose patch says what it `has`."""
    found = candidates(case.machine, case.drivers, among=[kinds(section)[kind]], runs=case.runs)
    return next(c for c in found if c.places == places and has in str(c.patch.to_plain()))


def explain(case: Case, c: Candidate) -> Hypothesis:
    """The fit with a proposal, which leaves noise where much is left without it."""
    before, after = fit_hypothesis(case, case.machine), fit_hypothesis(case, c.machine, (c,), c.own)
    assert before.chi > 1.3 and after.chi < 1.1
    assert after.evidence > before.evidence + 50
    return after


def own(h: Hypothesis) -> dict[str, float]:
    """The numbers of what was found, by the key each has."""
    return {p.path.rpartition(".")[2]: h.values[p.path] for p in h.found[-1].own}


def said(h: Hypothesis) -> str:
    return h.found[-1].kind.told(h.found[-1].machine, h.found[-1].patch)


def test_a_part_between_a_motor_and_what_it_heats() -> None:
    plain = two_blocks()
    between = InterposedMass(of=Place("loss"), heat_capacity=900.0, conductance=4.0)
    case = conceal(plain, plain.patched(between.patch(plain)))
    found = explain(case, proposed(case, "suspects", "interposed_mass", "motor"))
    assert own(found) == pytest.approx({"heat_capacity": 900, "conductance": 4}, rel=0.15)
    assert "lies between loss and what it heats" in said(found)


def test_a_post_beside_a_heated_bed() -> None:
    feet = {"kind": "conduction", "between": ["bed", "body"], "conductance": "1 W/K ± 20 %"}
    plain = two_blocks(nodes={"bed": {"temperature": "bed"}}, links={"feet": feet})
    numbers = {"heat_capacity": 300.0, "conductance": 0.4, "loss": 0.3, "length": 0.08}
    post = Post(near=Place("bed"), surroundings=Place("air"), moves="tcp.z", direction=-1, **numbers)
    case = conceal(plain, plain.patched(post.patch(plain)))
    found = explain(case, proposed(case, "suspects", "post", "tcp.z", "bed", "air", has="'direction': -1"))
    told = own(found)
    taken = told["conductance"] / (told["conductance"] + 0.3)
    assert told["length"] * taken == pytest.approx(0.08 * 0.4 / 0.7, rel=0.03)  # how far it follows the bed
    assert told["heat_capacity"] / (told["conductance"] + 0.3) == pytest.approx(300 / 0.7, rel=0.05)  # and how fast
    assert 0.15 < told["conductance"] < 0.6, "told by the air alone, which hardly moves"
    assert "a post near bed" in said(found) and "moves the tool along -z" in said(found)


def test_heat_that_goes_with_the_square_of_a_current() -> None:
    coil = {"kind": "heat_source", "into": {"body": 1}, "with": "current", "at": "3 A", "exponent": 2}
    plain, bent = (two_blocks(sources={"coil": {**coil, "power": "5 W ± 300 %", "exponent": p}}) for p in (2, 1))
    case = conceal(plain, two_blocks(sources={"coil": {**coil, "power": "50 W"}}))
    square, straight = fit_hypothesis(case, plain), fit_hypothesis(case, bent)
    assert straight.chi > 1.5 > 1.1 > square.chi
    assert square.values["sources.coil.power"] == pytest.approx(50, rel=0.1)


def test_a_recorded_power_that_nothing_reads() -> None:
    plain = two_blocks()
    heater = {"kind": "heat_source", "into": {"body": 1}, "power": "210 W", "with": "supply", "at": "600 W"}
    case = conceal(plain, plain.patched({"sources": {"heater": heater}}))
    assert {name: str(most) for name, most in case.runs.powers.items()} == {"supply": "600 W"}
    found = explain(case, proposed(case, "sources", "heat_source", "body", has="supply"))
    assert own(found)["power"] == pytest.approx(210, rel=0.1)
    assert "from a source that follows supply" in said(found)


def test_a_recorded_column_that_is_no_power_and_its_square() -> None:
    plain = two_blocks()
    coil = {"kind": "heat_source", "into": {"body": 1}, "power": "50 W", "with": "current", "at": "3 A", "exponent": 2}
    case = conceal(plain, plain.patched({"sources": {"coil": coil}}))
    assert {*case.runs.drivers} == {"current", "pump"}, "no temperature, no response, nothing that kinds read anyway"
    squared = explain(case, proposed(case, "sources", "heat_source", "body", has="current squared"))
    straight = proposed(case, "sources", "heat_source", "body", has="current body")
    assert "follows current to the power of 2" in said(squared)
    assert fit_hypothesis(case, straight.machine, (straight,), straight.own).chi > 1.3 > squared.chi


def test_heat_that_a_recorded_pump_takes_away() -> None:
    """Coolant that runs at times is scored below nothing, and told as a sink."""
    plain = two_blocks()
    coolant = {"kind": "heat_source", "into": {"body": 1}, "power": "-80 W", "with": "pump", "at": "1"}
    case = conceal(plain, plain.patched({"sources": {"coolant": coolant}}))
    c = proposed(case, "sources", "heat_source", "body", has="pump body")
    null = fit_hypothesis(case, plain)
    (score,) = score_candidates(null.linearised, [c], null.values)
    assert c.is_signed and score.gain > 50 and score.amplitude < 0
    assert not proposed(case, "sources", "heat_source", "body", has="always").is_signed
    found = explain(case, c)
    assert own(found)["power"] == pytest.approx(-80, rel=0.1)
    told = c.kind.told(at_values(c.machine, found.values), c.patch)
    assert re.fullmatch(r"body loses [78]\d(\.\d)? W to a sink that follows pump", told)


@pytest.mark.parametrize("is_single", [False, True])
def test_what_shows_nowhere_else_is_told_by_where_it_shows(is_single: bool) -> None:
    """A pump that cools in one of several recordings, or late in a single one: what it takes is free elsewhere."""
    off, on = (levels("pump", "1", 0, 0, 0, 0, 0, x, x, 0) for x in (0, 1))
    plain = two_blocks()
    heat = {"kind": "heat_source", "into": {"body": 1}, "power": "-15 W", "with": "pump", "at": "1"}
    truth = plain.patched({"sources": {"heat": heat}})
    pumps = [on] if is_single else [off, off, on]
    runs = [recorded(truth, speeds(*LADDERS[k % 2], pump=pump), k) for k, pump in enumerate(pumps)]
    case = Case(plain, tuple(runs))
    c = proposed(case, "sources", "heat_source", "body", has="pump body")
    null, found = fit_hypothesis(case, plain), fit_findings(case, plain, [c], {})
    assert found is not None and own(found)["power"] == pytest.approx(-15, rel=0.2)
    before, after = (tell_unseen(h, with_rest=False) for h in (null, found))
    assert after.density > before.density + 50 and share_explained(before.chi, after.chi) > 0.8


def test_a_heater_that_a_thermostat_switches() -> None:
    plain = two_blocks()
    boiler = {"kind": "thermostat_heating", "into": {"body": 1}, "watches": "body", "set": "31 degC",
              "hysteresis": "2 K", "power": "300 W"}  # fmt: skip
    case = conceal(plain, plain.patched({"sources": {"boiler": boiler}}))
    c = proposed(case, "sources", "thermostat_heating", "body")
    near = {"set": 30.9, "hysteresis": 2.1, "power": 290.0}
    start = {p.path: near[p.path.rpartition(".")[2]] for p in c.own}
    found = fit_findings(case, plain, [c], start, in_step=False)
    assert found is not None and found.chi < 1.1 < 5 < fit_hypothesis(case, plain).chi
    assert own(found) == pytest.approx({"power": 300, "set": 31, "hysteresis": 2}, rel=0.05)


def test_a_window_of_heat() -> None:
    plain = two_blocks()
    window = {"kind": "timed_source", "into": {"body": 1}, "begins": "40 min", "ends": "75 min"}
    case = conceal(plain, plain.patched({"sources": {"lamp": {**window, "power": "150 W"}}}))
    lamp = plain.patched({"sources": {"lamp": {**window, "power": "20 W ± 300 %"}}})
    found = fit_hypothesis(case, lamp)
    assert fit_hypothesis(case, plain).chi > 1.3 > 1.1 > found.chi
    assert found.values["sources.lamp.power"] == pytest.approx(150, rel=0.1)


def test_a_loss_that_is_there_while_a_pump_runs() -> None:
    plain = two_blocks()
    spray = {"kind": "convection", "between": ["body", "air"], "while": "pump"}
    case = conceal(plain, plain.patched({"links": {"spray": {**spray, "conductance": "12 W/K"}}}))
    known = fit_hypothesis(case, plain.patched({"links": {"spray": {**spray, "conductance": "3 W/K ± 300 %"}}}))
    assert fit_hypothesis(case, plain).chi > 1.3 > 1.1 > known.chi
    assert known.values["links.spray.conductance"] == pytest.approx(12, rel=0.1)


def test_the_sun_is_proposed_where_a_run_lasts_a_day() -> None:
    plain = two_blocks()
    sun = {"kind": "sunlight", "into": {"body": 1}, "power": "160 W", "rises": "2 h", "lasts": "9 h"}
    truth = plain.patched({"sources": {"sun": sun}})
    steps = [(2.0 * i, rpm) for i, rpm in enumerate((0, 6000, 2000, 0, 8000, 1000, 0, 4000, 0, 7000, 3000, 0, 0))]
    day = Case(plain, (recorded(truth, speeds(*steps, hours=26, every=60.0), 1),))
    short = conceal(plain, truth)
    sought = [kinds("sources")["sunlight"]]
    assert not candidates(plain, short.drivers, among=sought, runs=short.runs)
    found = explain(day, proposed(day, "sources", "sunlight", "body"))
    assert own(found) == pytest.approx({"power": 160, "rises": 7200, "lasts": 9 * 3600}, rel=0.1)


def test_a_store_that_melts() -> None:
    plain = two_blocks()
    melts = {"at": "27 degC", "over": "3 K", "latent_heat": "80 kJ"}
    truth = plain.patched({"nodes": {"body": {"heat_capacity": "15 kJ/K", "melts": melts}}})
    case = Case(plain, (recorded(truth, speeds(*LADDERS[0], every=30.0), 1),))
    found = explain(case, proposed(case, "suspects", "phase_change", "body"))
    assert own(found) == pytest.approx({"latent_heat": 8e4, "at": 27, "over": 3}, rel=0.05)
    assert "body melts around" in said(found)
