"""What recordings are called: by their file, with as many of its folders as it takes to tell two apart."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from network.analysis.comparison.compare import Comparison, RecordingResidual
    from network.analysis.diagnosis.findings.result import Diagnosis
    from network.recordings.recording import Recording


def name_recording(d: Diagnosis, residual: RecordingResidual) -> str:
    """The name of a recording among all of a diagnosis: results.csv, or one/results.csv beside two/results.csv."""
    sides = (d.fits.train_after, d.fits.holdout_after)
    files = [r.recording.file for side in sides if side is not None for r in side.recordings]
    return apart([*files, residual.recording.file])[residual.recording.file]


def title_of(recording: Recording) -> str:
    """What a picture calls it: by the name that its mapping gives, else by its file and folder, for each run of
    `lptn simulate` is called results.csv."""
    path = Path(recording.file.partition(", part ")[0])
    folder = path.absolute().parent.name
    return f"{folder}/{recording.name}" if folder and recording.name.startswith(path.stem) else recording.name


def stems_of(comparison: Comparison) -> list[str]:
    """What the files of a comparison are called without their endings, numbered where two are called alike."""
    stems = [Path(r.recording.file).stem for r in comparison.recordings]
    return stems if len(set(stems)) == len(stems) else [f"{i}-{stem}" for i, stem in enumerate(stems, 1)]


def apart(files: Iterable[str]) -> dict[str, str]:
    """File → the shortest end of its path that no other has."""
    paths = {file: Path(file).absolute().parts for file in files}
    return {file: _end(parts, [p for p in paths.values() if p != parts]) for file, parts in paths.items()}


def _end(parts: tuple[str, ...], others: list[tuple[str, ...]]) -> str:
    lengths = range(1, len(parts) + 1)
    enough = next((n for n in lengths if all(p[-n:] != parts[-n:] for p in others)), len(parts))
    return "/".join(parts[-enough:])
