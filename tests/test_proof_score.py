"""The proof's scorer on answers made by hand, and the command that runs a proof."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from proof import cases, programs
from proof.cases import make_cases
from proof.judging import Judgement, judge
from proof.score import Rate, Score, answer, score

from network import proving
from network.refusal import Refused


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three cases of short recordings."""
    folder = tmp_path_factory.mktemp("proof")
    make_short(folder, 3, 7)
    return folder


def make_short(folder: Path, count: int, seed: int, jobs: int = 1) -> list[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(programs, "HOURS", (0.5, 0.5, 0.5, 0.5))
        return make_cases(folder, count, seed, jobs)


# -- the scorer -------------------------------------------------------------------------------------------------------
def key_of(kinds: Any, places: Any, what: str = "single") -> dict[str, Any]:
    return {"layout": "mill", "truth": "fine", "class": what, "kinds": kinds, "places": places,
            "in_noise": {"after_calibration": 2.0}}  # fmt: skip


def finding(kind: str, *places: str, confidence: float = 0.95, **more: Any) -> dict[str, Any]:
    return {"kind": kind, "places": list(places), "channels": [], "confidence": confidence, **more}


def told(*findings: Mapping[str, Any], verdict: str = "missing_physics", **more: Any) -> dict[str, Any]:
    fit = {"holdout": {"before": {"rmse_in_noise": 3.0}, "after": {"rmse_in_noise": 1.2}}}
    return {"verdict": verdict, "findings": list(findings), "fit": fit, "seconds": 12.0, **more}


PATH = key_of([["conduction"]], [[["sleeve"], ["ram"]]])
NOTHING = key_of([], [], "coarse")
BURSTS = key_of([["unknown"]], [[["table"]]], "outside")
TWO = key_of([["forced_convection"], ["tilt", "bending"]], [[["head"]], [["tcp.z", "dz"], ["head", "column"]]])


def outcome(key: Mapping[str, Any], answer: Mapping[str, Any] | None) -> Judgement:
    return judge("case", key, answer)


def test_a_path_needs_both_its_ends() -> None:
    right = outcome(PATH, told(finding("conduction", "ram@0.2..0.4", "sleeve")))
    assert right.named and right.placed and right.both and right.first and right.spurious == 0
    assert right.removed == pytest.approx(0.9) and right.seconds == 12 and not right.worse
    half = outcome(PATH, told(finding("conduction", "ram", "bed")))
    assert half.named and not half.placed and not half.both
    wrong = outcome(PATH, told(finding("contact", "ram", "sleeve")))
    assert wrong.placed and not wrong.named and wrong.sure_and_wrong and wrong.spurious == 1


def test_what_cannot_be_told_apart_counts_as_named() -> None:
    for alike in (["conduction"], [{"kind": "conduction", "places": []}]):
        assert outcome(PATH, told(finding("contact", "ram", "sleeve", indistinguishable=alike))).both


def test_the_right_name_second_is_named_but_not_first() -> None:
    judged = outcome(PATH, told(finding("windage", "rotor"), finding("conduction", "ram", "sleeve")))
    assert judged.named and judged.both and not judged.first and judged.spurious == 1
    finer = outcome(PATH, told(finding("lumping", "bed"), finding("conduction", "ram", "sleeve")))
    assert finer.first and finer.spurious == 0


def test_two_effects_need_two_findings() -> None:
    fan, tilt = finding("forced_convection", "head", "ambient"), finding("bending", "tcp.z", "head")
    assert outcome(TWO, told(tilt, fan)).both
    assert not outcome(TWO, told(fan)).named
    assert not outcome(TWO, told(finding("forced_convection", "head", indistinguishable=["tilt"]))).named


def test_channels_are_places_of_sensor_findings() -> None:
    key = key_of([["sensor_lag"]], [[["T_bed"]]])
    lag = {"kind": "sensor_lag", "places": [], "channels": ["T_bed"], "confidence": 0.8}
    assert outcome(key, told(lag, verdict="sensor_fault")).both


@pytest.mark.parametrize("verdict", ["adequate", "parameters_only", "too_coarse"])
def test_innocents_may_be_called_coarse_but_not_accused(verdict: str) -> None:
    assert not outcome(NOTHING, told(finding("lumping", "bed"), verdict=verdict)).accused
    assert outcome(NOTHING, told(finding("radiation", "bed"), verdict=verdict)).accused
    assert outcome(NOTHING, told(verdict="unexplained")).accused


def test_what_lies_outside_may_be_called_unexplained_or_unknown() -> None:
    assert outcome(BURSTS, told(finding("unknown", "table"))).both
    located = {"nodes": [{"name": "table", "probability": 0.9}, {"name": "bed", "probability": 0.1}]}
    unexplained = outcome(BURSTS, told(verdict="unexplained", located=located))
    assert unexplained.named and unexplained.placed and unexplained.first
    guessed = outcome(BURSTS, told(finding("timed_source", "table")))
    assert not guessed.named and guessed.spurious == 1 and guessed.sure_and_wrong


def test_no_answer_is_a_miss() -> None:
    missed = outcome(PATH, None)
    assert not missed.named and not missed.answered and missed.answer == "no answer"
    assert not outcome(NOTHING, None).accused


def test_rates_and_table_say_what_was_judged() -> None:
    both = told(finding("conduction", "ram", "sleeve"), finding("radiation", "bed"))
    answers = [(PATH, both), (PATH, None), (NOTHING, told(verdict="adequate")),
               (NOTHING, told(finding("windage", "rotor"))), (BURSTS, told(verdict="unexplained"))]  # fmt: skip
    total = Score(tuple(outcome(*each) for each in answers))
    rates = total.rates
    assert (rates["right name"].hits, rates["right name"].of) == (1, 2)
    assert (rates["something else named besides"].hits, rates["something else named besides"].of) == (1, 2)
    assert (rates["innocents accused"].hits, rates["innocents accused"].of) == (1, 2)
    assert (rates["outside called unknown"].hits, rates["outside placed right"].hits) == (1, 0)
    assert rates["no answer"].hits == 1 and total.removed == pytest.approx(0.9)
    assert total.confusion["conduction", "conduction + radiation"] == 1 and total.confusion["coarse", "windage"] == 1
    text = str(total)
    assert "5 cases: 2 with effects" in text and "nothing (coarse)" in text and "3.00 → 1.20" in text


def test_wilson_bounds_are_those_of_the_book() -> None:
    """0 of 30: 11.4 % at the most; 15 of 20: 53 to 89 %."""
    assert Rate(0, 30).bound(1) == pytest.approx(0.1135, abs=1e-3)
    assert (Rate(15, 20).bound(-1), Rate(15, 20).bound(1)) == pytest.approx((0.531, 0.888), abs=1e-3)
    assert (Rate(0, 0).bound(-1), Rate(0, 0).bound(1)) == (0, 1)


def test_answers_are_read_beside_their_cases(made: Path) -> None:
    out = made / "case-001" / "out"
    assert answer(made / "case-001") is None and not any(each.answered for each in score(made).judgements)
    out.mkdir()
    (out / "diagnosis.json").write_text(json.dumps(told(verdict="adequate")))
    assert [each.answered for each in score(made, {"case-001": 3.0}).judgements] == [True, False, False]
    (out / "diagnosis.json").write_text("{")
    assert answer(made / "case-001") is None


# -- the command's part -----------------------------------------------------------------------------------------------
DIAGNOSE = """
import json, pathlib, sys, time
assert sys.argv[1:] == "diagnose machine.yaml train1.csv train2.csv train3.csv \\
--holdout holdout.csv -o out --no-plots --jobs 1 --seed 5".split()
name = pathlib.Path.cwd().name
pathlib.Path("out").mkdir()
pathlib.Path("out/diagnosis.json").write_text(json.dumps({"verdict": "adequate", "findings": []}))
if name == "case-002":
    time.sleep(60)
sys.exit(3 if name == "case-003" else 0)
"""


def test_prove_makes_runs_and_scores(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "diagnose.py").write_text(DIAGNOSE)
    monkeypatch.setattr(proving, "COMMAND", (sys.executable, str(tmp_path / "diagnose.py")))
    monkeypatch.setattr(proving.diagnose, "__defaults__", (1.0,))
    monkeypatch.setattr(cases, "make_cases", make_short)
    said: list[str] = []
    total = proving.prove(3, 5, 1, tmp_path / "cases", lambda *told: said.append("{}/{} {}".format(*told)))
    assert [each.answered for each in total.judgements] == [True, False, False]
    assert said[0].startswith("1/3 case-001: answered after") and "no answer in time" in said[1]
    assert "failed with status 3" in said[2]


def test_prove_is_refused_outside_a_clone_and_over_other_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(Refused, match="something else"):
        proving.prove(1, 0, 1, tmp_path)
    monkeypatch.setattr(proving, "TESTS", tmp_path)
    with pytest.raises(Refused, match="clone the repository"):
        proving.prove(1, 0, 1, tmp_path / "new")
