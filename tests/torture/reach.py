"""Which tests run a line of the code, and how long each takes: a change is seen soonest by the quickest that run it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

LONGEST = 300.0
"""s for a test file; what it has not come to by then is not asked."""
TOOK = re.compile(r"^([\d.]+)s (?:call|setup) +(tests/\S+?::\w+)", re.MULTILINE)


@dataclass
class Reach:
    """lines: module → line → tests; seconds: test → how long it takes."""

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

    def add(self, told: str, files: dict[str, Any]) -> None:
        """Of one test file: what pytest tells of its tests, and coverage's report of the lines by test."""
        for seconds, test in TOOK.findall(told):
            self.seconds[test] = self.seconds.get(test, 0.0) + float(seconds)
        for module, report in files.items():
            lines = self.lines.setdefault(Path(module).as_posix(), {})
            for line, tests in report["contexts"].items():
                names = (f"tests/{name.replace('.', '.py::')}" for name in tests if name)
                lines.setdefault(int(line), []).extend(names)


def trace(names: Iterable[str], rooms: Sequence[str], folder: Path) -> Reach:
    """In the project that is the working folder; what is in the folder is not traced again."""
    folder.mkdir(parents=True, exist_ok=True)
    settings = "\n    ".join(rooms)
    (folder / "settings").write_text(f"[run]\ndynamic_context = test_function\nsource = {settings}\n")
    found = Reach()
    for name in names:
        told, report = folder / f"{Path(name).stem}.txt", folder / f"{Path(name).stem}.json"
        if not told.is_file():
            told.write_text(_run(name, folder, report), encoding="utf-8")
        if report.is_file():
            found.add(told.read_text("utf-8"), json.loads(report.read_text("utf-8"))["files"])
    return found


def _run(name: str, folder: Path, report: Path) -> str:
    own = (f"--rcfile={folder / 'settings'}", f"--data-file={report.with_suffix('.cov')}")
    tests = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "not speed", "--durations=0")
    coverage = (sys.executable, "-m", "coverage")
    run = (*coverage, "run", *own, *tests, "--durations-min=0", name)
    try:
        told = subprocess.run(run, check=False, timeout=LONGEST, capture_output=True, text=True).stdout
    except subprocess.TimeoutExpired:
        return ""
    write = (*coverage, "json", *own, "--show-contexts", "-o", str(report))
    subprocess.run(write, check=False, capture_output=True)
    return told
