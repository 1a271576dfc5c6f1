"""What tells the CNC lathe's displacement: nothing, two ridges, and the machine file, as written and calibrated.

All but the ridge on temperatures see a day's schedule, feed and room, and of its measurements the first minute only.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from bench.cnc_lathe_figures import Fold, Tell, grid
from bench.cnc_lathe_runs import DISPLACEMENTS, ROOT, THINNED, Day, for_fit
from bench.ridge import Run, fit_ridge, lagged

from network import Machine, calibrate, simulate
from network.catalogue.declaration.declare import Array
from network.platform.yaml.document import dump

MACHINE = ROOT / "machines" / "cnc_lathe.yaml"


def nothing(_: Fold) -> Tell:
    """No displacement."""
    return lambda day: np.zeros((len(day.recording.t), len(DISPLACEMENTS)))


def ridge_on_schedule(fold: Fold) -> Tell:
    return _ridge(fold, lambda day: _scheduled(day.blanked()))


def ridge_on_temperatures(fold: Fold) -> Tell:
    """Reads the day's temperatures all along: it is no prediction from a schedule."""
    return _ridge(fold, lambda day: _measured(day.blanked(*day.temperatures)))


def _scheduled(day: Day) -> Array:
    """Speed, feed and the room's rise since the first minute, and their lags; the machine stood before."""
    t, room = day.recording.t, day.values("ambient")
    standing = np.zeros(2)
    rise = room - room[day.begins].mean(axis=0)
    return np.hstack([lagged(t, day.values("speed", "feed"), standing, held=True), lagged(t, rise, np.zeros(1))])


def _measured(day: Day) -> Array:
    """All temperatures but the room's as rises since the first minute, and their lags."""
    T = day.values(*day.temperatures)
    return lagged(day.recording.t, T - T[day.begins].mean(axis=0), np.zeros(T.shape[1]))


def _ridge(fold: Fold, features: Callable[[Day], Array]) -> Tell:
    fit = fit_ridge([_run(day, features(day)) for day in fold.training])
    return lambda day: fit.predict(features(day)) * 1e-6


def _run(day: Day, features: Array) -> Run:
    at = grid(day.recording.t)
    targets = np.where(day.counted, day.values(*DISPLACEMENTS) * 1e6, np.nan)
    return Run(features[at], targets[at])


def as_written(_: Fold, path: Path = MACHINE) -> Tell:
    return simulated(Machine.load(path))


def simulated(machine: Machine) -> Tell:
    """Along schedule, feed and room, from where the first minute's readings say that the machine begins."""

    def tell(day: Day) -> Array:
        run = simulate(machine, day.blanked().recording, parts=False)
        return np.stack([run.sensors[name] for name in DISPLACEMENTS], axis=1)

    return tell


def calibrated(fold: Fold, path: Path = MACHINE, resume: Path | None = None) -> Tell:
    """The machine file with its uncertain numbers from the training runs."""
    return simulated(calibrated_machine(fold.training, path, resume))


def calibrated_machine(training: Sequence[Day], path: Path = MACHINE, resume: Path | None = None) -> Machine:
    """Calibrated, or read from the folder `resume`, where it was kept by an earlier call with the same files."""
    kept = resume / f"{mark(training, path)}.yaml" if resume is not None else None
    if kept is not None and kept.is_file():
        return Machine.load(kept)
    found = calibrate(Machine.load(path), [for_fit(day) for day in training]).machine
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        beside = kept.with_suffix(f".{os.getpid()}")
        beside.write_text(dump(found.to_plain()), encoding="utf-8")
        beside.replace(kept)
    return found


def mark(training: Sequence[Day], path: Path) -> str:
    """Of what a calibration follows from: machine, training runs, and the program itself; comments do not count."""
    said = hashlib.sha256(f"{THINNED} {' '.join(day.name for day in training)}\n".encode())
    said.update(dump(Machine.load(path).to_plain()).encode())
    for file in sorted((ROOT / "network").rglob("*.py")):
        said.update(file.read_bytes())
    return said.hexdigest()[:16]
