"""`lptn prove`: concealed cases from the separate truth in tests/proof, diagnosed one by one, then scored."""

from __future__ import annotations

import importlib
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from network.groups import Groups
from network.output import checked, not_there, remove_empty
from network.refusal import Spot, refuse
from network.stopping import on_stop

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
    folder = _own(checked(Path(folder)).resolve())
    with _all_or_nothing(folder), _ending() as groups:
        names = cases.make_cases(folder, count, seed, jobs)
        seconds = _diagnosed([folder / name for name in names], seed, jobs, groups, progress)
    return score.score(folder, seconds)


def _diagnosed(
    cases: Sequence[Path], seed: int, jobs: int, groups: Groups, progress: Progress | None
) -> dict[str, float]:
    """Seconds of every case. Whatever ends it early, no case begins any more."""
    seconds: dict[str, float] = {}
    pool = ThreadPoolExecutor(max(1, jobs))
    try:
        running = {pool.submit(diagnose, case, seed, groups): case.name for case in cases}
        for done, future in enumerate(as_completed(running), start=1):
            name = running[future]
            seconds[name], told = future.result()
            if progress:
                progress(done, len(cases), f"{name}: {told} after {seconds[name]:.0f} s")
    except BaseException:
        groups.end()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
    return seconds


@contextmanager
def _ending() -> Iterator[Groups]:
    """Commands that end when the proof is stopped."""
    groups = Groups()
    with on_stop(groups.end):
        yield groups


@contextmanager
def _all_or_nothing(folder: Path) -> Iterator[None]:
    """A proof that does not come to its end is taken away, with the folders that it made."""
    new = not_there(folder)

    def take_away() -> None:
        _empty(folder)
        remove_empty(new)

    with on_stop(take_away):
        try:
            yield
        except BaseException:
            take_away()
            raise


def _module(name: str) -> Any:
    """A module of tests/proof, which stands beside the package in a clone."""
    if not (TESTS / "proof" / f"{name}.py").is_file():
        right = "clone the repository and run `lptn prove` from there: the wheel does not carry the proof"
        raise refuse(Spot("tests/proof"), "the truth and the scorer of the proof are not here", right)
    if str(TESTS) not in sys.path:
        sys.path.append(str(TESTS))
    return importlib.import_module(f"proof.{name}")


def _own(folder: Path) -> Path:
    """The folder without the proof that may lie in it. Raises Refused where something else does."""
    if folder.is_dir() and any(folder.iterdir()) and not (folder / "cases.json").is_file():
        raise refuse(Spot(str(folder)), "is a folder with something else in it", "give an empty or a new folder")
    _empty(folder)
    return folder


def _empty(folder: Path) -> None:
    """Nothing but a proof is ever deleted."""
    for old in (*folder.glob("case-*"), folder / "keys"):
        shutil.rmtree(old, ignore_errors=True)
    (folder / "cases.json").unlink(missing_ok=True)


def diagnose(case: Path, seed: int, groups: Groups, limit: float = LIMIT) -> tuple[float, str]:
    """Seconds, and how it ended; an answer that came after an error or too late is taken away again."""
    began = time.monotonic()
    options = ("--holdout", HELD_OUT, "-o", "out", "--no-plots", "--jobs", "1", "--seed", str(seed))
    command = (*COMMAND, "diagnose", "machine.yaml", *TRAIN, *options)
    path = os.pathsep.join(filter(None, [str(TESTS.parent), os.environ.get("PYTHONPATH")]))
    with (case / "log.txt").open("w", encoding="utf-8") as log:
        code = groups.run(command, case, log, limit, {**os.environ, "PYTHONPATH": path})
    if code != 0:
        (case / "out" / "diagnosis.json").unlink(missing_ok=True)
    return time.monotonic() - began, _told(code)


def _told(code: int | None) -> str:
    if code is None:
        return "no answer in time"
    return "answered" if code == 0 else f"failed with status {code}"
