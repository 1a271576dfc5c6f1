"""Which tests run a line of the code, and how long each takes: a change is seen soonest by the quickest that run it."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from torture.asked import WHOLE, ask

LONGEST = 40.0
"""s of the processor for a test file; what it has not come to by then is not asked."""


@dataclass
class Reach:
    """lines: module → line → tests; seconds: test → how long it takes a processor."""

    lines: dict[str, dict[int, list[str]]] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    def tests_of(self, module: Path, lines: Iterable[int], budget: float) -> list[str]:
        """The quickest that run one of the lines, within a budget [s], one at least."""
        known = self.lines.get(module.as_posix(), {})
        tests = {test for line in lines for test in known.get(line, ()) if test in self.seconds}
        chosen, spent = list[str](), 0.0
        for test in sorted(tests, key=lambda test: (self.seconds[test], test)):
            spent += self.seconds[test]
            if chosen and spent > budget:
                break
            chosen.append(test)
        return chosen

    def add(self, told: Mapping[str, Any]) -> None:
        """What `torture.lines` tells of the tests of a file."""
        for test, its in told.items():
            self.seconds[test] = its["seconds"]
            for module, lines in its["lines"].items():
                known = self.lines.setdefault(module, {})
                for line in lines:
                    known.setdefault(line, []).append(test)


def trace(names: Iterable[str], rooms: Sequence[str], folder: Path) -> Reach:
    """In the project that is the working folder; what is in the folder is not traced again."""
    folder.mkdir(parents=True, exist_ok=True)
    found = Reach()
    for name in names:
        report = folder / f"{Path(name).stem}.json"
        if not report.is_file():
            settings = {"LINES_OF": os.pathsep.join(rooms), "LINES_TO": str(report), "LINES_LONGEST": str(LONGEST)}
            ask(["-p", "torture.lines", name], 2 * LONGEST, settings, like=WHOLE)
            print(f"{name} traced", file=sys.stderr, flush=True)
        if report.is_file():
            found.add(json.loads(report.read_text("utf-8")))
    return found
