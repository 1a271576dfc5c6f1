"""One concealed case of a proof: diagnosed by a command of its own, its answer recorded beside it."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from network.platform.files import write_text
from network.platform.process_groups import Ended, Groups
from network.report.files.result_files import as_json

TESTS = Path(__file__).resolve().parents[2] / "tests"
LIMIT = 150.0
"""s of a processor for one diagnosis, where the case sets no limit of its own; what takes longer counts as missed."""
TRAIN, HELD_OUT = ("train1.csv", "train2.csv", "train3.csv"), ("holdout.csv",)
"""Recordings of a case that does not say which it has."""
COMMAND, ABLATED = (sys.executable, "-m", "network.cli"), "bench.ablated"
RECORD = "run.json"
"""Beside an answer: its seconds and how it ended. A case that has one is not run again."""


class Runs(Groups):
    """Commands that end when the proof is stopped."""

    @property
    def is_over(self) -> bool:
        return self._over


@dataclass(frozen=True)
class Way:
    """How a case is diagnosed: the command before `diagnose`, the folder in the case that the answer goes to, the seed
    and the number of processes."""

    command: tuple[str, ...]
    answers: str
    seed: int
    jobs: int = 1

    def on_two(self) -> Way:
        return Way(self.command, f"{self.answers}-two-cores", self.seed, 2)


def diagnose(case: Path, way: Way, runs: Runs, limit: float = LIMIT) -> tuple[float, str]:
    """Seconds, and how it ended; an answer that came after an error or too late is taken away again."""
    about, where = description(case), case / way.answers
    shutil.rmtree(where, ignore_errors=True)
    holdout = [word for name in about["holdout"] for word in ("--holdout", name)]
    options = ("-o", way.answers, "--no-plots", "--jobs", str(way.jobs), "--seed", str(way.seed))
    words = ("diagnose", "machine.yaml", *about["train"], *holdout, *options)
    ended = _run((*way.command, *words), case, way, runs, about.get("seconds_limit") or limit)
    if ended.code != 0:
        (where / "diagnosis.json").unlink(missing_ok=True)
    seconds = ended.busy if way.jobs == 1 else ended.passed
    record = {"seconds": seconds, "passed": ended.passed, "how": _describe_status(ended.code), "jobs": way.jobs}
    if ended.code == 0 and about["holdout"]:
        record["file_runs"] = _simulate_holdout(case, way, runs, about["holdout"])
    if not runs.is_over:
        where.mkdir(exist_ok=True)
        write_text(where / RECORD, as_json(record))
    return seconds, _describe_status(ended.code)


def _simulate_holdout(case: Path, way: Way, runs: Runs, holdout: Sequence[str]) -> bool:
    """Whether the machine that was written simulates the held-out recordings; held_out.json says what it leaves."""
    machine, left = f"{way.answers}/machine.diagnosed.yaml", f"{way.answers}/held_out.json"
    words = ("compare", machine, *holdout, "--held-out", "--json", left)
    return _run((*COMMAND, *words), case, way, runs, LIMIT).code == 0


def _run(command: Sequence[str], case: Path, way: Way, runs: Runs, limit: float) -> Ended:
    """How it ended; what it says goes to a file beside the answer."""
    paths = (str(TESTS.parent), str(TESTS) if ABLATED in command else "", os.environ.get("PYTHONPATH"))
    with (case / f"{way.answers}.log").open("a", encoding="utf-8") as log:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
        return runs.run(command, case, log, limit, environment, way.jobs)


def description(case: Path) -> dict[str, Any]:
    """What a case says of itself to everyone."""
    return {"train": TRAIN, "holdout": HELD_OUT, **read_mapping(case / "case.json")}


def read_mapping(path: Path) -> dict[str, Any]:
    """A mapping; empty where there is no such file."""
    return dict(json.loads(path.read_text(encoding="utf-8"))) if path.is_file() else {}


def _describe_status(code: int | None) -> str:
    if code is None:
        return "no answer in time"
    return "answered" if code == 0 else f"failed with status {code}"
