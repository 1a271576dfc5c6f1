"""The recorded runs of the CNC lathe: which there are, in which climate, read through the project's mapping."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from network import Recording
from network.catalogue.declaration.declare import Array, Mask

ROOT = Path(__file__).parents[2]
FOLDER = ROOT.parent / "shared" / "recordings" / "cnc-lathe"
MAPPING = ROOT / "tests" / "recordings" / "cnc_lathe.yaml"

CLIMATES: Mapping[str, tuple[str, ...]] = {
    "25 °C": ("0615", "0616", "0617", "0618"),
    "20 °C": ("0701", "0702", "0703"),
    "20 → 25 °C": ("0708", "0709", "0710", "0713"),
    "30 °C": ("0727", "0729", "0730", "0807", "0810"),
    "35 °C": ("0805",),
    "30 → 20 °C": ("0813", "0814"),
    "20 → 30 °C": ("0817", "0818"),
    "18 °C": ("0820",),
}
"""What the room was set to, with the days (month and day)."""
CLIMATE_OF = {day: climate for climate, days in CLIMATES.items() for day in days}
OTHER = "other"
"""The climate of days that are not listed."""
INPUTS = ("speed", "feed", "ambient")
DISPLACEMENTS = ("disp_x", "disp_z")
FIRST = 60.0
"""s: the beginning of a run that a prediction may read."""
THINNED = 240.0
"""s between the samples that a fit is given; parts of the machine take ten minutes and more."""
FALSE = 90e-6
"""m: from here on a displacement is no reading."""


@dataclass(frozen=True, eq=False)
class Day:
    """A run. name: month and day; climate: a key of CLIMATES."""

    name: str
    climate: str
    recording: Recording

    def values(self, *names: str) -> Array:
        """Some columns in SI (°C), samples × columns."""
        return np.stack([self.recording.columns[name].values for name in names], axis=1)

    @property
    def measurements(self) -> tuple[str, ...]:
        """The columns that are neither schedule nor room."""
        return tuple(name for name in self.recording.columns if name not in INPUTS)

    @property
    def temperatures(self) -> tuple[str, ...]:
        return tuple(name for name in self.measurements if name not in DISPLACEMENTS)

    @property
    def begins(self) -> Mask:
        """Samples of the first minute."""
        return np.asarray(self.recording.t <= self.recording.t[0] + FIRST)

    @property
    def counted(self) -> Mask:
        """Where x and z are readings, samples × 2: the spindle turns (else the last value is repeated), none false."""
        moves = self.recording.columns["speed"].values != 0
        return np.asarray(moves[:, None] & (np.abs(self.values(*DISPLACEMENTS)) < FALSE))

    def with_values(self, names: tuple[str, ...], values: Array) -> Day:
        """Other readings in some columns."""
        own = self.recording.columns
        changed = {name: replace(own[name], values=values[:, k]) for k, name in enumerate(names)}
        return replace(self, recording=replace(self.recording, columns={**own, **changed}))

    def blanked(self, *kept: str) -> Day:
        """Without any measurement after the first minute, but for the columns named."""
        names = tuple(name for name in self.measurements if name not in kept)
        return self.with_values(names, np.where(self.begins[:, None], self.values(*names), np.nan))


def runs() -> tuple[Day, ...]:
    """All runs, by date."""
    return tuple(loaded(path) for path in sorted(FOLDER.glob("run_*.csv")))


def loaded(path: Path) -> Day:
    """One run through the mapping, its `file:` put in place of the one that stands there."""
    lines = MAPPING.read_text(encoding="utf-8").splitlines()
    changed = [f"file: {path}" if line.startswith("file:") else line for line in lines]
    with tempfile.TemporaryDirectory() as folder:
        mapping = Path(folder) / f"{path.stem}.yaml"
        mapping.write_text("\n".join(changed), encoding="utf-8")
        recording = replace(Recording.load(mapping), name=path.stem, file=str(path))
    name = path.stem[-4:]
    return Day(name, CLIMATE_OF.get(name, OTHER), recording)


def for_fit(day: Day, spacing: float = THINNED) -> Recording:
    """What a fit is given: displacement only where it is a reading, and a sample every so many seconds.

    Samples at which speed or feed changes stay, so that no switching moves, and so does the first minute.
    """
    clean = day.with_values(DISPLACEMENTS, np.where(day.counted, day.values(*DISPLACEMENTS), np.nan)).recording
    stretch = np.floor((clean.t - clean.t[0]) / spacing)
    switched = (np.diff(day.values("speed", "feed"), axis=0, prepend=np.nan) != 0).any(axis=1)
    kept = day.begins | switched | (np.diff(stretch, prepend=-1) != 0)
    columns = {name: replace(column, values=column.values[kept]) for name, column in clean.columns.items()}
    return replace(clean, t=clean.t[kept], columns=columns)
