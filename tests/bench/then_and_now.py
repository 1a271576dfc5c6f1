"""Sealed pairs, then and now: what changed is named, and nothing is accused where nothing has.

`python -m bench.then_and_now [--changed 60] [--same 59] [--seed 7] [--folder DIR] [--minutes M]` from tests/:
seeds below 1000 are for development, from there on for the score. Pairs that are answered already are not answered
again; after so many minutes no further pair is begun. Machines with a thermostat take minutes each and come last. Keys
are opened only when all have been. Named: the gravest change is the number or the thermometer that was changed, or one
that the key says would show the same.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from proof.pairs import list_pairs, make_pair_of, names
from proof.score import is_kept_back
from proof.sealed import opened
from rich.console import Console
from rich.table import Table

from network import Machine, Recording
from network.analysis.change.changes import find_changes
from network.platform.refusal import Failed, Refused


def answer(pair: Path) -> dict[str, Any]:
    """What is said of a pair; kept in its folder."""
    at = pair / "answer.json"
    if not at.is_file():
        machine = Machine.load(pair / "machine.yaml")
        runs = {name: Recording.load(pair / f"{name}.csv") for name in names()}
        then, now = ([run for name, run in runs.items() if name.startswith(side)] for side in ("then", "now"))
        try:
            told = find_changes(machine, now, then).summary()
        except (Refused, Failed) as error:
            told = {"changed": [], "failed": str(error)}
        at.write_text(json.dumps(told, indent=1), encoding="utf-8")
    return dict(json.loads(at.read_text(encoding="utf-8")))


def judge(key: Mapping[str, Any], told: Mapping[str, Any]) -> dict[str, Any]:
    """named: the first, or one alike by the key; strictly: the first alone; listed: among it and its equals."""
    found, change = told["changed"], key["change"]
    first = [found[0]["number"], *found[0].get("alike", ())] if found else []
    first = [number.removesuffix(".offset") if number.startswith("sensors.") else number for number in first]
    if change is None:
        return {"accused": bool(found), "answer": first[:1]}
    right = [change["number"], *change["alike"]]
    return {
        "named": bool(first) and first[0] in right, "strictly": first[:1] == [change["number"]],
        "listed": bool({*first} & {*right}), "besides": max(len(found) - 1, 0), "answer": first[:1],
        "silent": not found, "expected": change["number"], "visible": change["visible"], "size": change["size"],
        "sensor": change["number"].startswith("sensors."),
    }  # fmt: skip


def in_turn(folder: Path, pairs: list[str], seed: int, until: float) -> Iterator[str]:
    """The pairs as they are made, until some instant, those of machines with a thermostat last."""
    slow = []
    for name in pairs:
        if time.monotonic() >= until and not (folder / "keys" / f"{name}.json").is_file():
            continue
        make_pair_of(folder, seed, name)
        if "thermostat" in (folder / name / "machine.yaml").read_text(encoding="utf-8"):
            slow.append(name)
        else:
            yield name
    yield from slow


def main(changed: int, same: int, seed: int, folder: Path, until: float) -> None:
    console = Console()
    told = {}
    for name in in_turn(folder, list_pairs(changed, same), seed, until):
        if time.monotonic() < until or (folder / name / "answer.json").is_file():
            told[name] = answer(folder / name)
            console.print(f"{len(told)}/{changed + same} {name}", style="dim")
    keys = {name: opened(folder, name) for name in told}
    judged = {name: judge(keys[name], told[name]) for name in told}
    for name, each in judged.items():
        if not each.get("named", not each.get("accused")):
            console.print(f"{name} ({keys[name]['layout']}, {keys[name]['truth']}): {each}", soft_wrap=True)
    table = Table(title=f"Then and now, seed {seed}" + ("" if is_kept_back(seed) else " (development)"))
    for column in ("pairs", "", "named", "strictly", "in the set", "silent", "told besides"):
        table.add_column(column)
    for title, is_sensor in (("a number changed", False), ("a thermometer changed", True)):
        rows = [each for each in judged.values() if each.get("sensor") is is_sensor]
        cells = [str(sum(bool(row[name]) for row in rows)) for name in ("named", "strictly", "listed", "silent")]
        table.add_row(title, str(len(rows)), *cells, str(sum(row["besides"] for row in rows)))
    accused = [each["accused"] for each in judged.values() if "accused" in each]
    table.add_row("nothing changed", str(len(accused)), "", "", "", str(len(accused) - sum(accused)), str(sum(accused)))
    console.print(table)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for option, default in (("--changed", 60), ("--same", 59), ("--seed", 7)):
        parser.add_argument(option, type=int, default=default)
    parser.add_argument("--folder", type=Path, default=None)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    given = parser.parse_args()
    where = given.folder or Path(tempfile.mkdtemp(prefix="pairs_"))
    main(given.changed, given.same, given.seed, where, time.monotonic() + 60 * given.minutes)
