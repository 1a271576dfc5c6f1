"""Where a diagnosis says that something sits: at parts of any name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from build import machine
from diagnosed import diagnosed, unknown_heat
from fits import USUAL, recorded, speeds

from network.analysis.diagnosis.candidates import Candidate, candidates
from network.analysis.diagnosis.findings import find_unknown
from network.analysis.diagnosis.hypothesis import Case, Hypothesis, fit_hypothesis
from network.analysis.diagnosis.locate import locate
from network.analysis.diagnosis.location import Location
from network.analysis.diagnosis.placement import _aside, _elsewhere
from network.catalogue.declaration.places import Place
from network.machine.machine import Machine
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
])  # fmt: skip
def test_a_location_knows_its_kind_and_its_seats(at: Location, kind: str, text: str, seats: tuple[str, ...]) -> None:
    assert (at.kind, str(at), at.seats) == (kind, text, seats)
    assert (at.channels == seats) == (kind == "channel")


def unknown_at(at: Location, null: Hypothesis) -> dict[str, Any]:
    """What stands in diagnosis.json of something unknown there."""
    search = SimpleNamespace(best=null, null=null, located=(unknown_heat(at, 0.9, 1, 80.0),), threshold=9.0)
    return find_unknown(cast(Any, search)).summary()


def test_places_of_something_unknown_are_parts_of_the_machine() -> None:
    case = Case(oddly_named(), (recorded(oddly_named(), speeds(*USUAL), 1),))
    null = fit_hypothesis(case, case.machine)
    located = {u.at for u in locate(null.fit, null.machine)}
    channels = {Location(channel=name) for name in case.machine.sensors}
    assert located == {Location((HEAD,)), Location((AXIS,)), Location((HEAD, AXIS)), *channels}
    for at in located:
        told = unknown_at(at, null)
        assert (told["places"], told["channels"]) == (list(at.nodes), list(at.channels))
        assert set(told["places"]) <= set(case.machine.nodes) and set(told["channels"]) <= set(case.machine.sensors)
        (course,) = told["course"]
        assert course["file"] == case.recordings[0].file
        assert len(course["t"]) == len(course["offset" if at.channels else "heat"]) == len(course["std"]) > 60


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
