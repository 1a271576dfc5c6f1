"""Entries that are taken out of machines that come along: which can be, and how what is told of them counts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from bench.taken_out import Entry, Row, diagnose, list_entries, record

from network.catalogue.declaration.entry_path import EntryPath
from network.platform.process_groups import Groups

BEARING = Entry("mill", EntryPath("links", "", "rear bearing"), "conduction", frozenset({"shaft", "housing"}))


def finding(kind: str, *places: str, alike: Any = ()) -> dict[str, Any]:
    return {"kind": kind, "places": [*places], "confidence": 0.5, "indistinguishable": [*alike]}


BOTH = finding("conduction", "shaft", "housing")


@pytest.mark.parametrize(
    ("findings", "verdict", "score"),
    [
        ([BOTH], "missing_physics", "right"),
        ([finding("contact", "shaft", "bed", alike=[BOTH])], "missing_physics", "right"),
        ([finding("conduction", "shaft", "bed")], "missing_physics", "part"),
        ([finding("unknown", "bed"), BOTH], "unexplained", "part"),
        ([finding("unknown", "bed")], "unexplained", "missed"), ([], "adequate", "silent"),
        ([], "parameters_only", "silent"), (None, "", "no answer"),
    ],
)  # fmt: skip
def test_a_score_asks_for_the_kind_and_all_its_parts(findings: Any, verdict: str, score: str) -> None:
    row = Row(BEARING, None if findings is None else {"verdict": verdict, "findings": findings}, 12.3)
    assert row.score == score and str(row).startswith("| mill | links.rear bearing | conduction |")


def test_an_axis_is_no_part() -> None:
    grows = Entry("mill", EntryPath("tcp", "z", "housing grows"), "stretching", frozenset({"housing"}))
    told = {"verdict": "missing_physics", "findings": [finding("stretching", "tcp.z", "housing")]}
    assert Row(grows, told, 1.0).score == "right"
    assert Row(grows, {**told, "findings": [finding("stretching", "tcp.z", "shaft")]}, 1.0).score == "missed"


def test_what_others_stand_on_stays() -> None:
    """Without its only movement along z the sensor of it measures nothing."""
    told = {str(e.path): e for e in list_entries("table_bending")}
    assert {*told} == {"links.insulation", "sources.cutting"} and told["sources.cutting"].parts == {"table"}


def test_what_is_asked_is_the_machine_without_the_entry(tmp_path: Path) -> None:
    asked: list[tuple[str, ...]] = []

    class Noted:
        limit, groups = 60.0, Groups()

        def run(self, words: tuple[str, ...], folder: Path, log: Path) -> tuple[int, float]:
            asked.append(tuple(words))
            return 0, 5.0

    record("table_bending", tmp_path, Noted())  # type: ignore[arg-type]
    (entry,) = (e for e in list_entries("table_bending") if e.kind == "convection")
    row = diagnose(entry, tmp_path, Noted())  # type: ignore[arg-type]
    assert "simulate" in asked[0] and "diagnose" in asked[1] and (row.score, row.seconds) == ("no answer", 5.0)
    text = (tmp_path / "table_bending" / entry.folder / "machine.yaml").read_text()
    assert "insulation: null" in text and "table_bending.yaml" in text
