"""One heat concealed in every machine tool that comes along, whatever its laws, relays, axes and lumps.

`python -m bench.shipped --limit 60 --jobs 2 --resume DIR` from the folder tests/. The truth is the machine with a heat
at one part; its runs with the noise of its sensors are diagnosed by the machine without it, the last of three held out.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from bench.rigs.running import COMMAND, TIMED, Processes

from network import Machine

ROOT = Path(__file__).parents[2]
POWER, SECRET = 90.0, "secret"
"""W of the heat that is concealed, and its name in the truth."""
SCENARIOS = {
    "ball_screw_axis": ("iso230_linear_axis", "axis_back_and_forth"),
    "belt_lathe": ("constant_3000", "iso230_spindle_spectrum", "shop_day"),
    "chilled_spindle": ("day_of_work", "iso230_spindle_spectrum"),
    "described_spindle": ("day_of_work", "iso230_spindle_spectrum"),
    "flagship_gantry": ("day_of_work", "iso230_spindle_spectrum"),
    "gantry_spindle": ("iso230_spindle_spectrum", "day_of_work", "shop_day"),
    "new_machine": ("new_machine_day",),
    "table_bending": ("table_under_cutting",),
    "vertical_mill": ("day_of_work", "shop_day", "iso230_spindle_spectrum"),
}
"""Of every machine, those of the scenarios beside it that it can run through."""


@dataclass(frozen=True)
class Row:
    """What was told of a machine in whose truth a part is heated."""

    name: str
    part: str
    lumps: int
    told: Mapping[str, Any] | None
    seconds: float

    @property
    def findings(self) -> Sequence[Mapping[str, Any]]:
        return self.told["findings"] if self.told else ()

    @property
    def score(self) -> str:
        """right: the first finding is a steady heat at the part, or cannot be told from it; part: what is there has
        another name, or none, or comes second."""
        if self.told is None:
            return "no answer"
        first = [alike for f in self.findings[:1] for alike in (f, *f["indistinguishable"])]
        if any(f["kind"] == "heat_source" and f["places"] == [self.part] for f in first):
            return "right"
        return "part" if any(self.part in f["places"] for f in self.findings) else "missed"

    def __str__(self) -> str:
        told = say_told(self.told)
        return f"| {self.name} | {self.lumps} | {self.part} | **{self.score}** | {told} | {self.seconds:.0f} |"


def say_told(told: Mapping[str, Any] | None) -> str:
    """Verdict and findings in a line."""
    if told is None:
        return "–"
    found = (f"{f['kind']} {' – '.join(f['places'])} ({f['confidence']:.2f})" for f in told["findings"])
    return f"{told['verdict']}: {'; '.join(found) or 'nothing'}"


def conceal(name: str, folder: Path) -> str:
    """Writes the truth of a machine, and tells the part that it heats."""
    machine = Machine.load(ROOT / "machines" / f"{name}.yaml")
    parts = [part for part, node in machine.nodes.items() if node.is_part]
    heated = parts[len(parts) // 2]
    secret = {"kind": "heat_source", "into": {heated: 1}, "power": f"{POWER:g} W"}
    truth = {"extends": str(ROOT / "machines" / f"{name}.yaml"), "sources": {SECRET: secret}}
    (folder / "truth.yaml").write_text(yaml.safe_dump(truth), encoding="utf-8")
    return heated


def simulate(name: str, folder: Path, processes: Processes) -> list[str]:
    """The recordings of the truth, one for each scenario."""
    runs = []
    for i, scenario in enumerate(SCENARIOS[name]):
        source, runs = str(ROOT / "scenarios" / f"{scenario}.yaml"), [*runs, f"run{i}/results.csv"]
        words = ("simulate", "truth.yaml", source, "--noise", "--seed", str(i), "--no-plots", "-o", f"run{i}")
        if not (folder / runs[-1]).is_file():
            processes.run((*COMMAND, *words), folder, folder / f"run{i}.log")
    return runs


def ask(machine: Path, runs: Sequence[str], folder: Path, processes: Processes) -> tuple[dict[str, Any] | None, float]:
    """What a diagnosis by a machine tells of the first two runs, the others held out, and the seconds it took; kept in
    a folder."""
    kept, result = folder / "seconds", folder / "told" / "diagnosis.json"
    held = [word for run in runs[2:] for word in ("--holdout", run)]
    limits = ("--jobs", "1", "--budget", f"{TIMED * processes.limit:.0f} s")
    if not kept.is_file():
        words = (*COMMAND, "diagnose", str(machine), *runs[:2], *held, "-o", "told", "--no-plots", *limits)
        _, seconds = processes.run(words, folder, folder / "told.log")
        kept.write_text(f"{seconds:.1f}")
    told = json.loads(result.read_text(encoding="utf-8")) if result.is_file() else None
    return told, float(kept.read_text())


def diagnose(name: str, where: Path, processes: Processes) -> Row:
    """What is told of a machine by its runs."""
    folder, machine = where / name, ROOT / "machines" / f"{name}.yaml"
    folder.mkdir(parents=True, exist_ok=True)
    part, runs = conceal(name, folder), simulate(name, folder, processes)
    return Row(name, part, Machine.load(machine).lumps, *ask(machine, runs, folder, processes))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--limit", type=float, default=60.0, metavar="S", help="of a processor for each diagnosis")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="diagnoses at a time")
    parser.add_argument("--resume", type=Path, required=True, metavar="DIR", help="where answers are kept")
    given = parser.parse_args()
    processes = Processes(given.limit)
    print("| machine | lumps | heated | score | told (confidence) | s |\n|---|---|---|---|---|---|")
    with ThreadPoolExecutor(given.jobs) as pool:
        try:
            for row in pool.map(lambda name: diagnose(name, given.resume.resolve(), processes), SCENARIOS):
                print(row, flush=True)
        except KeyboardInterrupt:
            processes.end()
            return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
