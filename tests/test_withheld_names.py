"""A name that is less likely than not is not told behind another finding, but what it stands for stays."""

from __future__ import annotations

from dataclasses import replace

import pytest

from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding
from network.analysis.diagnosis.findings.withheld_names import withhold_names
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.latent_heat.location import Location
from network.analysis.diagnosis.screening.crossed_splits import UnseenTest
from network.catalogue.declaration.patch import Patch

SHOWS = UnseenTest((1e-9, 1e-9), (("guide_friction", "bed"), ("guide_friction", "bed")))
HIDES = UnseenTest((0.4, 0.5), (("guide_friction", "bed"), ("tilt", "tcp.z")))


def tell(kind: str, confidence: float, unseen: UnseenTest | None = None, holds: float | None = 0.9) -> Finding:
    patch = Patch({"sources": {"warm": {"kind": kind}}}) if kind != UNKNOWN else Patch({})
    return Finding(kind, "sources", ("bed",), (), confidence, {}, "Bed is warm.", patch, 50.0, 12.0, unseen=unseen,
                   share=confidence, holds=holds)  # fmt: skip


FIRST = tell("heat_source", 0.3)


def test_the_first_name_is_told_however_unsure() -> None:
    assert withhold_names([FIRST]) == [FIRST]


@pytest.mark.parametrize("unseen", [None, HIDES])
def test_an_unlikely_name_behind_it_is_withheld(unseen: UnseenTest | None) -> None:
    first = replace(FIRST, places=("column",))
    told = withhold_names([first, tell("timed_source", 0.3, unseen)])[1]
    assert (told.kind, told.places, told.is_withheld, told.part) == (UNKNOWN, ("bed",), True, "part")
    assert told.alternatives[0].kind == "timed_source" and told.alternatives[0].confidence == 0.3
    assert told.sentence == "Something at bed without a sure name is told best so: Bed is warm."
    assert told.patch == tell("timed_source", 0.3).patch


@pytest.mark.parametrize("other", [tell("timed_source", 0.5), tell("timed_source", 0.3, SHOWS),
                                   tell("sensor_fault", 0.3, holds=None)])  # fmt: skip
def test_a_likely_one_one_that_shows_again_and_a_fault_of_readings_keep_their_names(other: Finding) -> None:
    assert withhold_names([FIRST, other]) == [FIRST, other]


@pytest.mark.parametrize(("place", "told"), [("bed", UNKNOWN), ("column", "heat_source")])
def test_two_unlikely_names_in_one_place_may_be_one_thing(place: str, told: str) -> None:
    first = replace(FIRST, places=(place,))
    assert withhold_names([first, tell("timed_source", 0.3)])[0].kind == told
    sure = replace(first, confidence=0.5)
    assert withhold_names([sure, tell("timed_source", 0.3)])[0] is sure


def test_what_has_no_name_counts_as_told_first() -> None:
    nameless = replace(tell(UNKNOWN, 0.5), places=("column",), holds=None)
    assert [f.kind for f in withhold_names([nameless, tell("timed_source", 0.3)])] == [UNKNOWN, UNKNOWN]


def test_in_one_place_with_what_has_no_name_it_is_the_nearest_that_is_known_of_that() -> None:
    nameless = replace(tell(UNKNOWN, 0.5), sentence="An unknown heat at bed.", holds=None)
    (told,) = withhold_names([nameless, tell("timed_source", 0.3)])
    assert told.sentence.startswith("An unknown heat at bed. Something at bed without a sure name")
    assert [r.kind for r in told.alternatives] == ["timed_source"] and told.confidence == 0.5
    assert told.patch.to_plain() == tell("timed_source", 0.3).patch.to_plain()


def test_finer_lumps_are_no_finding_that_comes_first() -> None:
    cut = Finding("lumping", "nodes", ("bed",), (), 0.5, {}, "Bed needs 4 lumps.",
                  Patch({"nodes": {"bed": {"lumps": 4}}}), 50.0, 12.0)  # fmt: skip
    assert withhold_names([cut, FIRST])[1] is FIRST


def test_a_room_that_drifts_and_one_that_does_not_stay_are_one_room() -> None:
    course = UnknownHeat(Location(("ambient",), is_held=True), 1.0, 1.0, 50.0, (), (), ())
    room = replace(tell("ambient_drift", 0.5, holds=None), places=("ambient",), patch=Patch({}), course=course)
    drift = replace(tell("ambient_drift", 0.5), places=("ambient",))
    (told,) = withhold_names([room, drift])
    assert told.is_room and told.patch == drift.patch and told.sentence == "Bed is warm. Bed is warm."
    assert len(withhold_names([room, replace(drift, places=("hall",))])) == 2


def test_what_stands_in_for_a_room_is_no_other_finding() -> None:
    course = UnknownHeat(Location(("ambient",), is_held=True), 1.0, 1.0, 50.0, (), (), ())
    room = replace(tell("ambient_drift", 0.5, holds=None), places=("ambient",), patch=Patch({}), course=course)
    (told,) = withhold_names([room, tell("hidden_mass", 0.3)])
    assert told.is_room and told.patch == tell("hidden_mass", 0.3).patch
    assert len(withhold_names([room, tell("hidden_mass", 0.6)])) == 2
