"""Baselines of the proof: they name what is plainly there, and the scorer of the proof counts them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bench.baselines import __main__ as baselines
from bench.baselines.evidence import white_evidence
from bench.baselines.given import Given
from bench.baselines.residual import largest_residual
from bench.baselines.sindy import balance, terms_of
from fits import ANOTHER, USUAL, recorded, speeds, two_blocks
from proof.sealed import seal_of

from network.platform.refusal import Failed

HIDDEN = {"pump": {"kind": "heat_source", "into": {"body": 1}, "power": "150 W", "with": "always"}}
DRAG = {"drag": {"kind": "windage", "into": {"motor": 1}, "power": "600 W", "reference_speed": "8000 rpm"}}


def given(**concealed: Any) -> Given:
    """The machine as written, and what it did with something concealed in it."""
    true = two_blocks(**concealed)
    return Given(two_blocks(), tuple(recorded(true, speeds(*s), i) for i, s in enumerate((USUAL, ANOTHER))))


def test_the_largest_residual_names_a_source_where_it_is_too_warm() -> None:
    (finding,) = largest_residual(given(sources=HIDDEN))["findings"]
    assert (finding["kind"], finding["places"]) == ("heat_source", ["body"])
    assert largest_residual(given()) == {"verdict": "adequate", "findings": []}


def test_white_evidence_names_what_fits_best_and_nothing_where_nothing_gains() -> None:
    named = white_evidence(given(sources=HIDDEN))
    (finding,) = named["findings"]
    assert finding["kind"] == "heat_source" and "body" in finding["places"] and finding["confidence"] > 0.99
    assert white_evidence(given())["verdict"] in ("adequate", "missing_physics", "sensor_fault")


def test_a_heat_balance_closes_with_the_terms_of_the_file() -> None:
    """C dT/dt of the body = 12 W/K (T_motor − T_body) + 7 W/K (T_air − T_body)."""
    of = given()
    heat, terms = balance(of, "body")
    own = [*terms_of(of.machine, "body")]
    assert [kind for kind, _ in own] == ["conduction", "convection"]
    G, *_ = np.linalg.lstsq(np.stack([terms[t] for t in own], axis=1), heat, rcond=None)
    assert pytest.approx([12, 7], rel=0.1) == G


@pytest.mark.parametrize(("concealed", "kind", "place"), [(HIDDEN, "heat_source", "body"), (DRAG, "windage", "motor")])
def test_pysindy_names_a_term_that_the_file_has_not(concealed: Any, kind: str, place: str) -> None:
    """Both parts are sensed here."""
    pytest.importorskip("pysindy")
    from bench.baselines.sindy import by_sindy

    (finding,) = by_sindy(given(sources=concealed))["findings"]
    assert (finding["kind"], finding["places"]) == (kind, [place])


# -- the table --------------------------------------------------------------------------------------------------------
@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A case with nothing concealed, without files: a way has to do with its name."""
    key = json.dumps({"layout": "mill", "truth": "fine", "class": "innocent", "kinds": [], "places": [],
                      "in_noise": {"after_calibration": 0}})  # fmt: skip
    for name in ("keys", "case-001"):
        (tmp_path / name).mkdir()
    (tmp_path / "keys" / "case-001.json").write_text(key)
    (tmp_path / "cases.json").write_text(json.dumps({"seed": 5, "cases": {"case-001": {"sha256": seal_of(key)}}}))
    return tmp_path


def test_every_way_is_a_row_and_lptn_where_it_answered(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails(of: Given) -> dict[str, Any]:
        raise Failed("does not converge")

    ways = {"accuses": lambda of: {"verdict": "missing_physics", "findings": [{"kind": "tilt"}]}, "fails": fails}
    monkeypatch.setattr(baselines, "WAYS", ways)
    monkeypatch.setattr(baselines.Given, "load", lambda case: None)
    words = ["--cases", "1", "--seed", "5", "--folder", str(folder)]
    baselines.main(words)
    told = capsys.readouterr().out
    assert "accuses" in told and "1/1 (2–100 %)" in told and "fails" in told and "lptn" not in told
    assert "does not converge" in (folder / "case-001" / "out-fails" / "run.json").read_text()
    (folder / "case-001" / "out").mkdir()
    (folder / "case-001" / "out" / "diagnosis.json").write_text(json.dumps({"verdict": "adequate", "findings": []}))
    baselines.main(words)
    assert "lptn" in capsys.readouterr().out


def test_other_seeds_are_refused_and_a_missing_pysindy_is_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="holds cases of seed 5, not of 6"):
        baselines.main(["--cases", "1", "--seed", "6", "--folder", str(folder)])
    monkeypatch.setattr(
        baselines, "WAYS", {"PySINDy": None, "quiet": lambda of: {"verdict": "adequate", "findings": []}}
    )
    monkeypatch.setattr(baselines.Given, "load", lambda case: None)
    monkeypatch.setattr(baselines, "find_spec", lambda name: None)
    baselines.main(["--cases", "1", "--seed", "5", "--folder", str(folder)])
    told = capsys.readouterr()
    assert "PySINDy is left out" in told.err and "PySINDy" not in told.out and "quiet" in told.out
