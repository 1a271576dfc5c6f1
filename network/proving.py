"""`lptn prove`: concealed cases from the separate truth in tests/proof, diagnosed one by one, then scored."""

from __future__ import annotations

import importlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from network.refusal import Spot, refuse

TESTS = Path(__file__).resolve().parent.parent / "tests"
LIMIT = 150.0
"""s for one diagnosis; a case that takes longer counts as missed."""
TRAIN, HELD_OUT = ("train1.csv", "train2.csv", "train3.csv"), "holdout.csv"
COMMAND = (sys.executable, "-m", "network.cli")

Progress = Callable[[int, int, str], None]
"""Called with cases done, cases in all, and a sentence on the last one."""


def prove(count: int, seed: int, jobs: int, folder: Path | str, progress: Progress | None = None) -> Any:
    """The score of `count` concealed cases, made in `folder`: a dataclass that prints itself as a table.

    The truth and the scorer import nothing of this package and it nothing of theirs but the two calls below; keys are
    opened when every diagnosis is written. Raises Refused outside a clone, where there is no tests/proof, and where the
    folder holds something other than an earlier proof.
    """
    cases, score = _module("cases"), _module("score")
    folder = _empty(Path(folder).resolve())
    names = cases.make_cases(folder, count, seed, jobs)
    seconds: dict[str, float] = {}
    with ThreadPoolExecutor(max(1, jobs)) as pool:
        running = {pool.submit(diagnose, folder / name, seed): name for name in names}
        for done, future in enumerate(as_completed(running), start=1):
            name = running[future]
            seconds[name], told = future.result()
            if progress:
                progress(done, count, f"{name}: {told} after {seconds[name]:.0f} s")
    return score.score(folder, seconds)


def _module(name: str) -> Any:
    """A module of tests/proof, which stands beside the package in a clone."""
    if not (TESTS / "proof" / f"{name}.py").is_file():
        right = "clone the repository and run `lptn prove` from there: the wheel does not carry the proof"
        raise refuse(Spot("tests/proof"), "the truth and the scorer of the proof are not here", right)
    if str(TESTS) not in sys.path:
        sys.path.append(str(TESTS))
    return importlib.import_module(f"proof.{name}")


def _empty(folder: Path) -> Path:
    """The folder without the proof that may lie in it; nothing else is ever deleted."""
    if folder.is_dir() and any(folder.iterdir()) and not (folder / "cases.json").is_file():
        raise refuse(Spot(str(folder)), "is a folder with something else in it", "give an empty or a new folder")
    for old in (*folder.glob("case-*"), folder / "keys"):
        shutil.rmtree(old, ignore_errors=True)
    return folder


def diagnose(case: Path, seed: int, limit: float = LIMIT) -> tuple[float, str]:
    """Seconds, and how it ended; an answer that came after an error or too late is taken away again."""
    began = time.monotonic()
    options = ("--holdout", HELD_OUT, "-o", "out", "--no-plots", "--jobs", "1", "--seed", str(seed))
    arguments = ("diagnose", "machine.yaml", *TRAIN, *options)
    with (case / "log.txt").open("w", encoding="utf-8") as log:
        ended = _ended([*COMMAND, *arguments], case, log, limit)
    if ended != "answered":
        (case / "out" / "diagnosis.json").unlink(missing_ok=True)
    return time.monotonic() - began, ended


def _ended(command: Sequence[str], where: Path, log: Any, limit: float) -> str:
    """Runs a command in a process group of its own, so that its workers end with it."""
    path = os.pathsep.join(filter(None, [str(TESTS.parent), os.environ.get("PYTHONPATH")]))
    process = subprocess.Popen(
        command, cwd=where, stdout=log, stderr=log, start_new_session=True, env={**os.environ, "PYTHONPATH": path}
    )
    try:
        code = process.wait(limit)
    except subprocess.TimeoutExpired:
        _stop(process)
        return "no answer in time"
    return "answered" if code == 0 else f"failed with status {code}"


def _stop(process: subprocess.Popen[bytes]) -> None:
    if hasattr(os, "killpg"):
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()
