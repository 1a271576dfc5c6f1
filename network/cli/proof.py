"""`lptn prove`: concealed cases from the separate truth in tests/proof, diagnosed one by one, then scored."""

from __future__ import annotations

import importlib
import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from network.platform.process_groups import Ended, Groups
from network.platform.refusal import Spot, refuse
from network.platform.stopping import on_stop
from network.report.files.result_files import as_json, check_folder, not_there, remove_empty, write_text

TESTS = Path(__file__).resolve().parents[2] / "tests"
LIMIT = 150.0
"""s of a processor for one diagnosis, where the case sets no limit of its own; what takes longer counts as missed."""
TRAIN, HELD_OUT = ("train1.csv", "train2.csv", "train3.csv"), ("holdout.csv",)
"""Recordings of a case that does not say which it has."""
COMMAND, ABLATED = (sys.executable, "-m", "network.cli"), "bench.ablated"
CASES, SEED = 40, 0
CASES_FILE, RECORD = "cases.json", "run.json"
"""What a proof holds; and beside an answer, its seconds and how it ended: a case that has one is not run again."""

Progress = Callable[[int, int, str], None]
"""Called with cases done, cases in all, and a sentence on the last one."""


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


def prove(
    count: int | None, seed: int | None, jobs: int, folder: Path | str, progress: Progress | None = None, *,
    resume: bool = False, ablate: str | None = None, timed: int = 0,
) -> Any:  # fmt: skip
    """The score of `count` concealed cases, made in `folder`: a dataclass that prints itself as a table.

    resume: goes on in a folder, whose answers stay, also when it is stopped again; ablate: a stage of the diagnosis
    that is switched off; timed: how many of the cases are diagnosed by two processes once more, one after the other.
    The truth and the scorer import nothing of this package and it nothing of theirs but the two calls below; keys are
    opened when every diagnosis is written. Raises Refused outside a clone, where there is no tests/proof, where the
    folder holds something other than an earlier proof, and for a stage that is none.
    """
    cases, score = _module("cases"), _module("score")
    command, answers = _leave_out(ablate) if ablate else (COMMAND, "out")
    folder = check_folder(Path(folder)).resolve()
    count, seed = _read_request(folder, count, seed) if resume else (count or CASES, seed or SEED)
    _check_own(folder)
    if not resume:
        _empty(folder)
    elif not (folder / CASES_FILE).is_file():
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / CASES_FILE, as_json({"seed": seed, "count": count, "cases": {}}))
    way = Way(command, answers, seed)
    with nullcontext() if resume else _all_or_nothing(folder), _ending() as runs:
        names = cases.make_cases(folder, count, seed, jobs)
        each = [folder / name for name in names]
        _diagnose(each, way, jobs, runs, progress)
        _diagnose(each[:timed], way.on_two(), 1, runs, progress)
    return score.score(folder, names, answers)


def _diagnose(cases: Sequence[Path], way: Way, jobs: int, runs: Runs, progress: Progress | None) -> None:
    """Diagnoses those that were not yet. Whatever ends it early, no case begins any more."""
    left = [case for case in cases if not (case / way.answers / RECORD).is_file()]
    pool = ThreadPoolExecutor(max(1, jobs))
    try:
        running = {pool.submit(diagnose, case, way, runs): case.name for case in left}
        for done, future in enumerate(as_completed(running), start=1 + len(cases) - len(left)):
            seconds, told = future.result()
            if progress:
                how = f"{told} after {seconds:.0f} s" + (f" by {way.jobs} processes" if way.jobs > 1 else "")
                progress(done, len(cases), f"{running[future]}: {how}")
    except BaseException:
        runs.end()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


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
    words = ("compare", machine, *holdout, "--start", "estimated", "--json", left)
    return _run((*COMMAND, *words), case, way, runs, LIMIT).code == 0


def _run(command: Sequence[str], case: Path, way: Way, runs: Runs, limit: float) -> Ended:
    """How it ended; what it says goes to a file beside the answer."""
    paths = (str(TESTS.parent), str(TESTS) if ABLATED in command else "", os.environ.get("PYTHONPATH"))
    with (case / f"{way.answers}.log").open("a", encoding="utf-8") as log:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
        return runs.run(command, case, log, limit, environment, way.jobs)


def description(case: Path) -> dict[str, Any]:
    """What a case says of itself to everyone."""
    return {"train": TRAIN, "holdout": HELD_OUT, **_read(case / "case.json")}


def _read(path: Path) -> dict[str, Any]:
    """A mapping; empty where there is no such file."""
    return dict(json.loads(path.read_text(encoding="utf-8"))) if path.is_file() else {}


def _describe_status(code: int | None) -> str:
    if code is None:
        return "no answer in time"
    return "answered" if code == 0 else f"failed with status {code}"


@contextmanager
def _ending() -> Iterator[Runs]:
    """Commands that end when the proof is stopped."""
    runs = Runs()
    with on_stop(runs.end):
        yield runs


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


def _module(name: str, package: str = "proof") -> Any:
    """A module of tests/, which stands beside the package in a clone."""
    if not (TESTS / package / f"{name}.py").is_file():
        right = "clone the repository and run `lptn prove` from there: the wheel does not carry the proof"
        raise refuse(Spot(f"tests/{package}"), "the truth and the scorer of the proof are not here", right)
    if str(TESTS) not in sys.path:
        sys.path.append(str(TESTS))
    return importlib.import_module(f"{package}.{name}")


def _leave_out(stage: str) -> tuple[tuple[str, ...], str]:
    """The command without a stage, and the folder of its answers. Raises Refused for a stage that is none."""
    stages = _module("ablated", "bench").STAGES
    if stage not in stages:
        raise refuse(Spot("--ablate"), f"'{stage}' is no stage that can be switched off", f"give {', '.join(stages)}")
    return (sys.executable, "-m", ABLATED, stage), f"out-{stage}"


def _read_request(folder: Path, count: int | None, seed: int | None) -> tuple[int, int]:
    """Cases and seed of a proof that goes on: as given, else as it has them. Raises Refused for another seed."""
    there: dict[str, Any] = {"seed": seed or SEED, "cases": {}} | _read(folder / CASES_FILE)
    if seed not in (None, there["seed"]):
        right = f"give --seed {there['seed']} or another folder"
        raise refuse(Spot(str(folder)), f"holds cases of seed {there['seed']}, not of {seed}", right)
    return count or len(there["cases"]) or there.get("count", CASES), there["seed"]


def _check_own(folder: Path) -> None:
    """Raises Refused where something other than a proof lies in the folder."""
    if not (folder / CASES_FILE).is_file() and folder.is_dir() and any(folder.iterdir()):
        raise refuse(Spot(str(folder)), "is a folder with something else in it", "give an empty or a new folder")


def _empty(folder: Path) -> None:
    """Nothing but a proof is ever deleted."""
    for old in (*folder.glob("case-*"), folder / "keys"):
        shutil.rmtree(old, ignore_errors=True)
    (folder / CASES_FILE).unlink(missing_ok=True)
