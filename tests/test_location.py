"""Where a diagnosis says that something sits: at parts of any name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from build import machine
from diagnosed import diagnosed, unknown_heat
from fits import USUAL, recorded, speeds

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.findings.unnamed_findings import find_unknown
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.latent_heat.locate import has_stated, locate
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.latent_heat.mismatch import Mismatch, locate_beside
from network.analysis.diagnosis.latent_heat.unknown_heat import heat_knots, temperature_answers
from network.analysis.diagnosis.latent_heat.unrecorded_surroundings import find_unrecorded
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.placement import _aside, _elsewhere
from network.catalogue.declaration.places import Place
from network.engine.response.input_slopes import input_slopes
from network.machine.machine import Machine
from network.recordings.inputs import constant, linear
from network.recordings.recording import Recording
from network.report.words.heat_words import is_found_at, where_words

HEAD, AXIS = "head to ram", "d'axe"
BAR = {"material": "steel", "length": "600 mm", "area": "130 cm^2"}


def oddly_named(lumps: int = 1) -> Machine:
    """Two bars whose names have quotes in them, and the word that stands between the two ends of a link."""
    return machine(
        {HEAD: {**BAR, "lumps": lumps}, AXIS: {**BAR, "lumps": lumps}, "air": {"temperature": "ambient"}},
        links={"flange": {"kind": "conduction", "between": [HEAD, AXIS], "conductance": "12 W/K ± 30 %"},
               "skin": {"kind": "convection", "between": [AXIS, "air"], "conductance": "7 W/K ± 30 %"}},
        sources={"loss": {"kind": "windage", "into": {HEAD: 1}, "power": "80 W ± 30 %", "reference_speed": "8000 rpm"}},
        sensors={"T head": {"measures": HEAD, "noise": "0.05 K"}, "T axis": {"measures": AXIS, "noise": "0.05 K"}},
    )  # fmt: skip


@pytest.mark.parametrize(("at", "kind", "text", "seats"), [
    (Location((HEAD,)), "node", HEAD, (HEAD,)),
    (Location((HEAD, AXIS)), "link", f"{HEAD} to {AXIS}", (HEAD, AXIS)),
    (Location(channel="T head"), "channel", "T head", ("T head",)),
    (Location(("air",), is_held=True), "surroundings", "air", ("air",)),
])  # fmt: skip
def test_a_location_knows_its_kind_and_its_seats(at: Location, kind: str, text: str, seats: tuple[str, ...]) -> None:
    assert (at.kind, str(at), at.seats) == (kind, text, seats)
    assert (at.channels == seats) == (kind == "channel")


def unknown_at(at: Location, null: Hypothesis) -> dict[str, Any]:
    """What stands in diagnosis.json of something unknown there."""
    mismatch = Mismatch((unknown_heat(at, 0.9, 1, 80.0),), null)
    search = SimpleNamespace(best=null, null=null, mismatch=mismatch, threshold=9.0)
    return find_unknown(cast(Any, search)).summary()


def test_places_of_something_unknown_are_parts_of_the_machine() -> None:
    case = Case(oddly_named(), (recorded(oddly_named(), speeds(*USUAL), 1),))
    null = fit_hypothesis(case, case.machine)
    located = {u.at for u in locate(null.fit, null.machine)}
    channels = {Location(channel=name) for name in case.machine.sensors}
    assert located == {Location((HEAD,)), Location((AXIS,)), Location((HEAD, AXIS)), *channels}
    for at in located:
        told, read = unknown_at(at, null), {"T head": HEAD, "T axis": AXIS}
        reads = [read[name] for name in at.channels if name in read]
        assert (told["places"], told["channels"]) == ([*at.nodes, *reads], list(at.channels))
        assert (f" (it reads {reads[0]}) that" in told["sentence"]) if reads else "reads" not in told["sentence"]
        assert set(told["places"]) <= set(case.machine.nodes) and set(told["channels"]) <= set(case.machine.sensors)
        (course,) = told["course"]
        assert course["file"] == case.recordings[0].file
        assert len(course["t"]) == len(course["offset" if at.channels else "heat"]) == len(course["std"]) > 60


WARMING, COOLING = 1.5, -2.0
"""K/h"""


def aired() -> Machine:
    """With both parts in the air: heat into one of them does not do the same."""
    cover = {"kind": "convection", "between": [HEAD, "air"], "conductance": "9 W/K ± 30 %"}
    return oddly_named().patched({"links": {"cover": cover}})


def stated(rate: float) -> Recording:
    """A run in a room that drifts, of which a constant is stated."""
    room = linear("ambient", "degC", np.array([0.0, 4 * 3600.0]), 20 + np.array([0.0, 4 * rate]))
    run = recorded(aired(), speeds(*USUAL, ambient=room), 1)
    columns = {name: column for name, column in run.columns.items() if name != "ambient"}
    told = constant("ambient", "degC", 20.0, 1.0)
    return replace(run, columns=columns, constants={"ambient": told})


def test_a_room_that_does_not_stay_what_is_stated_is_found_by_its_course_in_each_run() -> None:
    """And no part or sensor beside it; no number of a file could stand for both runs."""
    case = Case(aired(), (stated(WARMING), stated(COOLING)))
    null = fit_hypothesis(case, case.machine)
    first, *rest = locate(null.fit, null.machine)
    assert first.at == Location(("air",), is_held=True) and first.gain > 20 + max(u.gain for u in rest)
    (*_, warm), (*_, cold) = first.heat
    assert warm - cold == pytest.approx(4 * (WARMING - COOLING), rel=0.25)
    mismatch = Mismatch((first, *rest), null)
    search = SimpleNamespace(best=null, null=null, mismatch=mismatch, threshold=9.0)
    finding = find_unknown(cast(Any, search))
    assert (finding.kind, finding.places, finding.part, finding.is_room) == ("ambient_drift", ("air",), "part", True)
    assert "otherwise in each run" in finding.sentence and "temperature" in finding.summary()["course"][0]
    assert first.summary()["temperature_rms"]["unit"] == "K"


def test_such_a_room_is_found_beside_the_numbers_of_the_file_where_fitted_ones_are_bent_to_it() -> None:
    case = Case(aired(), (stated(WARMING), stated(COOLING)))
    null = fit_hypothesis(case, case.machine)
    rest = find_unrecorded(null)
    assert rest is not None and rest.heat.at == Location(("air",), is_held=True)
    assert rest.left < 1.2 < 5 < null.chi
    assert np.abs(rest.beside.shift).max() < 1 < 3 < np.abs(null.shift).max()
    (*_, warm), (*_, cold) = rest.heat.heat
    assert warm - cold == pytest.approx(4 * (WARMING - COOLING), rel=0.15)
    mismatch = locate_beside(null, rest)
    assert mismatch.about.values == rest.beside.values and mismatch.places[0].at == rest.heat.at


def test_what_sits_in_one_part_is_no_room() -> None:
    """Though nobody recorded the room: heat there explains more than another room would."""
    more = {"stray": {"kind": "heat_source", "into": {AXIS: 1}, "power": "60 W"}}
    truth = aired().patched({"sources": more})
    columns = recorded(truth, speeds(*USUAL), 1).columns
    run = replace(stated(0.0), columns={n: c for n, c in columns.items() if n != "ambient"})
    case = Case(aired(), (run,))
    null = fit_hypothesis(case, case.machine)
    assert null.chi > SETTINGS.doubtful and has_stated(null.linearised, null.machine)
    assert find_unrecorded(null) is None


def test_a_room_that_was_recorded_is_no_suspect() -> None:
    case = Case(aired(), (recorded(aired(), speeds(*USUAL), 1),))
    null = fit_hypothesis(case, case.machine)
    assert not any(u.is_room for u in locate(null.fit, null.machine)) and not has_stated(null.linearised, null.machine)


def test_a_room_about_one_part_alone_is_no_other_suspect_than_that_part() -> None:
    run = replace(stated(WARMING), constants={"ambient": constant("ambient", "degC", 20.0, 1.0)})
    case = Case(oddly_named(), (run,))
    null = fit_hypothesis(case, case.machine)
    assert not any(u.is_room for u in locate(null.fit, null.machine))


def test_answers_to_a_room_are_those_of_runs_in_another_room() -> None:
    """Hats on all knots add up to one kelvin more all along."""
    case = Case(aired(), (stated(0.0),))
    fit = fit_hypothesis(case, case.machine).linearised
    (p,), (data,) = fit.predictions, fit.problem.data
    (slope,) = input_slopes([p], [{"ambient": 1.0}])
    answers = temperature_answers(p, "air", heat_knots(data, 900.0))
    np.testing.assert_allclose(answers.sum(axis=0), slope[0], atol=1e-6 * np.abs(slope).max())


def test_a_link_that_reads_like_a_part_is_not_taken_for_it(tmp_path: Path) -> None:
    between, part = (unknown_heat(at, 0.9, 2, 80.0) for at in (Location(("head", "ram")), Location((HEAD,))))
    assert is_found_at(part, {HEAD}) and not is_found_at(between, {HEAD})
    d = diagnosed(tmp_path)
    other = replace(d, located=(part,), findings=(replace(d.findings[0], places=("head",)),))
    assert "what was found explains the recordings better" in where_words(other)


def heat_in(part: str) -> Candidate:
    proposed = candidates(oddly_named(4), {"ambient", "speed"})
    return next(c for c in proposed if c.kind.kind == "heat_source" and c.places == (part,))


@pytest.mark.parametrize("part", [HEAD, AXIS])
def test_a_stretch_of_a_bar_is_found_again(part: str) -> None:
    c = heat_in(part)
    assert c.seats == (Place(part),) and len(c.stretches) == 4
    for stretch in c.stretches:
        (seat,) = stretch.seats
        assert seat.node == part and seat.share == pytest.approx(0.25) and stretch.places == (part,)
        assert stretch.back is not None and stretch.back.patch == c.patch
    quarter = c.stretches[1]
    others = {Place(part), *(s.seats[0] for s in c.stretches)} - {*quarter.seats}
    assert {m.seats[0] for m in _elsewhere(quarter)} == others
    assert {str(m.seats[0]) for m in _aside(quarter, 0.1)} >= {f"{part}@0.15..0.5", f"{part}@0.35..0.6"}
