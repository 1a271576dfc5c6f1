"""The first sentence about what was found, whatever it is: effects, lumps, channels, and what has no name."""

from __future__ import annotations

from dataclasses import replace

import pytest
from diagnosed import diagnosed, finding

from network.analysis.diagnosis.findings.finding import UNKNOWN, Finding, Quantity
from network.analysis.diagnosis.findings.result import Diagnosis
from network.report.words.verdict_words import next_words, verdict_words

SIZE = {"power": Quantity(9.0, 1.0, "W")}


def effect(*places: str) -> Finding:
    return finding(kind="windage", places=places, parameters=SIZE, patch={})


def read(kind: str, *channels: str) -> Finding:
    return finding(kind=kind, places=(), channels=channels, parameters=SIZE, patch={})


SPUN, COOLED, NAMELESS = effect("motor"), effect("body", "air"), replace(effect("body"), kind=UNKNOWN)
SLOW, SWAPPED = read("sensor_lag", "T_motor"), read("sensor_swap", "T_motor", "T_body")
OFF, STILL_OFF = read(UNKNOWN, "T_body"), read(UNKNOWN, "T_motor")
CUT = finding(kind="lumping", parameters={}, places=("body",), patch={"nodes": {"body": {"lumps": 10}}})


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    return diagnosed(tmp_path_factory.mktemp("machine"))


@pytest.mark.parametrize(("findings", "told"), [
    ((SPUN,), "test lacks one effect that its recordings show at motor. With it in,"),
    ((SPUN, COOLED), "test lacks two effects that its recordings show, one at motor and one at body. With them in,"),
    ((SPUN, COOLED, SPUN), "test lacks three effects that its recordings show at motor and body. With them in,"),
    ((SPUN, OFF), "test lacks one effect that its recordings show at motor, and something is left at T_body that "
     "nothing in the catalogue explains. With what has a name counted in,"),
    ((NAMELESS, SPUN, COOLED), "test lacks two effects that its recordings show, one at motor and one at body, and "
     "something is left at body that nothing in the catalogue explains. With what has a name counted in,"),
    ((SLOW, SPUN), "test lacks one effect that its recordings show at motor, and T_motor does not read true. With all "
     "that counted in,"),
    ((SPUN, CUT), "test lacks one effect that its recordings show at motor, and is cut too coarsely at body. With all "
     "that counted in,"),
    ((SLOW, STILL_OFF), "In the recordings of test T_motor does not read true, and something is left at T_motor that "
     "nothing in the catalogue explains. With what has a name counted in,"),
    ((SWAPPED, NAMELESS, SPUN), "test lacks one effect that its recordings show at motor, T_motor and T_body do not "
     "read true, and something is left at body that nothing in the catalogue explains. With what"),
])  # fmt: skip
def test_missing_physics_is_told_in_one_sentence(found: Diagnosis, findings: tuple[Finding, ...], told: str) -> None:
    assert verdict_words(replace(found, findings=findings)).startswith(told)


@pytest.mark.parametrize(("verdict", "findings", "told"), [
    ("sensor_fault", (SLOW,), "The physics of test holds; T_motor does not read true. With that counted in,"),
    ("sensor_fault", (SWAPPED, CUT), "The physics of test holds with more lumps at body; T_motor and T_body do not "
     "read true. With that counted in,"),
    ("unexplained", (OFF,), "test and its recordings differ at T_body, and nothing in the catalogue explains it:"),
    ("unexplained", (CUT, OFF), "test and its recordings differ at T_body, also with more lumps at body, and nothing "
     "in the catalogue explains it:"),
    ("too_coarse", (CUT,), "test is cut too coarsely at body. With more lumps there"),
])  # fmt: skip
def test_other_verdicts_tell_lumps_and_channels_apart(
    found: Diagnosis, verdict: str, findings: tuple[Finding, ...], told: str
) -> None:
    assert verdict_words(replace(found, verdict=verdict, findings=findings)).startswith(told)


@pytest.mark.parametrize(
    ("ended", "told"), [("", "nothing else is missing"), ("budget", "whether anything else is missing cannot be told")]
)
def test_finer_lumps_are_the_last_word_only_of_a_search_that_came_to_its_end(
    found: Diagnosis, ended: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("network.report.words.verdict_words._is_untaken", lambda d: False)
    said = verdict_words(replace(found, verdict="too_coarse", findings=(CUT,), ended=ended))
    assert told in " ".join(said.split())


@pytest.mark.parametrize(("ended", "holds"), [("", True), ("budget", False), ("stopped", False)])
def test_physics_hold_beside_a_sensor_only_where_they_were_looked_at(found: Diagnosis, ended: str, holds: bool) -> None:
    d = replace(found, verdict="sensor_fault", findings=(SLOW,), ended=ended)
    assert verdict_words(d).startswith("The physics of test holds; T_motor" if holds else "test: T_motor does not read")
    assert ("Leave the physics of the machine as it is" in next_words(d)) is holds
    assert ("cannot be told so far" in verdict_words(d)) is not holds


@pytest.mark.parametrize(("ended", "is_untried"), [("budget", True), ("", False), ("stopped", False)])
def test_lumps_that_there_was_no_time_for_are_told_as_what_may_be(
    found: Diagnosis, ended: str, is_untried: bool
) -> None:
    d = replace(found, verdict="too_coarse", findings=(), ended=ended, after=found.machine)
    said = verdict_words(d)
    assert said.startswith("test may be cut too coarsely: on finer lumps it could differ by as much") is is_untried
    assert ("nothing more can be told" in said) is is_untried and ("with more time" in next_words(d)) is is_untried
    assert ("The time was up" in said) is (ended == "budget")
