"""Do intervals of 95 % hold the truth, and bands the readings of runs not seen? Machines drawn from their own priors,
recorded by other code, and fitted.

`python -m bench.coverage [machines [machines with bands]]`, or with the others by `make bench`.
"""

from __future__ import annotations

import os
import sys
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from unittest.mock import patch

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from proof.drawn import Drawn, drawn_machine
from proof.programs import Program
from rich.console import Console
from rich.table import Table

from network import Machine, Recording, calibrate
from network.analysis.calibration.band_coverage import pool_coverage
from network.analysis.calibration.gauss_newton import make_problem, minimise
from network.analysis.calibration.measured_means import weigh_recording
from network.engine.response.parameters import free_parameters

MACHINES, INSIDE = 200, 1.96
BANDED = 30
CONCEALED = ("links.slide skin", "links.housing skin", "sources.motor loss")
"""Of which one is taken out of the file in turn."""


@dataclass
class Count:
    """Deviations from the truth in standard errors."""

    z: list[float] = field(default_factory=list)

    def row(self, name: str) -> tuple[str, str, str, str]:
        z = np.array(self.z)
        return name, f"{len(z)}", f"{100 * np.mean(np.abs(z) < INSIDE):.1f} %", f"{np.sqrt(np.mean(z**2)):.3f}"


def loaded(drawn: Drawn) -> tuple[Machine, list[Recording]]:
    """The machine and its recordings, through files."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "machine.yaml").write_text(drawn.machine)
        recordings = []
        for i, recording in enumerate(drawn.recordings):
            (Path(folder) / f"run{i}.csv").write_text(recording.text())
            recordings.append(Recording.load(Path(folder) / f"run{i}.csv"))
        return Machine.load(Path(folder) / "machine.yaml"), recordings


def deviations(drawn: Drawn, edges_known: bool) -> list[float]:
    machine, recordings = loaded(drawn)
    data = [weigh_recording(machine, r) for r in recordings]
    if edges_known:
        data = [replace(d, edges=()) for d in data]
    at = minimise(make_problem(machine, free_parameters(machine), data))
    errors = np.sqrt(np.diag(at.covariance)[: at.free])
    true = [drawn.true[p.path] for p in at.problem.parameters]
    theta = [np.log(x) if p.is_log else x for p, x in zip(at.problem.parameters, true, strict=True)]
    return ((at.theta - theta) / errors).tolist()


def between_samples(program: Program) -> Program:
    """Edges where they fall."""
    return replace(program, mean=round(program.mean, 2), waves=())


@dataclass
class Bands:
    """Of machines: share of the readings of their held-out runs inside their bands, and the half width [um]."""

    inside: list[float] = field(default_factory=list)
    wide: list[float] = field(default_factory=list)
    numbers: Count = field(default_factory=Count)

    def row(self, name: str) -> tuple[str, ...]:
        inside, z = np.array(self.inside), np.array(self.numbers.z)
        held = f"{100 * inside.mean():.1f} % ± {100 * inside.std() / np.sqrt(len(inside)):.1f}"
        most = f"{100 * np.mean(inside > 0.9):.0f} %"
        numbers = f"{100 * np.mean(np.abs(z) < INSIDE):.1f} % of {len(z)}" if len(z) else "–"
        return name, f"{len(inside)}", held, most, f"±{np.median(self.wide):.2g} µm", numbers


def band(into: Bands, seed: int, train: int, concealed: str | None) -> None:
    """One machine calibrated on so many runs, and its bands on two more."""
    with patch("proof.drawn.snapped", between_samples):
        drawn = drawn_machine(np.random.default_rng(seed), runs=train + 2)
    machine, recordings = loaded(drawn)
    if concealed is not None:
        section, name = concealed.split(".")
        machine = machine.patched({section: {name: None}})
    found = calibrate(machine, recordings[:train], recordings[train:], seed=seed)
    into.inside.append(pool_coverage(found.coverage) or 0.0)
    into.wide.append(max(b.widest for own in found.bands[train:] for b in own))
    if concealed is None:
        true = [np.log(drawn.true[p.path]) if p.is_log else drawn.true[p.path] for p in found.parameters]
        into.numbers.z += ((found.theta - true) / found.std).tolist()


def tell_bands(machines: int) -> None:
    table = Table(title="bands of 95 % of the tool centre point, on two held-out runs each (90–98 %)")
    for heading in ("machine", "machines", "readings inside", "machines over 90 %", "half width", "numbers inside"):
        table.add_column(heading, justify="right")
    for train in (1, 4):
        right, wrong = Bands(), Bands()
        for seed in range(machines):
            band(right, seed, train, None)
            band(wrong, seed, train, CONCEALED[seed % len(CONCEALED)])
        table.add_row(*right.row(f"complete, from {train}"))
        table.add_row(*wrong.row(f"an entry missing, from {train}"))
    Console(width=140).print(table)


def main(machines: int = MACHINES, banded: int = BANDED) -> None:
    table = Table(title=f"{machines} machines drawn from their priors: true numbers inside the 95 % interval (93–97 %)")
    for heading in ("instants of the jumps", "numbers", "inside", "rms deviation in standard errors"):
        table.add_column(heading, justify="right")
    known, free = Count(), Count()
    for seed in range(machines):
        known.z += deviations(drawn_machine(np.random.default_rng(seed)), edges_known=True)
        with patch("proof.drawn.snapped", between_samples):
            free.z += deviations(drawn_machine(np.random.default_rng(seed)), edges_known=False)
    table.add_row(*known.row("on samples, and known to be"))
    table.add_row(*free.row("anywhere between samples, estimated"))
    Console(width=140).print(table)
    tell_bands(banded)


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3]))
