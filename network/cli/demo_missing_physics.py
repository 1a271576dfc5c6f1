"""The last chapter of the demonstration: a gantry mill with a cooler that its file does not know, found and added."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from network.analysis.comparison.compare import Comparison, RecordingResidual
from network.analysis.diagnosis.diagnose import diagnose
from network.analysis.diagnosis.findings.result import Diagnosis, Fits
from network.machine.machine import Machine
from network.platform.package_data import find_shipped
from network.recordings.recording import Recording
from network.report.files.diagnosis_files import write_diagnosis
from network.report.progress import share_bar
from network.report.words.words import tell_worst

MACHINE, HELD_OUT = "flagship_gantry.yaml", "flagship_third_speed.csv"
TRAIN = ("flagship_6000rpm.csv", "flagship_8000rpm.csv")


def tell_missing(where: Path) -> Iterator[str]:
    """The diagnosis in words; its files go into a folder of their own."""
    machine = Machine.load(find_shipped("machines", MACHINE))
    runs = [Recording.load(find_shipped("scenarios", name)) for name in (*TRAIN, HELD_OUT)]
    yield f"{machine.name}: {machine.file}, and recordings of"
    yield f"the machine as it really is: {', '.join(TRAIN)}; {HELD_OUT} is held out."
    with share_bar("diagnosing") as tell:
        diagnosis = diagnose(machine, runs[:-1], runs[-1:], jobs=os.cpu_count() or 1, progress=tell)
    yield "Calibrated, the file as written still leaves:"
    for r in diagnosis.fits.train_before.recordings:
        yield f"  {r.recording.file.rpartition('/')[2]}: {_tell_residual(r)}"
    yield ""
    yield from str(diagnosis).splitlines()[1:]
    yield from _one_for_all(diagnosis)
    write_diagnosis(diagnosis, where / "found")
    yield f"Look at {where / 'found' / 'report.html'}: the whole case on one page"


def _tell_residual(residual: RecordingResidual) -> str:
    """The clearest swing and the worst window of a run."""
    swings = [t.period for t in residual.tests.values() if t.period is not None]
    clearest = max(swings, key=lambda s: s.in_noise, default=None)
    return f"{clearest.sentence}. {tell_worst(residual)}" if clearest else tell_worst(residual)


def _one_for_all(found: Diagnosis) -> Iterator[str]:
    """How one set of numbers serves every run, in noise units."""
    yield "One set of numbers now serves every speed (rms residual in noise units, before and after):"
    for before, after in _pairs(found.fits):
        for b, a in zip(before.recordings, after.recordings, strict=True):
            yield f"  {b.recording.file.rpartition('/')[2]:28} {b.rmse_in_noise:6.2f} {a.rmse_in_noise:6.2f}"


def _pairs(fits: Fits) -> Iterator[tuple[Comparison, Comparison]]:
    yield fits.train_before, fits.train_after
    if fits.holdout_before is not None and fits.holdout_after is not None:
        yield fits.holdout_before, fits.holdout_after
