"""How much hangs on the settings of the diagnosis: the same cases as they are, and with each group moved by ±30 %.

`python -m bench.sensitivity [--cases 20] [--within S] [--seed 7] [--groups misfit,belief] [--resume DIR] [--jobs N]`,
from tests/: development cases (seeds below 1000), of which the first are small machines. A stopped table goes on in its
DIR. With --within only cases are counted that as they are took no longer, so that few answers hang on the clock.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from bench.moved import GROUPS
from proof.cases import make_cases
from proof.judging import LUMPING
from proof.score import OUT, SCORED, Score, answer, is_kept_back, middle, read, score
from rich.console import Console
from rich.table import Table

from network.cli.proof_case import COMMAND, RECORD, TESTS, Runs, Way, diagnose

SHARE = 0.3
SIDES = {"less": -SHARE, "more": SHARE}
HEADINGS = ("changed", "names right", "accused", "median s")


@dataclass(frozen=True)
class Outcome:
    """What came of the cases: those of which verdict or first name are others, names right, innocents accused, s."""

    changed: int
    right: int
    accused: int
    seconds: float | None

    @property
    def cells(self) -> tuple[str, ...]:
        seconds = "–" if self.seconds is None else f"{self.seconds:.0f}"
        return str(self.changed), str(self.right), str(self.accused), seconds


def list_moved(groups: Sequence[str], seed: int) -> list[Way]:
    """Each group moved down and up."""
    moved = [(group, side) for group in groups for side in SIDES]
    return [Way((sys.executable, "-m", "bench.moved", g, f"{SIDES[s]:g}"), answers_of(g, s), seed) for g, s in moved]


def answers_of(group: str, side: str) -> str:
    return f"{OUT}-{group}-{side}"


def diagnose_all(cases: Sequence[Path], ways: Sequence[Way], jobs: int) -> Iterator[str]:
    """Diagnoses what is not answered yet, a sentence for each; a stop ends the commands."""
    left = [(case, way) for way in ways for case in cases if not (case / way.answers / RECORD).is_file()]
    runs, pool = Runs(), ThreadPoolExecutor(max(1, jobs))
    try:
        running = {pool.submit(diagnose, *each, runs): each for each in left}
        for done, future in enumerate(as_completed(running), 1):
            (case, way), (seconds, how) = running[future], future.result()
            yield f"{done}/{len(left)} {case.name} {way.answers}: {how} after {seconds:.0f} s"
    except BaseException:
        runs.end()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def outcome(folder: Path, names: Sequence[str], answers: str) -> Outcome:
    """Of the answers in one folder of each case, beside those of the settings as they are."""
    judged: Score = score(folder, names, answers)
    changed = sum(first_told(folder / name / answers) != first_told(folder / name / OUT) for name in names)
    seconds = middle([read(folder / name / answers / RECORD).get("seconds") for name in names])
    right = sum(each.first for each in judged.effects + judged.of("outside"))
    return Outcome(changed, right, sum(each.accused for each in judged.judgements), seconds)


def first_told(where: Path) -> tuple[Any, ...]:
    """Verdict and first name beside lumps; nothing where it was not answered."""
    if (told := answer(where)) is None:
        return ()
    names = (each["kind"] for each in told.get("findings") or () if each["kind"] != LUMPING)
    return told["verdict"], next(names, None)


def list_changes(folder: Path, names: Sequence[str], groups: Sequence[str]) -> Iterator[str]:
    """What was told, and what is told instead."""
    for group, side, name in ((g, s, n) for g in groups for s in SIDES for n in names):
        first, then = (first_told(folder / name / answers) for answers in (OUT, answers_of(group, side)))
        if first != then:
            was, now = (" ".join(filter(None, told)) or "no answer" for told in (first, then))
            yield f"{group} {'−' if SIDES[side] < 0 else '+'}30 %, {name}: {was} → {now}"


def make_table(folder: Path, names: Sequence[str], groups: Sequence[str]) -> Table:
    table = Table(title=f"{len(names)} cases, settings moved by ±{100 * SHARE:.0f} %")
    for heading in ("group", *(f"{sign}30 %: {name}" for sign in "−+" for name in HEADINGS)):
        table.add_column(heading)
    table.add_row("as they are", *2 * outcome(folder, names, OUT).cells)
    for group in groups:
        both = (outcome(folder, names, answers_of(group, side)).cells for side in SIDES)
        table.add_row(group, *(cell for cells in both for cell in cells))
    return table


def tell_all(console: Console, told: Iterator[str]) -> None:
    for line in told:
        console.print(line, style="dim")


def main(folder: Path, count: int, within: float, seed: int, groups: Sequence[str], jobs: int) -> None:
    console = Console(width=140)
    console.print(f"{folder}: goes on there with --resume {folder}", style="dim", soft_wrap=True)
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (str(TESTS), os.environ.get("PYTHONPATH"))))
    names = make_cases(folder, count, seed, jobs)
    tell_all(console, diagnose_all([folder / name for name in names], [Way(COMMAND, OUT, seed)], jobs))
    names = [name for name in names if read(folder / name / OUT / RECORD).get("seconds", math.inf) <= within]
    tell_all(console, diagnose_all([folder / name for name in names], list_moved(groups, seed), jobs))
    console.print(make_table(folder, names, groups))
    for told in list_changes(folder, names, groups):
        console.print(told)


def read_seed(folder: Path | None, given: int | None) -> int:
    """As the folder has it. Refuses one that is for the score, and another one than the folder's."""
    there = read(folder / "cases.json").get("seed") if folder else None
    seed = int(next(each for each in (given, there, 7) if each is not None))
    if there not in (None, seed):
        sys.exit(f"refused: {folder} holds cases of seed {there}, not of {seed}")
    if is_kept_back(seed):
        sys.exit(f"refused: seeds from {SCORED} on are for the score")
    return seed


def read_groups(told: str) -> list[str]:
    groups = told.split(",") if told else list(GROUPS)
    if other := [name for name in groups if name not in GROUPS]:
        sys.exit(f"refused: no group {', '.join(other)}; there are {', '.join(GROUPS)}")
    return groups


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for option, default in (("--cases", 20), ("--jobs", 1)):
        parser.add_argument(option, type=int, default=default)
    parser.add_argument("--within", type=float, default=math.inf)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--groups", default="")
    parser.add_argument("--resume", type=Path)
    given = parser.parse_args()
    its_seed, its_groups = read_seed(given.resume, given.seed), read_groups(given.groups)
    where = (given.resume or Path(tempfile.mkdtemp(prefix="sensitivity_"))).resolve()
    main(where, given.cases, given.within, its_seed, its_groups, given.jobs)
