"""A heat that is concealed in a machine that comes along: where it is, and how what is told of it counts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from bench.shipped import SCENARIOS, SECRET, Row, conceal

from network import Machine

BESIDE = {"kind": "foundation", "places": ["bed"]}


def finding(kind: str, place: str, alike: Any = ()) -> dict[str, Any]:
    return {"kind": kind, "places": [place], "confidence": 0.5, "indistinguishable": [*alike]}


@pytest.mark.parametrize(
    ("findings", "score"),
    [
        ([finding("heat_source", "bed")], "right"),
        ([finding("foundation", "bed", [{"kind": "heat_source", "places": ["bed"]}])], "right"),
        ([finding("heat_source", "head", [BESIDE])], "missed"), ([finding("unknown", "bed")], "part"),
        ([finding("sensor_lag", "T"), finding("heat_source", "bed")], "part"), ([], "missed"), (None, "no answer"),
    ],
)  # fmt: skip
def test_a_score_asks_for_the_kind_and_the_place(findings: Any, score: str) -> None:
    told = None if findings is None else {"verdict": "missing_physics", "findings": findings}
    row = Row("mill", "bed", 8, told, 12.3)
    assert row.score == score and f"**{score}**" in str(row) and str(row).endswith("| 12 |")


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_truth_is_the_machine_with_a_heat_at_one_part(name: str, tmp_path: Path) -> None:
    part = conceal(name, tmp_path)
    truth = Machine.load(tmp_path / "truth.yaml")
    assert truth.sources[SECRET].kind == "heat_source" and truth.nodes[part].is_part
