"""Recordings as courses in cells of even length: what lag models are fitted to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.comparison.resample import mean_in_cells
from network.catalogue.declaration.declare import Array
from network.recordings.hygiene.data_quality import look_at
from network.recordings.hygiene.frozen import hanging
from network.recordings.recording import Recording

CELLS, FEWEST_CELLS, MOST_CELLS = 6000, 150, 1000
"""Of all runs together, and of one: a cell is then no longer than the shortest lag that is looked for in it."""
INSIDE = 4
"""Instants of a cell at which an input is read."""


@dataclass(frozen=True, eq=False)
class Course:
    """One run. step: length of a cell [s]; values: by name, a mean over each cell [SI], NaN where nothing was read."""

    step: float
    values: Mapping[str, Array]

    @property
    def cells(self) -> int:
        return len(next(iter(self.values.values())))

    @property
    def length(self) -> float:
        """[s]"""
        return self.step * self.cells


def courses_of(runs: Sequence[Recording], inputs: Iterable[str], readings: Iterable[str]) -> tuple[Course, ...]:
    """Inputs and readings of every run. Raises Refused for an input with gaps that nobody said how to fill."""
    most = int(np.clip(CELLS // len(runs), FEWEST_CELLS, MOST_CELLS))
    inputs, readings = list(inputs), list(readings)
    return tuple(_course(run, inputs, readings, most) for run in runs)


def _course(run: Recording, inputs: Sequence[str], readings: Sequence[str], most: int) -> Course:
    length = float(run.t[-1] - run.t[0])
    typical = float(np.median(np.diff(run.t)))
    cells = max(min(most, round(length / typical) + 1), 2)
    step = length / (cells - 1)
    values = {name: _read_input(run, name, step, cells) for name in inputs}
    for name in readings:
        values[name] = _read_channel(run, name, step, cells)
    return Course(step, values)


def _read_input(run: Recording, name: str, step: float, cells: int) -> Array:
    instants = run.t[0] + step * (np.arange(cells * INSIDE) + 0.5) / INSIDE
    values: Array = run.signal(name).at(np.minimum(instants, run.t[-1]))
    return np.asarray(values.reshape(cells, INSIDE).mean(axis=1))


def _read_channel(run: Recording, name: str, step: float, cells: int) -> Array:
    if name not in run.columns:
        return np.full(cells, np.nan)
    index = np.floor((run.t - run.t[0]) / step + 1e-9).astype(int)
    return mean_in_cells(true_readings(run, name), index, cells)


def true_readings(run: Recording, name: str) -> Array:
    """A channel's readings with NaN for those that lie far from their neighbours or stand still as none does."""
    values = run.columns[name].values
    kept = look_at(name, values, 0.0).used & ~hanging(values)
    return np.asarray(np.where(kept, values, np.nan))
