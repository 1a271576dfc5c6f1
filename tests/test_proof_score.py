"""The proof's scorer on answers made by hand, each rule where it says right and where it says wrong."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from proof.findings import Member
from proof.judgement import VISIBLE, Judgement
from proof.judging import judge
from proof.rates import Rate
from proof.score import Score, score
from proof.sealed import Broken, seal_of


def key_of(kinds: Any, places: Any, group: str = "effect", **more: Any) -> dict[str, Any]:
    return {"layout": "mill", "truth": "fine", "class": group, "kinds": kinds, "places": places,
            "in_noise": {"after_calibration": 2.0}, **more}  # fmt: skip


def finding(kind: str, *places: str, confidence: float = 0.95, **more: Any) -> dict[str, Any]:
    return {"kind": kind, "places": list(places), "channels": [], "confidence": confidence, **more}


def told(*findings: Mapping[str, Any], verdict: str = "missing_physics", **more: Any) -> dict[str, Any]:
    fit = {"holdout": {"before": {"rmse_in_noise": 3.0}, "after": {"rmse_in_noise": 1.2}}}
    return {"verdict": verdict, "findings": list(findings), "fit": fit, "seconds": 12.0, **more}


PATH = key_of([["conduction"]], [[["sleeve"], ["ram"]]], what="path")
NOTHING = key_of([], [], "innocent", what="coarse")
FAINT = {**PATH, "in_noise": {"after_calibration": VISIBLE / 2}}
BURSTS = key_of([["unknown"]], [[["table"]]], "outside", near=[["timed_source", "heat_source"]], what="bursts")
TWO = key_of([["forced_convection"], ["tilt", "bending"]], [[["head"]], [["tcp.z", "dz"], ["head", "column"]]], "two")
FAN, TILT = finding("forced_convection", "head", "ambient"), finding("bending", "tcp.z", "head")


def outcome(key: Mapping[str, Any], answer: Mapping[str, Any] | None, **run: Any) -> Judgement:
    return judge("case", key, answer, run)


def share(name: str, *judged: Judgement) -> tuple[int, int]:
    rate = Score(judged).rates[name]
    return rate.hits, rate.of


# -- names and places -------------------------------------------------------------------------------------------------
def test_a_path_needs_both_its_ends() -> None:
    right = outcome(PATH, told(finding("conduction", "ram@0.2..0.4", "sleeve")))
    assert right.first and right.placed and right.both and right.besides == 0 and right.right
    assert right.removed == pytest.approx(0.9) and right.seconds == 12 and not right.worse
    half = outcome(PATH, told(finding("conduction", "ram", "bed")))
    assert half.first and not half.placed and not half.both
    wrong = outcome(PATH, told(finding("contact", "ram", "sleeve")))
    assert wrong.placed and not wrong.first and wrong.sure_and_wrong and not wrong.right


def test_the_name_is_that_of_the_first_finding_alone() -> None:
    alike = outcome(PATH, told(finding("contact", "ram", "sleeve", indistinguishable=["conduction"])))
    assert not alike.first and alike.covered and alike.sizes == (2,)
    second = outcome(PATH, told(finding("windage", "rotor"), finding("conduction", "ram", "sleeve")))
    assert not second.first and not second.named and not second.both and second.besides == 1
    finer = outcome(PATH, told(finding("lumping", "bed"), finding("conduction", "ram", "sleeve")))
    assert finer.first and finer.besides == 0


def test_a_visible_effect_called_unknown_is_missed_and_counted() -> None:
    unknown = outcome(PATH, told(finding("unknown", "ram", "sleeve"), verdict="unexplained"))
    silent = outcome(PATH, told(verdict="adequate"))
    named = outcome(PATH, told(finding("conduction", "ram", "sleeve")))
    assert not unknown.first and unknown.unknown and not unknown.sizes and not unknown.silent
    assert unknown.placed and unknown.right and not unknown.sure_and_wrong
    elsewhere = outcome(PATH, told(finding("unknown", "bed"), verdict="unexplained"))
    assert not elsewhere.placed and elsewhere.sure_and_wrong
    assert outcome(PATH, told(finding("unknown", "ram"), verdict="unexplained")).placed
    assert share("visible but called unknown", unknown, silent, named) == (1, 3)
    assert share("visible but nothing said", unknown, silent, named) == (1, 3)
    assert share("first name right", unknown, silent, named) == (1, 3)


def test_besides_is_what_is_named_further_and_is_not_there() -> None:
    right, other = finding("conduction", "ram", "sleeve"), finding("windage", "rotor")
    counts = (
        ([right], 0), ([other], 0), ([right, other], 1), ([other, right], 1), ([other, other], 1), ([right, right], 1),
    )  # fmt: skip
    for findings, besides in counts:
        assert outcome(PATH, told(*findings)).besides == besides, findings


def test_channels_are_places_of_sensor_findings() -> None:
    key = key_of([["sensor_lag"]], [[["T_bed"]]], "sensor")
    lag = {"kind": "sensor_lag", "places": [], "channels": ["T_bed"], "confidence": 0.8}
    assert outcome(key, told(lag, verdict="sensor_fault")).both
    assert not outcome(key, told({**lag, "channels": ["T_ram"]}, verdict="sensor_fault")).placed


def test_what_is_too_faint_need_not_be_named() -> None:
    silent, named = outcome(FAINT, told(verdict="adequate")), outcome(FAINT, told(finding("conduction", "ram")))
    wrong = outcome(FAINT, told(finding("windage", "rotor")))
    assert silent.right and named.right and not wrong.right and wrong.sure_and_wrong
    assert share("first name right", silent, named, wrong) == (0, 0)
    assert share("too faint to ask for: something else named", silent, named, wrong) == (1, 3)


# -- two at once ------------------------------------------------------------------------------------------------------
def test_two_effects_need_two_findings() -> None:
    both = outcome(TWO, told(TILT, FAN))
    assert both.first and both.named and both.placed and both.both and both.besides == 0
    one = outcome(TWO, told(FAN))
    assert one.first and not one.named and not one.placed
    alike = outcome(TWO, told({**FAN, "indistinguishable": ["tilt"]}))
    assert not alike.named and not alike.covered
    swapped = outcome(TWO, told(finding("forced_convection", "bed"), TILT))
    assert swapped.named and not swapped.placed and not swapped.both
    assert share("two at once: both named and placed", both, one, swapped) == (1, 3)


# -- sets -------------------------------------------------------------------------------------------------------------
def test_sets_are_scored_by_what_they_hold_and_by_their_size() -> None:
    def judged(*members: str) -> Judgement:
        return outcome(PATH, told(finding("contact", "ram", "sleeve", set=list(members))))

    wide = judged("contact@ram,sleeve", "conduction@ram@0.2..0.4,sleeve", "radiation@ram,sleeve")
    assert wide.covered and wide.sizes == (3,) and not wide.first
    elsewhere, none = judged("conduction@bed", "contact@ram"), judged("contact@ram,sleeve")
    assert not elsewhere.covered and not none.covered and none.sizes == (1,)
    assert judged("conduction@ram").covered and not judged("conduction@ram,bed").covered
    total = Score((wide, elsewhere, none))
    assert share("truth in the told sets", wide, elsewhere, none) == (1, 3)
    assert share("sets of a single name", wide, elsewhere, none) == (1, 3)
    assert total.figures["members of a set, median"] == 2


def test_members_are_read_from_words_and_from_mappings() -> None:
    assert Member.read("tilt@tcp.z, column@0..0.5") == Member("tilt", frozenset({"tcp.z", "column"}))
    assert Member.read("windage") == Member("windage")
    assert Member.read({"kind": "sensor_lag", "channels": ["T_bed"]}) == Member("sensor_lag", frozenset({"T_bed"}))


# -- innocents --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("verdict", ["adequate", "parameters_only", "too_coarse"])
def test_innocents_may_be_called_coarse_but_not_accused(verdict: str) -> None:
    assert not outcome(NOTHING, told(finding("lumping", "bed"), verdict=verdict)).accused
    accused = outcome(NOTHING, told(finding("radiation", "bed"), verdict=verdict))
    assert accused.accused and accused.sure_and_wrong
    assert outcome(NOTHING, told(verdict="unexplained")).accused


def test_no_answer_is_a_miss_and_accuses_nobody() -> None:
    missed, quiet = outcome(PATH, None, how="no answer in time", seconds=150.0), outcome(NOTHING, None)
    assert not missed.first and not missed.answered and missed.answer == "no answer" and missed.seconds == 150
    assert not quiet.accused and not quiet.right
    failed = outcome(PATH, None, how="failed with status 1", seconds=2.0)
    assert share("no answer in time", missed, quiet, failed) == (2, 3) and share("innocents accused", quiet) == (0, 0)
    assert share("no answer but an error", missed, quiet, failed) == (1, 3)
    assert share("first name right", missed) == (0, 1)


# -- outside the catalogue --------------------------------------------------------------------------------------------
def test_what_lies_outside_may_be_called_unknown_or_near_it_as_a_part() -> None:
    assert outcome(BURSTS, told(finding("unknown", "table"))).both
    part = outcome(BURSTS, told(finding("timed_source", "table", part="part")))
    assert part.both and not part.near_whole and part.besides == 0
    whole = outcome(BURSTS, told(finding("timed_source", "table", part="whole")))
    assert not whole.named and whole.near_whole and whole.sure_and_wrong
    wrong = outcome(BURSTS, told(finding("windage", "table", part="part")))
    assert not wrong.named and not wrong.near_whole and wrong.stray == 1
    elsewhere = outcome(BURSTS, told(finding("unknown", "bed")))
    assert elsewhere.named and not elsewhere.both
    assert share("outside: so, and at its place", part, whole, wrong, elsewhere) == (1, 4)
    assert share("outside: near told as the whole", part, whole, wrong, elsewhere) == (1, 4)


def test_without_a_finding_the_place_is_what_was_located_first() -> None:
    located = {"nodes": [{"name": "table", "probability": 0.9}, {"name": "bed", "probability": 0.1}]}
    assert outcome(BURSTS, told(verdict="unexplained", located=located)).both
    silent = outcome(BURSTS, told(verdict="adequate", located=located))
    assert not silent.named and not silent.placed and silent.silent


def test_a_course_is_laid_beside_the_concealed_heat() -> None:
    t = [60.0 * i for i in range(60)]
    heat = [200.0 if 10 <= i % 30 < 20 else 0.0 for i in range(60)]
    key = {**BURSTS, "course": {"file": "train2.csv", "t": t, "heat": heat}}
    true = {"file": "there/train2.yaml", "t": t, "heat": [0.9 * q + 5 for q in heat]}
    flat = {"file": "train1.csv", "t": t, "heat": t}
    good = outcome(key, told(finding("unknown", "table", course=[flat, true])))
    assert good.course == pytest.approx(1)
    poor = outcome(key, told(finding("unknown", "table", course={**true, "heat": t})))
    assert poor.course is not None and abs(poor.course) < 0.8
    still = {**key, "course": {**key["course"], "heat": [0.1] * len(t)}}
    assert outcome(still, told(finding("unknown", "table", course=[flat, true]))).course is None
    untold = outcome(key, told(finding("unknown", "table", course=[flat])))
    assert untold.course is None and outcome(BURSTS, told(finding("unknown", "table", course=[true]))).course is None
    assert share("outside: course told, correlation ≥ 0.8", good, poor, untold) == (1, 2)


# -- confidence, held out, seconds ------------------------------------------------------------------------------------
def test_the_confidence_is_held_against_what_came_true() -> None:
    right, wrong = finding("conduction", "ram", "sleeve"), finding("windage", "ram")
    judged = [outcome(PATH, told({**each, "confidence": 0.8})) for each in (right, right, right, wrong)]
    assert Score(tuple(judged)).calibration_error == pytest.approx(0.05)
    assert Score((outcome(PATH, told({**wrong, "confidence": 1.0})),)).calibration_error == 1
    assert share("confident (> 0.9) and wrong", *judged) == (0, 0)
    assert share("confident (> 0.9) and wrong", outcome(PATH, told(wrong)), outcome(PATH, told(right))) == (1, 2)


def test_held_out_counts_what_the_written_file_does() -> None:
    honest = outcome(PATH, told(finding("conduction", "ram")), simulated=1.21)
    assert honest.after == 1.21 and honest.overclaimed is False
    boasts = outcome(PATH, told(finding("conduction", "ram")), simulated=3.2)
    assert boasts.overclaimed and boasts.worse and boasts.removed == pytest.approx(-0.1)
    broken = outcome(PATH, told(finding("conduction", "ram")), does_not_run=True)
    modest, claimed = outcome(PATH, told(), simulated=1.1), outcome(PATH, told())
    assert share("claims more than its file does", honest, boasts, broken, modest, claimed) == (2, 4)
    assert share("file and claim differ", honest, boasts, broken, modest, claimed) == (3, 4)
    assert share("held out worse than before", honest, boasts, claimed) == (1, 3)


def test_seconds_are_told_for_one_core_and_for_two() -> None:
    judged = [
        outcome(PATH, told(), seconds=s, seconds_two=two) for s, two in ((40.0, 24.0), (60.0, None), (90.0, None))
    ]
    figures = Score(tuple(judged)).figures
    assert figures["seconds on one core, median"] == 60 and figures["seconds on two cores, median"] == 24
    assert figures["seconds on one core of the same, median"] == 40


# -- intervals --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("hits", "of", "low", "high"),
    [(29, 29, 0.881, 1), (0, 9, 0, 0.336), (0, 59, 0, 0.0606), (10, 10, 0.692, 1), (5, 10, 0.187, 0.813),
     (1, 20, 0.00127, 0.249), (0, 0, 0, 1)],
)  # fmt: skip
def test_intervals_are_those_of_clopper_and_pearson(hits: int, of: int, low: float, high: float) -> None:
    """Against the tables: 10 of 10 means 69.2 % at least, 5 of 10 means 18.7 to 81.3 %."""
    assert (Rate(hits, of).low, Rate(hits, of).high) == pytest.approx((low, high), abs=6e-4)


# -- all of it --------------------------------------------------------------------------------------------------------
def test_classes_are_told_from_the_key_or_from_its_kinds() -> None:
    groups = {
        "conduction": ([["conduction"]], "effect"),
        "two": ([["tilt"], ["windage"]], "two"),
        "coarse": ([], "innocent"),
        "sensor_lag": ([["sensor_lag"]], "sensor"),
        "outside": ([["unknown"]], "outside"),
    }
    for what, (kinds, group) in groups.items():
        judged = outcome(key_of(kinds, [[["bed"]] for _ in kinds], what), told())
        assert (judged.group, judged.what) == (group, what)
    assert outcome(PATH, told()).what == "path"


def test_rates_and_table_say_what_was_judged() -> None:
    both = told(finding("conduction", "ram", "sleeve"), finding("radiation", "bed"))
    answers = [(PATH, both), (PATH, None), (NOTHING, told(verdict="adequate")), (FAINT, told(verdict="adequate")),
               (NOTHING, told(finding("windage", "rotor"))), (BURSTS, told(verdict="unexplained"))]  # fmt: skip
    total = Score(tuple(outcome(*each) for each in answers), 1000, False)
    assert share("something else named besides", *total.judgements) == (1, 2)
    assert share("innocents accused", *total.judgements) == (1, 2)
    assert total.figures["held-out excess removed, median"] == pytest.approx(0.9)
    assert total.confusion["conduction", "conduction + radiation"] == 1 and total.confusion["coarse", "windage"] == 1
    assert total.shares["effect"]["first name right"] == Rate(1, 2) and total.shares["innocent"]["accused"] == Rate(
        1, 2
    )
    text = str(total)
    assert "6 cases of seed 1000, scored: 2 with effects" in text and "1 too faint" in text
    assert "nothing (coarse)" in text and "3.00 → 1.20" in text


def test_the_score_is_told_as_json() -> None:
    total = Score((outcome(PATH, told(finding("conduction", "ram", "sleeve"))), outcome(NOTHING, None)), 3, True)
    read = json.loads(json.dumps(total.summary()))
    rate = read["rates"]["first name right"]
    assert (rate["hits"], rate["of"], rate["share"], rate["high"]) == (1, 1, 1, 1) and rate["low"] == pytest.approx(
        0.025
    )
    assert read["seed"] == 3 and read["development"] is True and read["classes"]["effect"]["right place"]["hits"] == 1
    assert [case["answer"] for case in read["cases"]] == ["conduction", "no answer"] and read["cases"][0]["first"]


# -- in a folder ------------------------------------------------------------------------------------------------------
def sealed_case(folder: Path, name: str, key: Mapping[str, Any]) -> str:
    (folder / "keys").mkdir(exist_ok=True)
    (folder / name / "out").mkdir(parents=True)
    (folder / "keys" / f"{name}.json").write_text(json.dumps(key))
    return seal_of(json.dumps(key))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two cases, the first with an answer."""
    seals = {name: sealed_case(tmp_path, name, key) for name, key in (("case-001", PATH), ("case-002", NOTHING))}
    about = {"seed": 1003, "cases": {name: {"sha256": seal} for name, seal in seals.items()}}
    (tmp_path / "cases.json").write_text(json.dumps(about))
    write(tmp_path / "case-001" / "out", told(finding("conduction", "ram", "sleeve")), seconds=7.0, file_runs=True)
    return tmp_path


