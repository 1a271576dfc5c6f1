"""Every source, link and expansion of the machine tools that come along, taken out one at a time, and asked for.

`python -m bench.taken_out --limit 60 --jobs 2 --resume DIR [--only flagship_gantry]` from the folder tests/. The truth
is the machine as it is; its runs with the noise of its sensors are diagnosed by a file without the entry, the last of
three held out.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import yaml
from bench.rigs.running import Processes
from bench.shipped import ROOT, SCENARIOS, ask, say_told, simulate

from network import Machine
from network.catalogue.declaration.declare import Declared
from network.catalogue.declaration.entry_path import EntryPath, axis_of
from network.catalogue.declaration.patch import Patch
from network.machine.checks import places_of
from network.platform.refusal import Refused
from network.report.words.verdict_words import CLEAN

SECTIONS = ("sources", "links", "tcp")


@dataclass(frozen=True)
class Entry:
    """An entry of a machine: where it stands, its kind and the parts that it names."""

    machine: str
    path: EntryPath
    kind: str
    parts: frozenset[str]

    @property
    def folder(self) -> str:
        return str(self.path).replace(" ", "_").replace("/", "_")


@dataclass(frozen=True)
class Row:
    """What was told of a machine without an entry."""

    entry: Entry
    told: Mapping[str, Any] | None
    seconds: float

    @property
    def score(self) -> str:
        """right: the first finding, or what cannot be told from it, has its kind and all its parts; part: what is there
        has another name, or none; silent: it is told that nothing is missing."""
        if self.told is None:
            return "no answer"
        first = [alike for f in self.told["findings"][:1] for alike in (f, *f["indistinguishable"])]
        if any(f["kind"] == self.entry.kind and self._sits(f, all) for f in first):
            return "right"
        if any(self._sits(f, any) for f in self.told["findings"]):
            return "part"
        return "silent" if self.told["verdict"] in CLEAN else "missed"

    def _sits(self, finding: Mapping[str, Any], how: Any) -> bool:
        places = {place for place in finding["places"] if not axis_of(place)}
        return bool(how(part in places for part in self.entry.parts))

    def __str__(self) -> str:
        e = self.entry
        return f"| {e.machine} | {e.path} | {e.kind} | **{self.score}** | {say_told(self.told)} | {self.seconds:.0f} |"


def list_entries(name: str) -> Iterator[Entry]:
    """What can be taken out of a machine so that it is one still."""
    machine = Machine.load(ROOT / "machines" / f"{name}.yaml")
    for path, entry in machine.entries():
        if path.section in SECTIONS and _stands_without(machine, path):
            yield Entry(name, path, entry.kind, frozenset(_list_parts(machine, entry)))


def _list_parts(machine: Machine, entry: Declared) -> Iterator[str]:
    return (place.node for _, place in places_of(entry) if machine.nodes[place.node].is_part)


def _stands_without(machine: Machine, path: EntryPath) -> bool:
    try:
        machine.patched(_take_out(path))
    except Refused:
        return False
    return True


def _take_out(path: EntryPath) -> dict[str, Any]:
    """The patch that removes an entry."""
    return Patch.of([(path, None)]).to_plain()


def diagnose(entry: Entry, where: Path, processes: Processes) -> Row:
    """What is told of a machine without an entry by runs of the whole of it."""
    folder = where / entry.machine / entry.folder
    less = write_machine(folder / "machine.yaml", entry.machine, _take_out(entry.path))
    runs = [f"../run{i}/results.csv" for i in range(len(SCENARIOS[entry.machine]))]
    return Row(entry, *ask(less, runs, folder, processes))


def record(name: str, where: Path, processes: Processes) -> None:
    """The runs of a machine as it is."""
    simulate(name, write_machine(where / name / "truth.yaml", name, {}).parent, processes)


def write_machine(file: Path, name: str, changes: Mapping[str, Any]) -> Path:
    """A machine that comes along, with changes."""
    file.parent.mkdir(parents=True, exist_ok=True)
    given = {"extends": str(ROOT / "machines" / f"{name}.yaml"), **changes}
    file.write_text(yaml.safe_dump(given), encoding="utf-8")
    return file


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--limit", type=float, default=60.0, metavar="S", help="of a processor for each diagnosis")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="diagnoses at a time")
    parser.add_argument("--resume", type=Path, required=True, metavar="DIR", help="where answers are kept")
    parser.add_argument("--only", choices=sorted(SCENARIOS), action="append", help="of these machines alone")
    given = parser.parse_args()
    processes, names, where = Processes(given.limit), given.only or [*SCENARIOS], given.resume.resolve()
    scores: Counter[str] = Counter()
    print("| machine | taken out | kind | score | told (confidence) | s |\n|---|---|---|---|---|---|")
    with ThreadPoolExecutor(given.jobs) as pool:
        try:
            [*pool.map(partial(record, where=where, processes=processes), names)]
            entries = [entry for name in names for entry in list_entries(name)]
            for row in pool.map(partial(diagnose, where=where, processes=processes), entries):
                scores[row.score] += 1
                print(row, flush=True)
        except KeyboardInterrupt:
            processes.end()
            return 130
    print(", ".join(f"{count} {score}" for score, count in scores.most_common()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
