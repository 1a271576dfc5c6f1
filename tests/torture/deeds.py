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
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from torture.forked import Forked, warm_up
from torture.log import Told, go_on
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
Running = subprocess.Popen[bytes] | Forked
PASSING = ("solve_seconds", "step_seconds", "seconds", "command")
"""Of a result, what differs from run to run."""


def start(command: str, words: Sequence[str], where: Path, prelude: str = "") -> Running:
    """`lptn command words… -o out` in a folder, in a process group of its own; prelude: Python that runs before it."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    code = f"{prelude}\nfrom network.cli import main\nmain()"
    line = [sys.executable, "-c", code, command, *words, "-o", "out"]
    return subprocess.Popen(
        line, cwd=where, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )


def begin(command: str, words: Sequence[str], where: Path) -> Running:
    """The same in a copy of this process."""
    return Forked([command, *words, "-o", "out"], where)


def finish(running: Running) -> tuple[int, str]:
    told = running.communicate()[1].decode("utf-8", "replace")
    return running.returncode if running.returncode is not None else -1, told


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
    """A folder in which every deed is done undisturbed, with what it leaves and the time that it takes.

    forked: done again in copies of this process, which is quicker and has loaded everything before.
    """

    def __init__(self, folder: Path, forked: bool = False) -> None:
        self.folder, self.count = folder, 0
        self.begin = begin if forked else start
        recorded(folder)
        self.first: dict[str, Path] = {}
        self.second: dict[str, Path] = {}
        self.times: dict[tuple[str, bool], float] = {}

    def results(self, command: str) -> tuple[dict[str, object], dict[str, object]]:
        """What the first run leaves, and what the second one leaves in place of it or beside it."""
        self._prepare(command)
        return held(self.first[command] / "out"), held(self.second[command] / "out")

    def seconds(self, command: str, fresh: bool = True) -> float:
        """What it takes, from the first import on where fresh, or all loaded."""
        if (command, fresh) not in self.times:
            where, began = self.again(command), time.monotonic()
            self._run(command, 1, where, start if fresh else begin)
            self.times[command, fresh] = time.monotonic() - began
        return self.times[command, fresh]

    def again(self, command: str) -> Path:
        """A folder in which the first run has been made and nothing else."""
        self._prepare(command)
        return self._copy(command)

    def _prepare(self, command: str) -> None:
        if command not in self.first:
            where = self.folder / command
            where.mkdir()
            if self.begin is begin:
                warm_up([command, *DEEDS[command][0], "-o", "out"], where)
            else:
                self._run(command, 0, where, start)
            self.first[command] = where
            self.second[command] = self._copy(command)
            self._run(command, 1, self.second[command], self.begin)

    def _copy(self, command: str) -> Path:
        self.count += 1
        return shutil.copytree(self.first[command], self.folder / f"{self.count}")

    def _run(self, command: str, which: int, where: Path, how: Callable[[str, Sequence[str], Path], Running]) -> None:
        code, told = finish(how(command, DEEDS[command][which], where))
        if code:
            raise RuntimeError(f"{command} undisturbed: {told}")

    def judge(self, command: str, where: Path, killed: bool) -> str:
        """What is wrong after a disturbance, and with the same command then; empty where nothing is."""
        results, found = self.results(command), held(where / "out")
        if found not in results and not is_best_so_far(found):
            return f"mixed: {sorted(found)}"
        if not killed and (hidden := [*(where / "out").glob(".*")]):
            return f"hidden: {hidden}"
        code, told = finish(self.begin(command, DEEDS[command][1], where))
        left = [*(where / "out").glob(".*")]
        if code or left or held(where / "out") != results[1]:
            return f"again: status {code}, hidden {left}, {told.strip()[-200:]}"
        shutil.rmtree(where)
        return ""


def attempt_all(
    name: str, text: str | None, count: int, attempt: Callable[[random.Random], tuple[str, str]]
) -> int:  # fmt: skip
    """Attempts (what was tried, what went wrong) by number, as `--count`, `--seed` and `--log` of the command line say;
    tells how often each; 1 where anything went wrong."""
    parser = argparse.ArgumentParser(prog=name, description=text)
    parser.add_argument("--count", type=int, default=count)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--log", type=Path, help="what is in it is not tried again")
    given = parser.parse_args()

    def once(number: int) -> Told:
        what, why = attempt(random.Random(f"{name} {given.seed}/{number}"))
        if why:
            print(f"{number} {what}: {why}", file=sys.stderr, flush=True)
        return {"what": what, "why": why}

    told = Counter(f"{each['what']}: {each['why'] or 'held'}" for each in go_on(given.log, given.count, once))
    print("\n".join(f"{count:5} {what}" for what, count in sorted(told.items())))
    return int(any(not what.endswith(": held") for what in told))


def is_best_so_far(found: Mapping[str, object]) -> bool:
    """Whether a diagnosis was stopped and has written what it had, whole."""
    told = found.get("diagnosis.json")
    return isinstance(told, dict) and told.get("stopped") is True and found.get("report.html") is True