def write(where: Path, answer: Mapping[str, Any], **run: Any) -> None:
    where.mkdir(exist_ok=True)
    (where / "diagnosis.json").write_text(json.dumps(answer))
    (where / "run.json").write_text(json.dumps(run))


def test_answers_are_read_beside_their_cases(folder: Path) -> None:
    (folder / "case-001" / "out" / "held_out.json").write_text(json.dumps({"rmse_in_noise": 1.5}))
    first, second = score(folder).judgements
    assert first.answered and first.seconds == 7 and first.simulated == 1.5 and first.overclaimed
    assert not second.answered
    (folder / "case-001" / "out" / "diagnosis.json").write_text("{")
    assert not score(folder).judgements[0].answered
    assert [each.case for each in score(folder, ["case-002"]).judgements] == ["case-002"]


def test_answers_of_other_ways_stand_in_folders_of_their_own(folder: Path) -> None:
    first = folder / "case-001"
    write(first / "out-two-cores", told(finding("conduction", "ram", "sleeve")), seconds=4.0)
    write(first / "out-as-written", told(finding("windage", "ram")), seconds=3.0)
    usual = score(folder).judgements[0]
    assert usual.seconds_two == 4 and usual.same_on_two
    other = score(folder, answers="out-as-written")
    assert other.judgements[0].answer == "windage" and other.judgements[0].seconds_two is None
    write(first / "out-two-cores", told(finding("windage", "ram")), seconds=4.0)
    assert score(folder).judgements[0].same_on_two is False


def test_seeds_say_whether_a_proof_is_for_development(folder: Path) -> None:
    assert score(folder).development is False and "seed 1003, scored" in str(score(folder))
    about = json.loads((folder / "cases.json").read_text())
    (folder / "cases.json").write_text(json.dumps({**about, "seed": 999}))
    assert score(folder).development is True and "seed 999, development" in str(score(folder))


def test_a_changed_key_is_not_scored(folder: Path) -> None:
    (folder / "keys" / "case-001.json").write_text(json.dumps({**PATH, "kinds": [["windage"]]}))
    with pytest.raises(Broken, match="case-001"):
        score(folder)
