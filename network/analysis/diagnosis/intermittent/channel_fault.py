"""A fault of one channel's readings that holds for some of the time; it is no part of the machine.

What it did to the readings is undone; about the instants at which it begins and ends readings are left out. It counts
where a fit to the readings so set right explains more than chance does.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.gauss_newton import STEPS
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.reading_fault import ReadingFault
from network.catalogue.declaration.declare import Array, Mask
from network.platform.refusal import Failed, Refused
from network.recordings.recording import Recording

EDGE = 100.0
"""s about a jump in which readings are left out."""
PER_WINDOW = 14.0
"""Nats that the instants of a window cost: ln of as many runs, channels, shapes and instants as are tried."""
FAULTY = 0.98
"""Confidence in a fault whose jumps are of one share, there and back."""
BRIEF = 2
"""Steps of a fit that begins where it was fitted to all but the same readings."""
LEFT = 0.5
"""Share of the excess χ² − 1 that the fault may leave."""


@dataclass(frozen=True, eq=False)
class ChannelFault(ReadingFault):
    """A fault of one channel."""

    confidence = FAULTY

    @property
    @abstractmethod
    def channel(self) -> str:
        """The channel that fails."""

    @property
    def channels(self) -> tuple[str, ...]:
        return (self.channel,)

    def set_right(self, case: Case) -> Case:
        return self.correct(case)

    def lay_alike(self, case: Case) -> Case:
        return self.correct(case, sets_right=False)

    def list_left_out(self, windows: Windows) -> list[tuple[float, float]]:
        """Where it begins or ends, and readings are left out [s]."""
        return [(edge - EDGE, edge + EDGE) for window in windows for edge in window]

    @abstractmethod
    def undo(self, recording: Recording, values: Array, windows: Windows) -> Array:
        """The readings of its channel as they would be without it."""

    def correct(self, case: Case, sets_right: bool = True) -> Case:
        """The case with the readings of the windows set right or left as they are, and none about their ends."""
        runs = zip(case.recordings, self.windows, strict=True)
        return replace(case, recordings=tuple(self.correct_windows(r, w, sets_right) for r, w in runs))

    def correct_windows(self, recording: Recording, windows: Windows, sets_right: bool = True) -> Recording:
        """A recording with the readings of the windows set right, and none about their ends. What is set right has as
        much more noise as it moves with a reading."""
        column = recording.columns.get(self.channel)
        if column is None:
            return recording
        values = self.undo(recording, column.values, windows) if sets_right else column.values
        spread = self.undo(recording, column.values + 1.0, windows) - values if sets_right else None
        values = np.where(inside(recording.t, self.list_left_out(windows)), np.nan, values)
        right = replace(column, values=values, spread=spread)
        return replace(recording, columns={**recording.columns, self.channel: right})


def inside(t: Array, windows: Iterable[tuple[float, float]]) -> Mask:
    """Which instants lie in some of the windows."""
    none = np.zeros(len(t), bool)
    return np.asarray(np.any([none, *((t >= begin) & (t < end) for begin, end in windows)], axis=0))


def fit_both(
    h: Hypothesis, fault: ChannelFault, begin: Hypothesis | None = None
) -> tuple[Hypothesis, Hypothesis, float] | None:
    """Fits to the readings as they were and set right, those around its jumps left out of both, and what the second
    explains more than chance does [nats]; None where what is set right is nothing that a machine could show. begin: a
    fit from whose numbers the second begins; default are those of the file, for those of a fit to readings that are not
    true are bent, and where that comes to less than these do – relays fall out of step – theirs."""
    try:
        before = _fit(h, fault.correct(h.case, False), h.values, BRIEF)
        after = _fit(h, right := fault.correct(h.case), begin.values if begin else h.own_values)
        if after.evidence < before.evidence:
            after = max(after, _fit(h, right, before.values), key=lambda fit: fit.evidence)
    except (Failed, Refused, np.linalg.LinAlgError):
        return None
    return before, after, after.evidence - before.evidence - PER_WINDOW * sum(map(len, fault.windows))


def _fit(h: Hypothesis, case: Case, begin: Mapping[str, float], steps: int = STEPS) -> Hypothesis:
    return fit_hypothesis(case, h.machine, h.found, h.own, begin, steps=steps)


def is_mended(before: Hypothesis, after: Hypothesis) -> bool:
    """Whether most of the excess is gone."""
    return after.chi**2 - 1 <= LEFT * (before.chi**2 - 1)
