"""Commands that write a result, each with the words of a first run and of another one into the same folder, and what of
a result has to be the same however often it is made."""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from torture.mutants import recorded

ROOT = Path(__file__).parents[2]
MACHINE, SCENARIO = str(ROOT / "machines/two_blocks.yaml"), str(ROOT / "scenarios/bearing_warms.yaml")
MILL, SPINDLE = str(ROOT / "machines/vertical_mill.yaml"), str(ROOT / "scenarios/iso230_spindle_constant.yaml")
OTHER = ("--set", "sources.heater.power=20 W")
SURE = ("--set", "links.joint.conductance=3 W/K ± 5 %")
DEEDS: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "simulate": ((MACHINE, SCENARIO), (MACHINE, SCENARIO, *OTHER)),
    "sweep": ((MACHINE, SCENARIO, "--levels", "1,2"), (MACHINE, SCENARIO, "--levels", "1,2,4")),
    "compare": ((MACHINE, "../recorded.csv"), (MACHINE, "../recorded.csv", *OTHER)),
    "calibrate": ((MACHINE, "../recorded.csv"), (MACHINE, "../recorded.csv", *SURE)),
    "diagnose": ((MACHINE, "../recorded.csv", "--jobs", "1"), (MACHINE, "../recorded.csv", "--jobs", "2", *SURE)),
    "iso230": ((MILL, SPINDLE), (MILL, SPINDLE, "--lumps", "2")),
    "export": ((MACHINE, SCENARIO, "--as", "c"), (MACHINE, SCENARIO, "--as", "table", *OTHER)),
}
"""The first run's words, and those of the second, which is the one that is disturbed."""
PASSING = ("solve_seconds", "seconds", "command")
"""Of a result, what differs from run to run."""


def start(command: str, words: Sequence[str], where: Path, prelude: str = "") -> subprocess.Popen[bytes]:
    """`lptn command words… -o out` in a folder, in a process group of its own; prelude: Python that runs before it."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    code = f"{prelude}\nfrom network.cli import main\nmain()"
    line = [sys.executable, "-c", code, command, *words, "-o", "out"]
    return subprocess.Popen(
        line, cwd=where, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )


def finish(running: subprocess.Popen[bytes]) -> tuple[int, str]:
    told = running.communicate()[1].decode("utf-8", "replace")
    return running.returncode, told


def held(where: Path) -> dict[str, object]:
    """Every file of a result, hidden ones aside, without what passes; pictures by their names."""
    return {path.name: _content(path) for path in sorted(where.glob("*")) if not path.name.startswith(".")}


def _content(path: Path) -> object:
    if path.suffix == ".json":
        return _without_passing(json.loads(path.read_text(encoding="utf-8")))
    if path.suffix == ".html":
        return path.read_text(encoding="utf-8").rstrip().endswith("</html>")
    return None if path.suffix == ".png" or path.name == "sweep.csv" else path.read_bytes()


def _without_passing(value: object) -> object:
    if isinstance(value, Mapping):
        return {key: _without_passing(child) for key, child in value.items() if key not in PASSING}
    return [_without_passing(child) for child in value] if isinstance(value, list) else value


class Bench:
    """A folder in which every deed is done once undisturbed, with what it leaves and the time that it takes."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.count = folder, 0
        recorded(folder)
        self.first: dict[str, Path] = {}
        self.second: dict[str, tuple[Path, float]] = {}

    def results(self, command: str) -> tuple[dict[str, object], dict[str, object]]:
        """What the first run leaves, and what the second one leaves in place of it or beside it."""
        self._prepare(command)
        return held(self.first[command] / "out"), held(self.second[command][0] / "out")

    def seconds(self, command: str) -> float:
        self._prepare(command)
        return self.second[command][1]

    def again(self, command: str) -> Path:
        """A folder in which the first run has been made and nothing else."""
        self._prepare(command)
        return self._copy(command)

    def _prepare(self, command: str) -> None:
        if command not in self.first:
            where = self.folder / command
            where.mkdir()
            self._run(command, 0, where)
            self.first[command] = where
            other, began = self._copy(command), time.monotonic()
            self._run(command, 1, other)
            self.second[command] = other, time.monotonic() - began

    def _copy(self, command: str) -> Path:
        self.count += 1
        return shutil.copytree(self.first[command], self.folder / f"{self.count}")

    def _run(self, command: str, which: int, where: Path) -> None:
        code, told = finish(start(command, DEEDS[command][which], where))
        if code:
            raise RuntimeError(f"{command} undisturbed: {told}")

    def judge(self, command: str, where: Path, killed: bool) -> str:
        """What is wrong after a disturbance, and with the same command then; empty where nothing is."""
        results, found = self.results(command), held(where / "out")
        if found not in results and not is_best_so_far(found):
            return f"mixed: {sorted(found)}"
        if not killed and (hidden := [*(where / "out").glob(".*")]):
            return f"hidden: {hidden}"
        code, told = finish(start(command, DEEDS[command][1], where))
        left = [*(where / "out").glob(".*")]
        if code or left or held(where / "out") != results[1]:
            return f"again: status {code}, hidden {left}, {told.strip()[-200:]}"
        shutil.rmtree(where)
        return ""


def tally(tries: Iterator[tuple[str, str]]) -> int:
    """Tells (what was tried, what went wrong) as they come, then how often each; 1 where anything went wrong."""
    told = Counter[str]()
    for what, why in tries:
        told[f"{what}: {why or 'held'}"] += 1
        if why:
            print(f"{what}: {why}", file=sys.stderr, flush=True)
    print("\n".join(f"{count:5} {what}" for what, count in sorted(told.items())))
    return int(any(not what.endswith(": held") for what in told))


def read_count(name: str, text: str | None, count: int) -> tuple[int, random.Random]:
    """`--count` and the chance that `--seed` begins, from the command line."""
    parser = argparse.ArgumentParser(prog=name, description=text)
    parser.add_argument("--count", type=int, default=count)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    return given.count, random.Random(given.seed)


def is_best_so_far(found: Mapping[str, object]) -> bool:
    """Whether a diagnosis was stopped and has written what it had, whole."""
    told = found.get("diagnosis.json")
    return isinstance(told, dict) and told.get("stopped") is True and found.get("report.html") is True
