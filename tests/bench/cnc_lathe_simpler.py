"""How simple may the turning centre be: its levels, and its file without one sensor after the other, each calibrated on
every fourth day and told on the others.

`python -m bench.cnc_lathe_simpler --resume DIR` in tests/; a stopped run goes on from DIR.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from bench import cnc_lathe_told as told
from bench.cnc_lathe_figures import Miss, miss, over_days
from bench.cnc_lathe_runs import DISPLACEMENTS, Day, runs

from network import Machine
from network.platform.yaml.document import dump

APART = 4
"""Every so many days one is for the calibration."""


def variants(machine: Machine, levels: Sequence[str]) -> Iterator[tuple[str, Machine]]:
    """By name: the machine as it is, its levels, and without each of its thermometers."""
    yield "as it is", machine
    for level in levels:
        yield level, Machine.load(told.MACHINE, level=level)
    for name in machine.sensors:
        if name not in DISPLACEMENTS:
            yield f"without {name}", machine.patched({"sensors": {name: None}})


def score(machine: Machine, days: Sequence[Day], folder: Path, resume: Path | None) -> Miss:
    """Over the days that the calibration does not see."""
    file = folder / "machine.yaml"
    file.write_text(dump(machine.to_plain()), encoding="utf-8")
    tell = told.simulated(told.calibrated_machine(days[::APART], file, resume))
    return over_days([miss(day, tell(day)) for k, day in enumerate(days) if k % APART])


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.cnc_lathe_simpler", description=__doc__)
    parser.add_argument("--resume", type=Path, metavar="DIR")
    parser.add_argument("--levels", default="nine parts,seven parts,five parts,still air")
    given, machine, days = parser.parse_args(words), Machine.load(told.MACHINE), runs()
    if not days:
        print("the recordings in ../shared/recordings are not here")
        return
    print("| | X | Z | X, mean out | Z, mean out |\n|---|---|---|---|---|")
    for name, variant in variants(machine, [level for level in given.levels.split(",") if level]):
        with tempfile.TemporaryDirectory() as folder:
            found = score(variant, days, Path(folder), given.resume)
        figures = " | ".join(f"{value:.1f}" for value in (*found.absolute, *found.mean_out))
        print(f"| {name} | {figures} |", flush=True)


if __name__ == "__main__":
    main()
