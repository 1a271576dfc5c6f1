"""`lptn prove`: concealed cases from the separate truth in tests/proof, diagnosed one by one, then scored."""

from __future__ import annotations

import importlib
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

from network.cli import proof_case
from network.cli.proof_case import ABLATED, RECORD, TESTS, Runs, Way, diagnose, read_mapping
from network.platform.files import write_text
from network.platform.folders import check_folder, not_there, remove_empty
from network.platform.refusal import Spot, refuse
from network.platform.stopping import on_stop
from network.report.files.result_files import as_json

CASES, SEED = 40, 0
CASES_FILE = "cases.json"
"""What a proof holds."""

Progress = Callable[[int, int, str], None]
"""Called with cases done, cases in all, and a sentence on the last one."""


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
    command, answers = _leave_out(ablate) if ablate else (proof_case.COMMAND, "out")
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
    there: dict[str, Any] = {"seed": seed or SEED, "cases": {}} | read_mapping(folder / CASES_FILE)
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
