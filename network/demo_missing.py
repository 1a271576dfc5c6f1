"""The last chapter of the demonstration: recordings of a machine with something in it that its file does not know."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from network.csvtable import write_csv
from network.diagnosis.diagnosing import diagnose
from network.machine import Machine
from network.recording import Recording
from network.report.diagnosis_files import write_diagnosis
from network.scenario import Scenario
from network.shipped import shipped
from network.simulation import simulate

CONCEALED = "sources.pump={kind: heat_source, into: {headstock: 1}, power: 90 W}"
RUNS = (("warm_up_and_stop", 3), ("day_of_work", 4))
"""Scenarios and the seeds of their noise; the last is held out."""


def tell_missing(machine_file: Path, where: Path) -> Iterator[str]:
    """The diagnosis in words; its files go into a folder of their own."""
    truth = Machine.load(machine_file, sets=(CONCEALED,))
    runs = [_recorded(truth, name, seed, where) for name, seed in RUNS]
    yield f"Two recordings are made of the machine with {CONCEALED}, one is held out; the file knows nothing of it."
    found = diagnose(Machine.load(machine_file), runs[:-1], runs[-1:], jobs=os.cpu_count() or 1)
    yield from str(found).splitlines()[1:]
    write_diagnosis(found, where / "found")
    yield f"Look at {where / 'found' / 'report.html'}: the whole case on one page"


def _recorded(truth: Machine, name: str, seed: int, where: Path) -> Recording:
    made = simulate(truth, Scenario.load(shipped("scenarios", f"{name}.yaml")), noise_seed=seed)
    columns = {n: (unit_text, values) for n, unit_text, values in made.columns() if not n.startswith("tcp.")}
    write_csv(where / f"{name}.csv", made.t, columns)
    return Recording.load(where / f"{name}.csv")
