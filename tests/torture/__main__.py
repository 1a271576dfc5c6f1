"""`make torture`: mutants until the count is reached; what was done stays done when it is stopped and begun again.

The folder holds done.jsonl, a line for every mutant, and for each fault a folder with its files, made as small as it
stays the same fault, and `words.json`. Faults that are alike are kept once.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections import Counter
from contextlib import suppress
from pathlib import Path

from torture.minimise import minimise
from torture.mutants import Mutant, mutant
from torture.oracle import Outcome, judge, remove

MEMORY = 2 * 10**9
"""B that any accepted input may take."""


def main() -> int:
    parser = argparse.ArgumentParser(prog="torture", description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=Path(".torture"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    limit_memory()
    done = given.folder / f"done-{given.seed}.jsonl"
    told = [json.loads(line) for line in done.read_text().splitlines()] if done.is_file() else []
    place = tempfile.TemporaryDirectory(prefix="torture-", dir=_quick_place())
    with place as folder, done.open("a", encoding="utf-8") as log:
        for number in range(len(told), given.count):
            told.append(_try(number, given.seed, Path(folder), given.folder))
            log.write(json.dumps(told[-1]) + "\n")
            log.flush()
            if number % 100 == 99:
                print(f"{number + 1}/{given.count} {_count(told)}", file=sys.stderr)
    print(table(told))
    return int(any(each["kind"] == "fault" for each in told))


def limit_memory() -> None:
    """Of this process to 2 GB more than it holds when it begins; what needs more ends in a MemoryError, a fault."""
    with suppress(ImportError, OSError):
        import resource

        held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (held + MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _quick_place() -> str | None:
    """A disk in memory where there is one: thousands of small folders come and go."""
    return "/dev/shm" if os.access("/dev/shm", os.W_OK) else None


def _try(number: int, seed: int, folder: Path, keep: Path) -> dict[str, object]:
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
    where.mkdir()
    small.write(where)
    (where / "words.json").write_text(json.dumps({"words": small.words, "why": outcome.why}, indent=1))


def _count(told: list[dict[str, object]]) -> str:
    return ", ".join(f"{kind} {n}" for kind, n in sorted(Counter(str(each["kind"]) for each in told).items()))


def table(told: list[dict[str, object]]) -> str:
    """Command by command: tried, refused, failed, accepted, faults."""
    kinds = ("refused", "failed", "accepted", "fault")
    counts = Counter((str(each["command"]), str(each["kind"])) for each in told)
    rows = [f"{'command':10} {'tried':>8} " + " ".join(f"{kind:>8}" for kind in kinds)]
    for command in sorted({command for command, _ in counts}):
        own = [counts[command, kind] for kind in kinds]
        rows.append(f"{command:10} {sum(own):8} " + " ".join(f"{n:8}" for n in own))
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main())
