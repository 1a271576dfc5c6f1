"""The last chapter of the demonstration: the paper's machine with its cooler concealed, and what finds it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from network.diagnosis.diagnosing import diagnose
from network.machine import Machine
from network.recording import Recording
from network.report.progress import share_bar
from network.shipped import shipped

TRAINING, UNSEEN = ("flagship_6000rpm.csv", "flagship_8000rpm.csv"), "flagship_third_speed.csv"


def tell_missing(where: Path) -> Iterator[str]:
    """The diagnosis of the flagship in words; its files go into a folder of their own."""
    from network.report.diagnosis_files import write_diagnosis

    machine = Machine.load(shipped("machines", "flagship_gantry.yaml"))
    runs = [Recording.load(shipped("scenarios", name)) for name in TRAINING]
    unseen = Recording.load(shipped("scenarios", UNSEEN))
    yield f"{machine.name}: one lump for each part, the coolant at a constant temperature."
    yield "Recordings at 6000 and 8000 rpm, made by separate code on a fine mesh with a cooler that switches; a third"
    yield "speed is never used in a fit."
    with share_bar("looking for what is missing") as tell:
        found = diagnose(machine, runs, [unseen], jobs=os.cpu_count() or 1, progress=tell)
    yield from str(found).splitlines()[1:]
    yield f"Look at {where / 'found' / 'report.html'}, the case on one page."
    write_diagnosis(found, where / "found")
