"""What the logs of `make torture` hold, as the README has it.

python -m torture.told --folder ../.torture
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from torture import __main__ as fuzz
from torture import survivors
from torture.log import Told, read_numbered

SIGNALS = {"SIGINT": "Ctrl-C", "SIGTERM": "SIGTERM", "SIGKILL": "SIGKILL"}
EXACTLY = "exact 1e-9 of the heat or 1e-11 K of all parts, steps 1e-4"
WAYS = (
    ("energy in, out and stored", EXACTLY, ("energy",)),
    ("a machine written out and read again", "nothing", ("written and read",)),
    ("modes or subspace with `expm`", "1e-9 K per kelvin, and what `krylov` tells of itself", ("expm",)),
    ("modes or switchings with `rosenbrock`", "2e-6 K per kelvin; where it switches or bends, with steps a hundred "
     "times finer", ("rosenbrock", "rosenbrock, finer")),
    ("with LSODA, BDF, Radau, RK45", "2e-6 K per kelvin, times √switchings", ("LSODA", "BDF", "Radau", "RK45")),
    ("slopes by numbers with differences", "a twentieth", ("slopes",)),
    ("numbers found again in a noisy recording of the machine", "5 standard errors", ("found again",)),
)  # fmt: skip
"""What was compared, what it may be apart, and how the log calls it."""


def rows_of(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table of Markdown."""
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in (head, ["---"] * len(head), *rows))


def tell_agreement(told: Sequence[Told]) -> str:
    kinds = Counter(each["kind"] for each in told)
    parts = [each["parts"] for each in told]
    text = f"{_group(len(told))} random networks of {min(parts)} to {max(parts)} parts ("
    text += ", ".join(f"{_group(count)} {kind}" for kind, count in kinds.most_common()) + ")\n\n"
    rows = []
    for name, allowed, ways in WAYS:
        found = [[each["apart"][way] for way in ways if way in each["apart"]] for each in told]
        furthest = [max(apart) for apart in found if apart]
        beyond = sum(not apart <= 1 for apart in furthest)
        rows.append((name, _group(len(furthest)), allowed, f"{max(furthest, default=0.0):.2g}", beyond))
    return text + rows_of(("compared", "networks", "allowed", "furthest, of what is allowed", "beyond"), rows)


def tell_stops(told: Sequence[Told]) -> str:
    numbers = Counter(each["what"].split()[-1] for each in told)
    each = ", ".join(f"{numbers[number]} by {name}" for number, name in SIGNALS.items())
    return f"{_group(len(told))} commands stopped ({each}): {_held(told)}"


def tell_faults(told: Sequence[Told]) -> str:
    numbers = Counter(each["what"].partition(":")[0] for each in told)
    return f"{len(told)} times ({', '.join(f'{n} {what}' for what, n in sorted(numbers.items()))}): {_held(told)}"


def _held(told: Sequence[Told]) -> str:
    broken = [f"\n{each['what']}: {each['why']}" for each in told if each["why"]]
    return f"{_group(len(told) - len(broken))} of {_group(len(told))} held" + "".join(broken)


def _group(count: int) -> str:
    return f"{count:,}".replace(",", " ")


LOGS = (
    ("Wrong files", "done-0.jsonl", fuzz.table, lambda each: each["kind"] == "fault"),
    ("Stops", "stops.jsonl", tell_stops, lambda each: bool(each["why"])),
    ("The computer lets it down", "faults.jsonl", tell_faults, lambda each: bool(each["why"])),
    ("Agreement", "agreement.jsonl", tell_agreement, lambda each: any(not a <= 1 for a in each["apart"].values())),
    ("Changed letters", "survivors.jsonl", survivors.table, lambda each: False),
)
"""Heading, file, how it is told, and what of it is wrong."""


TABLE = "\n\n"
"""What goes before one."""


def main() -> int:
    """1 where anything is wrong."""
    parser = argparse.ArgumentParser(prog="torture.told", description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path(".torture"))
    folder, wrong = parser.parse_args().folder, 0
    for name, file, tell, is_wrong in LOGS:
        told = [*read_numbered(folder / file).values()]
        if told:
            text = tell(told)
            print(f"**{name}.**{TABLE if text.startswith('|') else ' '}{text}\n")
            wrong += sum(map(is_wrong, told))
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
