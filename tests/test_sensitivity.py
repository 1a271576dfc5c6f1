"""How much hangs on the settings: how numbers are moved, that they are everywhere, and what the table counts."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from bench import sensitivity
from bench.moved import GROUPS, moved, moved_number
from bench.sensitivity import (
    Outcome,
    answers_of,
    diagnose_all,
    list_changes,
    list_moved,
    make_table,
    outcome,
    read_groups,
    read_seed,
)
from proof.sealed import seal_of

from network.analysis.diagnosis.settings import SETTINGS, Settings

TESTS = Path(__file__).parent
NAMED = "missing_physics"
LOOK = """
from bench.ablated import modules
from bench.moved import moved, put_in_place
from network.analysis.diagnosis.settings import SETTINGS
put_in_place(moved("evidence", 0.5))
held = [m.SETTINGS for m in modules() if hasattr(m, "SETTINGS")]
from network.analysis.diagnosis.steps.forward_selection import Selection, SETTINGS as there
print(len(held) > 20, all(s is there for s in held), there is SETTINGS, there.least, Selection(None).threshold)
"""


@pytest.mark.parametrize(
    ("value", "unit", "less", "more"),
    [(1.1, "χ", 1.07, 1.13), (3.0, "χ/χ", 2.4, 3.6), (0.99, "1", 0.987, 0.993), (0.6, "1", 0.48, 0.72),
     (0.015, "1", 0.0105, 0.0195), (0.5, "1", 0.35, 0.65), (2, "1", 1, 3), (10, "1", 7, 13), (1, "1", 1, 2),
     (12.0, "nats", 8.4, 15.6), (3.0, "1", 2.1, 3.9)],
)  # fmt: skip
def test_numbers_are_moved_where_they_mean_something(value: float, unit: str, less: float, more: float) -> None:
    assert moved_number(value, unit, -0.3) == pytest.approx(less)
    assert moved_number(value, unit, 0.3) == pytest.approx(more)


@pytest.mark.parametrize("share", [-0.3, 0.3])
@pytest.mark.parametrize("group", GROUPS)
def test_a_group_is_moved_whole_and_alone(group: str, share: float) -> None:
    now, told = moved(group, share), SETTINGS.summary()
    for f in fields(Settings):
        before, after = getattr(SETTINGS, f.name), getattr(now, f.name)
        assert (after > before) == (told[f.name]["group"] == group and share > 0)
        assert (after < before) == (told[f.name]["group"] == group and share < 0)
        assert after > 1 if f.metadata["unit"].startswith("χ") else after > 0
        assert not 0 < before < 1 or f.metadata["unit"] != "1" or after < 1


def test_groups() -> None:
    assert GROUPS == ("misfit", "evidence", "belief", "invariants", "priors", "budgets")


def test_all_modules_of_the_diagnosis_have_what_was_moved() -> None:
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(TESTS.parent), str(TESTS)])}
    ran = subprocess.run([sys.executable, "-c", LOOK], capture_output=True, text=True, env=env)
    assert ran.stdout.split() == ["True", "True", "False", "18.0", "18.0"], ran.stderr


def test_what_is_answered_is_not_answered_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def answered(case: Path, way: Any, runs: Any) -> tuple[float, str]:
        asked.append((case.name, way.answers, way.command[2:]))
        return 1.0, "answered"

    monkeypatch.setattr(sensitivity, "diagnose", answered)
    ways = [sensitivity.Way(sensitivity.COMMAND, "out", 7), *list_moved(["belief"], 7)]
    cases = [tmp_path / "case-001", tmp_path / "case-002"]
    (cases[0] / "out").mkdir(parents=True)
    (cases[0] / "out" / "run.json").write_text("{}")
    told = [*diagnose_all(cases, ways, 1)]
    assert len(told) == 5 and ("case-001", "out", ("network.cli",)) not in asked
    assert ("case-002", "out-belief-less", ("bench.moved", "belief", "-0.3")) in asked
    assert ("case-002", "out-belief-more", ("bench.moved", "belief", "0.3")) in asked


def test_what_took_too_long_as_it_is_is_not_moved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, asked = proof(tmp_path, {"out": told("adequate")}, {"out": told("adequate")}), []

    def answered(case: Path, way: Any, runs: Any) -> tuple[float, str]:
        asked.append(case.name)
        return 1.0, "answered"

    monkeypatch.setattr(sensitivity, "diagnose", answered)
    monkeypatch.setattr(sensitivity, "make_cases", lambda *given: ["case-001", "case-002"])
    sensitivity.main(folder, 2, 15.0, 7, ["belief"], 1)
    assert asked == ["case-001", "case-001"] and "1 cases" in capsys.readouterr().out


def told(verdict: str, *kinds: str) -> dict[str, Any]:
    each = [{"kind": kind, "places": ["shaft"], "channels": [], "confidence": 0.9} for kind in kinds]
    return {"verdict": verdict, "findings": each}


def proof(folder: Path, *answers: dict[str, dict[str, Any]]) -> Path:
    """A case that conceals windage and one that conceals nothing, with their answers by folder."""
    keys = [{"class": "effect", "kinds": [["windage"]], "places": [[["shaft"]]]},
            {"class": "innocent", "kinds": [], "places": []}]  # fmt: skip
    seals = {}
    for i, (key, said) in enumerate(zip(keys, answers, strict=True), 1):
        name = f"case-{i:03d}"
        text = json.dumps({"layout": "mill", "in_noise": {"after_calibration": 2.0}, **key})
        (folder / "keys").mkdir(parents=True, exist_ok=True)
        (folder / "keys" / f"{name}.json").write_text(text)
        for where, one in said.items():
            (folder / name / where).mkdir(parents=True)
            (folder / name / where / "diagnosis.json").write_text(json.dumps(one))
            (folder / name / where / "run.json").write_text(json.dumps({"seconds": 10.0 * i, "how": "answered"}))
        seals[name] = {"sha256": seal_of(text)}
    (folder / "cases.json").write_text(json.dumps({"seed": 7, "cases": seals}))
    return folder


def test_the_table_counts_what_changed(tmp_path: Path) -> None:
    less, more = answers_of("belief", "less"), answers_of("belief", "more")
    names, right = ["case-001", "case-002"], told(NAMED, "windage")
    folder = proof(
        tmp_path,
        {"out": right, less: told(NAMED, "lumping", "windage"), more: told(NAMED, "motor_loss")},
        {"out": told("adequate"), less: told(NAMED, "windage")},
    )
    assert outcome(folder, names, "out") == Outcome(0, 1, 0, 15.0)
    assert outcome(folder, names, less) == Outcome(1, 1, 1, 15.0)
    assert outcome(folder, names, more) == Outcome(2, 0, 0, 10.0), "what is not answered has changed"
    table = make_table(folder, names, ["belief"])
    cells = [[*column.cells] for column in table.columns]
    assert cells[0] == ["as they are", "belief"] and [column[1] for column in cells[1:5]] == ["1", "1", "1", "15"]
    assert [column[1] for column in cells[5:]] == ["2", "0", "0", "10"]
    assert [*list_changes(folder, names, ["belief"])] == [
        "belief −30 %, case-002: adequate → missing_physics windage",
        "belief +30 %, case-001: missing_physics windage → missing_physics motor_loss",
        "belief +30 %, case-002: adequate → no answer",
    ]


def test_seeds_for_the_score_and_groups_that_are_none_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="seeds from 1000 on are for the score"):
        read_seed(None, 1000)
    (tmp_path / "cases.json").write_text('{"seed": 12}')
    assert read_seed(tmp_path, None) == 12 and read_seed(None, None) == 7 and read_seed(None, 0) == 0
    with pytest.raises(SystemExit, match="holds cases of seed 12, not of 7"):
        read_seed(tmp_path, 7)
    with pytest.raises(SystemExit, match="no group wishes; there are misfit, "):
        read_groups("misfit,wishes")
    assert read_groups("") == [*GROUPS] and read_groups("belief,misfit") == ["belief", "misfit"]
