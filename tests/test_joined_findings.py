"""One thing is told once, with all that it takes in the machine."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding, Quantity
from network.analysis.diagnosis.findings.invariants import MAY_BE_ONE
from network.analysis.diagnosis.findings.joined_findings import NOT_ALL, join_alike, join_rests
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.patch import Patch


def tell(kind: str, confidence: float, name: str = "warm", **more: object) -> Finding:
    patch = Patch({"sources": {name: {"kind": kind}}}) if kind != UNKNOWN else Patch({})
    told = Finding(kind, "sources", ("bed",), (), confidence, {}, "Bed is warm.", patch, 50.0, 12.0)
    return replace(told, **more)  # type: ignore[arg-type]


def test_two_of_one_kind_at_one_place_are_one_thing_of_another_form() -> None:
    first = tell("timed_source", 0.9, doubts=(MAY_BE_ONE,))
    again = tell(
        "timed_source", 0.3, "later", sentence="Bed is hot.", doubts=("its power stands at its bound", MAY_BE_ONE)
    )
    (told,) = join_alike([first, again])
    assert {*told.patch["sources"]} == {"warm", "later"} and told.sentence == "Bed is warm. Bed is hot."
    assert (told.part, told.confidence) == ("part", SETTINGS.barred)
    assert told.doubts == ("its power stands at its bound", NOT_ALL)
    (more,) = join_alike([first, again, again])
    assert more.doubts == told.doubts
    elsewhere = replace(again, places=("column",))
    assert join_alike([first, elsewhere]) == [first, elsewhere]


def test_what_a_fault_of_a_channel_leaves_there_is_the_fault() -> None:
    fault = tell("sensor_fault", 0.9, places=(), channels=("T_bed",))
    left = tell(UNKNOWN, 0.5, places=("bed",), channels=("T_bed",))
    (told,) = join_alike([fault, left])
    assert (told.kind, told.part) == ("sensor_fault", "part")
    assert len(join_alike([fault, replace(left, channels=("T_head",))])) == 2


def test_what_has_no_sure_name_in_the_part_that_a_mended_channel_reads_is_what_the_fault_leaves() -> None:
    """With its numbers in the machine, its sentence and its names; not in another part, nor with a name, nor what is
    not in the machine; and not of a fault that has no size, that is one name among others, or has none itself."""
    size = {"share": Quantity(0.3, 0.1, "1")}
    fault = tell("sensor_fault", 0.9, "gone", places=(), channels=("T_bed",), parameters=size)
    left = replace(tell("timed_source", 0.3, sentence="It is left."), kind=UNKNOWN, doubts=("it is small",))

    def reads(channels: Iterable[str]) -> list[str]:
        return [name.removeprefix("T_") for name in channels]

    (told,) = join_rests([fault, left], reads)
    assert (told.kind, told.part, told.sentence) == ("sensor_fault", "part", "Bed is warm. It is left.")
    assert told.confidence == fault.confidence > SETTINGS.barred
    assert {*told.patch["sources"]} == {"gone", "warm"} and told.doubts == (NOT_ALL,)
    others = [replace(left, places=("head",)), tell("timed_source", 0.3), replace(left, patch=Patch({}))]
    others += [replace(left, places=(), channels=("T_head",))]
    for other in others:
        assert join_rests([fault, other], reads) == [fault, other]
    faults = [replace(fault, parameters={}), replace(fault, holds=0.4), replace(fault, kind=UNKNOWN)]
    for other in faults:
        assert join_rests([other, left], reads) == [other, left]


def test_heat_without_a_name_beside_a_name_in_its_part_stays() -> None:
    findings = [tell(UNKNOWN, 0.5), tell("timed_source", 0.5)]
    assert join_alike(findings) == findings == join_alike(findings[:0]) + findings


def test_a_law_in_the_place_of_what_was_found_is_told_alone_with_its_numbers() -> None:
    law = tell("forced_convection", 0.5, "skin", doubts=(MAY_BE_ONE,), parameters={"gain": 5}, share=0.97, holds=1.0)
    plain = replace(law, kind="convection", confidence=0.3, parameters={"conductance": 6})
    (told,) = join_alike([plain, law])
    assert (told.kind, told.part, told.confidence, told.gain) == ("forced_convection", "whole", 0.97, 100.0)
    assert told.parameters == {"conductance": 6, "gain": 5} and not told.doubts
    (part,) = join_alike([replace(plain, doubts=("it is small",)), law])
    assert part.confidence == 0.5 and part.doubts == ("it is small",)
    more = Patch({"sources": {**law.patch["sources"], "more": {"kind": "convection"}}})
    (both,) = join_alike([replace(plain, patch=more), law])
    assert {*both.patch["sources"]} == {"skin", "more"}


def test_what_changes_an_entry_that_was_found_and_is_no_law_of_it_stays() -> None:
    """A mass on the way of a heat, copper that warms beside a motor."""
    heat, law = tell("heat_source", 0.5), tell("forced_convection", 0.5, "other")
    mass = replace(heat, kind="interposed_mass")
    assert join_alike([heat, mass]) == [heat, mass] and join_alike([heat, law]) == [heat, law]
    elsewhere = replace(tell("forced_convection", 0.5), places=("column",))
    assert join_alike([heat, elsewhere]) == [heat, elsewhere]
