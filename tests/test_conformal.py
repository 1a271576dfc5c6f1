"""Conformal sets: quantiles and sets against values made by hand, what calibrates them, and what is refused."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from bench import conformal as bench
from bench.conformal_cases import Refused, explanations_of
from bench.conformal_softening import fit_softening
from bench.sensitivity import read_seed
from diagnosed import diagnosed, finding, rival
from proof.score import READ
from proof.sealed import seal_of

from network.analysis.diagnosis.findings import conformal
from network.analysis.diagnosis.findings.conclusion import _share_belief
from network.analysis.diagnosis.findings.conformal import (
    Calibration,
    Explanation,
    choose,
    fingerprint,
    quantile,
    shipped,
)
from network.analysis.diagnosis.findings.finding import UNKNOWN
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import belief_in_nothing
from network.report.words.diagnosis_words import tell_diagnosis
from network.report.words.finding_words import BENCH, set_words


def by(**quantiles: float) -> Calibration:
    return Calibration(dict.fromkeys(quantiles, 9), quantiles)


def told(*beliefs: float, truth: str = "effect") -> list[Explanation]:
    return [Explanation(f"k{i}@a", truth, b, b) for i, b in enumerate(beliefs)]


# -- quantiles and sets -----------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("count", "rank"), [(9, 9), (10, 10), (18, 18), (19, 18), (20, 19), (99, 90), (109, 99)])
def test_the_quantile_is_the_score_of_its_rank(count: int, rank: int) -> None:
    scores = [(7 * i % count) / count for i in range(count)]
    assert quantile(scores, 0.1) == sorted(scores)[rank - 1]


@pytest.mark.parametrize("count", [0, 1, 8])
def test_too_few_scores_have_no_quantile_below_one(count: int) -> None:
    assert quantile([0.2] * count, 0.1) == 1.0
    few = Calibration.of({"effect": [0.2] * count})
    assert few.least("effect") is None and few.count("effect") == count and few.least("sensor") is None


def test_nine_cases_are_enough() -> None:
    assert Calibration.of({"effect": [0.1 * i for i in range(9)]}).least("effect") == pytest.approx(0.2)


def test_a_set_holds_what_is_believed_enough_the_first_in_front() -> None:
    some = told(0.3, 0.5, 0.15, 0.05)
    assert choose(some, by(effect=0.85)) == ["k0@a", "k1@a", "k2@a"]
    assert choose(some, by(effect=0.6)) == ["k0@a", "k1@a"]
    assert choose(some, by(effect=0.0)) == ["k0@a"], "the first is always told"
    assert choose(some, by(effect=1.0)) == ["k0@a", "k1@a", "k2@a", "k3@a"], "all that was told"


def test_every_class_has_its_own_quantile() -> None:
    nameless = Explanation("unknown@a", "outside", 0.1)
    some = [*told(0.6, 0.2), nameless, *told(0.05, truth="sensor")]
    assert choose(some, by(effect=0.5, outside=0.95, sensor=0.9)) == ["k0@a", "unknown@a"]


def test_what_cannot_be_told_apart_is_told() -> None:
    tied = replace(told(0.45)[0], name="tied@a", is_tied=True)
    assert choose([*told(0.55), tied], by(effect=0.1)) == ["k0@a", "tied@a"]


def test_a_class_without_cases_has_the_smallest_set_with_its_share_of_belief() -> None:
    some = [*told(0.5, 0.3, 0.15, 0.05), Explanation("unknown@a", "outside", 0.4), Explanation("nothing", "null", 0.2)]
    assert choose(some, Calibration()) == ["k0@a", "k1@a", "k2@a"]
    assert choose(some, by(effect=1.0)) == ["k0@a", "k1@a", "k2@a", "k3@a"]
    assert "unknown@a" in choose(some, by(outside=0.7))


def test_a_doubt_whether_it_is_whole_does_not_widen_the_set() -> None:
    doubted = Explanation("k0@a", "effect", 0.96, 0.5)
    assert choose([doubted, *told(0.03, 0.01)[1:]], Calibration()) == ["k0@a"]
    assert choose([Explanation("k0@a", "effect", 0.8, 0.5), *told(0.0, 0.15, 0.05)[1:]], Calibration()) == [
        "k0@a",
        "k1@a",
    ]


# -- what a finding could be ------------------------------------------------------------------------------------------
def test_beliefs_are_shares_that_doubts_do_not_cap() -> None:
    doubted = finding(
        confidence=0.5, doubts=("one run",), share=0.9, holds=0.8, nothing=0.1,
        alternatives=(rival("radiation", "body air", 0.1, 1.0, 3.0),),
    )  # fmt: skip
    beliefs = {e.name: e.belief for e in doubted.explanations}
    names = ["convection@body|air", "unknown@body|air", "nothing", "radiation@body|air"]
    assert [*beliefs] == names and sum(beliefs.values()) == pytest.approx(1)
    assert list(beliefs.values()) == pytest.approx([0.9 * 0.8 * 0.9, 0.9 * 0.2, 0.1, 0.9 * 0.8 * 0.1])
    assert [e.truth for e in doubted.explanations] == ["effect", "outside", "null", "effect"]
    summary = doubted.summary()
    assert [e["name"] for e in summary["beliefs"]] == names and summary["calibrated_on"] == shipped().count("effect")
    assert explanations_of({}, summary) == tuple(doubted.explanations)


def test_classes_of_truth() -> None:
    slow = finding(kind="sensor_lag", places=(), channels=("T_body",))
    cut = finding(kind="lumping", alternatives=(), parameters={}, patch={"nodes": {"body": {"lumps": 5}}})
    of = [f.truth for f in (slow, cut, finding(), finding(kind=UNKNOWN))]
    assert of == ["sensor", "null", "effect", "outside"]
    assert cut.members == ["lumping@body|air"]


def test_what_has_no_name_is_no_rival_of_itself() -> None:
    nameless = finding(kind=UNKNOWN, alternatives=(), share=0.9, nothing=0.0).weigh(0.7)
    beliefs = {e.name: e.belief for e in nameless.explanations}
    assert beliefs == {"unknown@body|air": pytest.approx(0.63), "nothing": 0.0}


@pytest.mark.parametrize(("holds", "nameless"), [(0.2, 0.8), (0.7, 0.5)])
def test_what_has_no_name_and_names_share_the_belief(holds: float, nameless: float) -> None:
    unknown, name = finding(kind=UNKNOWN, alternatives=(), share=0.9), finding(alternatives=(), share=1.0, holds=holds)
    fault = finding(kind="sensor_fault", places=(), channels=("T_body",), alternatives=(), share=0.98)
    shared = [f.explanations[0].belief for f in _share_belief([unknown, name, fault])]
    assert shared == pytest.approx([0.9 * nameless, 1 - nameless, 0.98])
    assert _share_belief([name, fault]) == [name, fault] and _share_belief([unknown, fault]) == [unknown, fault]


def test_chance_is_believed_in_where_little_was_gained() -> None:
    T = SETTINGS.softening
    assert belief_in_nothing(0.0, 1.0) == 0.5 and belief_in_nothing(math.inf, 1.0) == 0.0
    assert belief_in_nothing(3 * T, 0.9) == pytest.approx(1 / (1 + math.e**3))
    assert belief_in_nothing(3 * T, 2.0) == pytest.approx(1 / (1 + math.e**0.75))


# -- what is shipped --------------------------------------------------------------------------------------------------
def test_what_is_shipped_says_what_it_was_made_of() -> None:
    text = Path(conformal.__file__).with_name(conformal.FILE).read_text(encoding="utf-8")
    there = json.loads(text)
    assert [*there["classes"]] == [*conformal.CLASSES] and there["alpha"] == pytest.approx(1 - SETTINGS.covered)
    assert all(seed < 1000 for seed in there["seeds"])
    assert Calibration.read(there).summary() == there


def test_calibrated_under_other_settings_it_counts_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    other = replace(SETTINGS, softening=5.0)
    assert fingerprint(other) != fingerprint(SETTINGS) == fingerprint(replace(SETTINGS))
    monkeypatch.setattr(conformal, "SETTINGS", other)
    assert shipped.__wrapped__() == Calibration()


def test_the_report_tells_the_set_and_whence_confidence_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = finding(share=0.9, holds=0.95, nothing=0.0)
    assert set_words(finding(alternatives=())) == ""
    for module in ("network.analysis.diagnosis.findings.finding", "network.report.words.finding_words"):
        monkeypatch.setattr(f"{module}.shipped", lambda: by(effect=0.99, outside=1.0, null=0.0))
    assert set_words(found) == (
        "By the bench it is one of these: convection (body, air), something without a name (body, air) or radiation "
        "(body, air)."
    )
    terminal = " ".join(tell_diagnosis(diagnosed(tmp_path, findings=(found, found))).split())
    assert terminal.count("By the bench it is one of these") == 2 and terminal.count(BENCH) == 1
    assert BENCH not in " ".join(tell_diagnosis(diagnosed(tmp_path, "adequate", findings=())).split())


# -- the command ------------------------------------------------------------------------------------------------------
def key(group: str, kind: str = "windage", place: str = "shaft", visible: float = 2.0) -> dict[str, Any]:
    kinds, places = ([], []) if group == "innocent" else ([[kind]], [[[place]]])
    return {"class": group, "kinds": kinds, "places": places, "in_noise": {"after_calibration": visible}}


def answer(*beliefs: tuple[str, str, float], verdict: str = "missing_physics", **more: Any) -> dict[str, Any]:
    each = [{"name": n, "class": c, "belief": b, "confidence": b, "tied": False} for n, c, b in beliefs]
    found = [{"kind": beliefs[0][0].partition("@")[0], "beliefs": each}] if beliefs else []
    return {"verdict": verdict, "findings": found, **more}


def proof(folder: Path, cases: Sequence[tuple[Mapping[str, Any], Any]], seed: int = 12) -> Path:
    """A folder of cases that are answered; None: one that is not."""
    (folder / "keys").mkdir(parents=True)
    seals = {}
    for i, (of, said) in enumerate(cases, 1):
        name, text = f"case-{i:03d}", json.dumps(of)
        (folder / "keys" / f"{name}.json").write_text(text)
        (folder / name / "out").mkdir(parents=True)
        if said is not None:
            (folder / name / "out" / "diagnosis.json").write_text(json.dumps(said))
        seals[name] = {"sha256": seal_of(text)}
    (folder / "cases.json").write_text(json.dumps({"seed": seed, "development": seed < 1000, "cases": seals}))
    return folder


RIGHT = answer(("windage@shaft", "effect", 0.9), ("motor_loss@shaft", "effect", 0.1))
SECOND = answer(("motor_loss@shaft", "effect", 0.7), ("windage@shaft", "effect", 0.3))
WRONG = answer(("conduction@shaft|bed", "effect", 0.95), ("unknown@shaft|bed", "outside", 0.05))
SILENT = answer(verdict="adequate")
ODD = key("outside", "unknown")


def test_cases_calibrate_and_are_left_out_in_turn(tmp_path: Path) -> None:
    effects = [(key("effect"), RIGHT)] * 18 + [(key("effect"), SECOND)] * 2
    rest = [(key("innocent"), SILENT)] * 3 + [(ODD, WRONG), (key("effect"), None), (key("effect", visible=0.2), SILENT)]
    found = bench.collect([proof(tmp_path / "p", [*effects, *rest])])
    assert found.left_out == {"not answered": 1, "too faint to be asked for": 1} and len(found.cases) == 24
    by = bench.calibrate(found)
    assert by.counts == {"null": 3, "effect": 20, "sensor": 0, "outside": 1} and by.seeds == (12,)
    assert by.quantiles["effect"] == pytest.approx(0.7), "the 19th of 20"
    null, effect, sensor, outside = bench.rows(found)
    assert effect[:5] == ("effect", "20", "20", "0.7", "cases") and effect[6:] == ("1", "100 %")
    assert effect[5].startswith("18 of 20 (90 %"), "without one of the two the 18th of 19 is a right one"
    assert null[3:5] == ("–", "belief") and null[5].startswith("3 of 3") and sensor[1] == "0"
    assert outside[2] == "1" and outside[5].startswith("0 of 1"), "what has no name is told where cases call for it"


def test_a_truth_that_is_not_told_is_not_in_the_set(tmp_path: Path) -> None:
    cases = [(key("effect"), SILENT)] * 2 + [(key("effect"), RIGHT)] * 10 + [(key("innocent"), RIGHT)]
    found = bench.collect([proof(tmp_path / "p", cases)])
    assert [t.score for t in found.truths[:3]] == pytest.approx([1, 1, 0.1]) and found.truths[-1].score == 1
    (row,) = [r for r in bench.rows(found) if r[0] == "effect"]
    assert row[1:4] == ("12", "10", "1") and row[5].startswith("10 of 12") and row[6] == "2"


def test_each_of_two_effects_is_looked_for(tmp_path: Path) -> None:
    two = {**key("two"), "kinds": [["windage"], ["sensor_lag"]], "places": [[["shaft"]], [["T_bed"]]]}
    both = {**RIGHT, "findings": [*RIGHT["findings"], *answer(("sensor_lag@T_bed", "sensor", 0.8))["findings"]]}
    found = bench.collect([proof(tmp_path / "p", [(two, both)])])
    assert [(t.kind, round(t.score, 9)) for t in found.truths] == [("effect", 0.1), ("sensor", 0.2)]


@pytest.mark.parametrize("seed", [1000, 4711])
def test_cases_for_the_score_are_refused(tmp_path: Path, seed: int) -> None:
    with pytest.raises(Refused, match=f"of seed {seed}: from 1000 on cases are for the score"):
        bench.collect([proof(tmp_path / "p", [(key("effect"), RIGHT)], seed)])
    with pytest.raises(Refused, match="holds no proof"):
        bench.collect([tmp_path])


def test_cases_of_a_score_that_was_read_since_are_for_development(tmp_path: Path) -> None:
    folder = proof(tmp_path / "p", [(key("effect"), RIGHT)], max(READ))
    assert bench.collect([folder]).seeds == {max(READ)} and read_seed(None, max(READ)) == max(READ)


def test_answers_under_other_settings_and_the_same_case_again_are_left_out(tmp_path: Path) -> None:
    other = {**RIGHT, "settings": {"softening": {"value": 9.0}}}
    same = {**RIGHT, "settings": SETTINGS.summary() | {"gone": {"value": 1.0}}}
    folders = [proof(tmp_path / name, [(key("effect"), other), (key("effect"), same)]) for name in "ab"]
    found = bench.collect(folders)
    assert found.left_out == {"answered under other settings": 2, "there twice": 1} and len(found.truths) == 1


def test_answers_without_beliefs_tell_them_by_their_rivals(tmp_path: Path) -> None:
    rivals = [{"kind": "motor_loss", "places": ["shaft"], "channels": [], "confidence": 0.2}]
    old = {"kind": "windage", "section": "sources", "places": ["shaft"], "channels": [], "confidence": 0.5,
           "parameters": {"power": 1}, "alternatives": rivals, "indistinguishable": rivals, "doubts": [],
           "sentence": "", "evidence": {"delta_log_evidence": None}}  # fmt: skip
    said = {"verdict": "missing_physics", "findings": [old], "located": {"nodes": []},
            "left": {"share_explained": 0.9, "rmse_in_noise": {"train": 1.0}}}  # fmt: skip
    (truth,) = bench.collect([proof(tmp_path / "p", [(key("effect"), said)])]).truths
    beliefs = {e.name: round(e.belief, 9) for e in truth.told.explanations}
    assert beliefs == {"windage@shaft": 0.72, "motor_loss@shaft": 0.18, "unknown@shaft": 0.1, "nothing": 0.0}


def test_what_is_written_is_what_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = proof(tmp_path / "p", [(key("effect"), RIGHT)] * 9 + [(key("innocent"), SILENT)])
    monkeypatch.setattr(bench, "SHIPPED", tmp_path / "conformal.json")
    bench.main([folder], "out", is_written=False)
    assert not (tmp_path / "conformal.json").exists()
    bench.main([folder], "out", is_written=True)
    there = Calibration.read(json.loads((tmp_path / "conformal.json").read_text()))
    assert there.settings == fingerprint(SETTINGS) and there.least("effect") == pytest.approx(0.9)
    assert there.count("null") == 1 and there.least("null") is None and there.seeds == (12,)


def test_the_softening_that_cases_like_best(tmp_path: Path) -> None:
    """Of names that are e² to 1 at T₀ and right three times of four, T solves e^(2 T₀/T) = 3."""
    odds = 1 / (1 + math.e**2)
    often = answer(("windage@shaft", "effect", 1 - odds), ("motor_loss@shaft", "effect", odds))
    less = answer(("motor_loss@shaft", "effect", 1 - odds), ("windage@shaft", "effect", odds))
    found = bench.collect([proof(tmp_path / "p", [(key("effect"), often)] * 3 + [(key("effect"), less)])])
    best = fit_softening(found.truths)
    assert best is not None and best.nats == pytest.approx(2 * SETTINGS.softening / math.log(3), rel=1e-3)
    assert (best.count, best.first) == (4, 3) and best.loss < best.loss_now
    assert "4 truths named among others, 3 of them first: 7.28 nats" in bench.softening_words(found)
    assert fit_softening([]) is None
