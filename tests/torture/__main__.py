"""`make torture`: mutants until the count is reached; what was done stays done when it is stopped and begun again.

The folder holds done.jsonl, a line for every mutant, and for each fault a folder with its files, made as small as it
stays the same fault, and `words.json`. Faults that are alike are kept once.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import takewhile
from pathlib import Path

from torture.log import Told, read_numbered
from torture.minimise import minimise
from torture.mutants import Mutant, mutant
from torture.oracle import Outcome, judge, remove

MEMORY = 2 * 10**9
"""B that any accepted input may take."""
WARM = 100
"""Mutants after which hardly anything more is loaded."""
KINDS = ("refused", "failed", "accepted", "fault")


def main() -> int:
    parser = argparse.ArgumentParser(prog="torture", description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=Path(".torture"))
    parser.add_argument("--jobs", type=int, default=1, help="processes that share the mutants")
    parser.add_argument("--table", action="store_true", help="only tell what is in the folder")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    done = given.folder / f"done-{given.seed}.jsonl"
    if not given.table:
        left = sorted({*range(given.count)} - {*read_numbered(done)})
        share(given.jobs, lambda which: _try_all(left[which :: given.jobs], given, done))
    told = [*read_numbered(done).values()]
    print(table(told))
    return int(any(each["kind"] == "fault" for each in told))


def share(jobs: int, work: Callable[[int], None]) -> None:
    """In so many copies of this process, each told which it is. Raises RuntimeError where one does not end well."""
    copies = []
    for which in range(jobs):
        copies.append(os.fork())
        if not copies[-1]:
            _work_and_end(work, which)
    ends = [os.waitpid(copy, 0)[1] for copy in copies]
    if any(ends):
        raise RuntimeError(f"{sum(map(bool, ends))} of {jobs} processes ended early; begin again, what is done is kept")


def _work_and_end(work: Callable[[int], None], which: int) -> None:
    status = 1
    try:
        work(which)
        status = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)


def _try_all(numbers: Sequence[int], given: argparse.Namespace, done: Path) -> None:
    """As long as the process lives that shares them out."""
    limit_memory()
    told: list[Told] = []
    shares_out = os.getppid()
    with tempfile.TemporaryDirectory(prefix="torture-", dir=_quick_place()) as folder:
        for number in takewhile(lambda _: os.getppid() == shares_out, numbers):
            told.append({"number": number, **_try(number, given.seed, Path(folder), given.folder)})
            with done.open("a", encoding="utf-8") as log:
                log.write(json.dumps(told[-1]) + "\n")
            if len(told) == WARM:
                gc.collect()
                gc.freeze()  # what has been loaded by then stays, and is not gone through again and again
            if len(told) % 100 == 0:
                print(f"{len(told)} of {len(numbers)} {_count(told)}", file=sys.stderr, flush=True)


def limit_memory() -> None:
    """Of this process to 2 GB more than it holds when it begins; what needs more ends in a MemoryError, a fault."""
    with suppress(ImportError, OSError):
        import resource

        held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (held + MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _quick_place() -> str | None:
    """A disk in memory where there is one: thousands of small folders come and go."""
    return "/dev/shm" if os.access("/dev/shm", os.W_OK) else None


def _try(number: int, seed: int, folder: Path, keep: Path) -> Told:
    made = mutant(seed, number, folder)
    outcome = attempt(made, folder)
    if outcome.kind == "fault":
        _keep(made, outcome, folder, keep)
    return {"command": made.words[0], "kind": outcome.kind, "why": outcome.why, "seconds": round(outcome.seconds, 2)}


def attempt(made: Mutant, folder: Path) -> Outcome:
    """What comes of a mutant in a folder of its own."""
    where = folder / "case"
    where.mkdir(exist_ok=True)
    remove(where)
    made.write(where)
    return judge(made.words, where)


def _keep(made: Mutant, outcome: Outcome, folder: Path, keep: Path) -> None:
    name = "".join(letter if letter.isalnum() else "-" for letter in outcome.why[:80])
    where = keep / f"{made.words[0]}-{name}"
    if where.exists():
        return
    small = minimise(made, outcome, lambda each: attempt(each, folder)) if "hangs" not in outcome.why else made
    where.mkdir(exist_ok=True)
    small.write(where)
    (where / "words.json").write_text(json.dumps({"words": small.words, "why": outcome.why}, indent=1))


def _count(told: Sequence[Told]) -> str:
    return ", ".join(f"{kind} {n}" for kind, n in sorted(Counter(str(each["kind"]) for each in told).items()))


def table(told: Sequence[Told]) -> str:
    """As it stands in the README: command by command, the most tried first."""
    counts = Counter((str(each["command"]), str(each["kind"])) for each in told)
    rows = {name: [counts[name, kind] for kind in KINDS] for name, _ in counts}
    ordered = sorted(rows.items(), key=lambda row: (-sum(row[1]), row[0]))
    ordered.append(("all", [sum(column) for column in zip(*rows.values(), strict=True)]))
    told_rows = [[name, *(f"{count:,}".replace(",", " ") for count in (sum(own), *own))] for name, own in ordered]
    head = ("command", "tried", "refused", "failed in a sentence", "accepted", "faults")
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *told_rows))


if __name__ == "__main__":
    sys.exit(main())
