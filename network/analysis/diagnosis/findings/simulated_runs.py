"""Recordings told by a machine with some numbers, simulated: those that were fitted, and those held out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from network.analysis.calibration.estimated_constants import Numbers, compare_estimated
from network.analysis.calibration.null import Null
from network.analysis.comparison.compare import Comparison, RecordingResidual
from network.platform.parallel import run_all
from network.platform.printing import Brief
from network.platform.refusal import Failed, Refused
from network.recordings.inputs import Start
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedRuns(Brief):
    """known: how each recording is told, by its identity."""

    numbers: Numbers
    runs: Sequence[Recording]
    held: Sequence[Recording]
    known: Mapping[int, RecordingResidual]

    @property
    def train(self) -> Comparison:
        return self._compare(self.runs)

    @property
    def holdout(self) -> Comparison | None:
        return self._compare(self.held) if self.held else None

    def _compare(self, runs: Sequence[Recording]) -> Comparison:
        return Comparison(self.numbers.machine, tuple(self.known[id(run)] for run in runs))


def simulate_calibrated(
    calibrated: Null, start: Start | None, runs: Sequence[Recording], held: Sequence[Recording], jobs: int
) -> SimulatedRuns:
    """All runs with the numbers of the null. Raises Failed where one breaks down."""
    try:
        return simulate_runs(calibrated.numbers(start), runs, held, jobs)
    except (Failed, Refused, np.linalg.LinAlgError) as broken:
        raise Failed(f"as calibrated a run breaks down: {broken}") from broken


def simulate_runs(
    numbers: Numbers, runs: Sequence[Recording], held: Sequence[Recording], jobs: int,
    before: SimulatedRuns | None = None,
) -> SimulatedRuns:  # fmt: skip
    """All runs, their constants estimated; before: what was simulated already, of which runs with these numbers are
    taken. Raises Failed where a run breaks down."""
    known = before.known if before is not None and before.numbers is numbers else {}
    items = {id(run): (out, run) for out, side in ((False, runs), (True, held)) for run in side if id(run) not in known}
    told = run_all(partial(_compare_run, numbers), [*items.values()], jobs)
    return SimulatedRuns(numbers, runs, held, {**known, **dict(zip(items, told, strict=True))})


def _compare_run(of: Numbers, item: tuple[bool, Recording]) -> RecordingResidual:
    """Residuals of a run, held out or not."""
    held_out, run = item
    return compare_estimated(of, run, held_out)
