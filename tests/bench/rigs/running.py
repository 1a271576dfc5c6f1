"""The long part: `lptn calibrate` and `lptn diagnose` of a case, each a process of its own, kept for a later run."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from threading import Event
from typing import Any

from bench.rigs.case import Case
from bench.rigs.splits import ROOT

from network.platform.process_groups import Groups

LIMIT = 300.0
"""s for one diagnosis."""
COMMAND = (sys.executable, "-m", "network.cli")
TIMED = 0.9
"""Of the limit that a diagnosis may take: it answers by then."""
RESULT = {"calibrate": "machine.calibrated.yaml", "diagnose": "diagnosis.json"}


@dataclass(frozen=True)
class Ending:
    """How a command ended. told: in words; seconds: it took."""

    told: str
    seconds: float
    limit: float

    @property
    def answered(self) -> bool:
        return self.told == "answered"


@dataclass(frozen=True)
class Processes:
    """Commands that end with this one. limit: s of a processor for each; stopped: none of them came to its own end."""

    limit: float
    groups: Groups = field(default_factory=Groups)
    stopped: Event = field(default_factory=Event)

    def end(self) -> None:
        self.stopped.set()
        self.groups.end()

    def run(self, words: Sequence[str], folder: Path, log: Path) -> tuple[int | None, float]:
        """Exit status (None: not in time) and seconds. Raises KeyboardInterrupt where it was stopped."""
        path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
        with log.open("w", encoding="utf-8") as file:
            ended = self.groups.run(words, folder, file, self.limit, {**os.environ, "PYTHONPATH": path})
        if self.stopped.is_set():
            raise KeyboardInterrupt
        return ended.code, ended.busy


@dataclass(frozen=True)
class Answered:
    """A case with the folder it was answered in."""

    case: Case
    folder: Path
    calibrated: Ending
    diagnosed: Ending

    @property
    def diagnosis(self) -> dict[str, Any] | None:
        path = self.folder / "diagnose" / RESULT["diagnose"]
        if not self.diagnosed.answered:
            return None
        told: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return told


def answered(case: Case, where: Path, processes: Processes) -> Answered:
    """What is kept of the same case under the same program, or a new answer."""
    folder = where / case.name
    _prepare(case, folder)
    options = ("--jobs", "1", "--seed", "0", "--no-plots", "--budget", f"{TIMED * processes.limit:.0f} s")
    calibrated = _ended(case, folder, "calibrate", ("--no-plots",), processes)
    return Answered(case, folder, calibrated, _ended(case, folder, "diagnose", options, processes))


def _prepare(case: Case, folder: Path) -> None:
    """The case's files; what an earlier program or another case left there is taken away."""
    beside = folder.with_name(f".{folder.name}")
    shutil.rmtree(beside, ignore_errors=True)
    case.write(beside)
    mark = fingerprint([*_files(beside), case.split.machine_file, *sorted((ROOT / "network").rglob("*.py"))])
    if (folder / "made_by").is_file() and (folder / "made_by").read_text() == mark:
        shutil.rmtree(beside)
        return
    shutil.rmtree(folder, ignore_errors=True)
    shutil.rmtree(beside)
    case.write(folder)
    (folder / "made_by").write_text(mark)


def _files(folder: Path) -> Iterator[Path]:
    return (path for path in sorted(folder.iterdir()) if path.suffix in (".yaml", ".csv"))


def fingerprint(paths: list[Path]) -> str:
    """Of contents, with the names of the files alone."""
    told = hashlib.sha256()
    for path in paths:
        told.update(path.name.encode())
        told.update(path.read_bytes())
    return told.hexdigest()


def _ended(case: Case, folder: Path, command: str, options: tuple[str, ...], processes: Processes) -> Ending:
    """How a command ended, now or earlier; one that was cut off by a shorter limit is run again."""
    kept = folder / f"{command}.json"
    if kept.is_file():
        old = Ending(**json.loads(kept.read_text()))
        if old.told != no_answer(old.limit) or old.limit >= processes.limit:
            return old
    held = [word for name in case.holdout for word in ("--holdout", name)]
    words = (*COMMAND, command, "machine.yaml", *case.train, *held, "-o", command, *options)
    shutil.rmtree(folder / command, ignore_errors=True)
    code, seconds = processes.run(words, folder, folder / f"{command}.log")
    ending = Ending(_told(code, folder, command, processes.limit), seconds, processes.limit)
    kept.write_text(json.dumps(asdict(ending)))
    return ending


def _told(code: int | None, folder: Path, command: str, limit: float) -> str:
    if code is None:
        return no_answer(limit)
    is_there = (folder / command / RESULT[command]).is_file()
    return "answered" if code == 0 and is_there else failed(code, folder, command)


def failed(code: int, folder: Path, command: str) -> str:
    """With the last that the command said."""
    lines = (folder / f"{command}.log").read_text(encoding="utf-8").strip().splitlines()
    return f"failed with status {code}" + (f": {lines[-1]}" if lines else "")


def no_answer(limit: float) -> str:
    return f"no answer in {limit:.0f} s"
