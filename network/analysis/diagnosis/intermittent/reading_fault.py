"""A fault of one channel's readings that holds for some of the time; it is no part of the machine.

What it did to the readings is undone; about the instants at which it begins and ends readings are left out. It counts
where a fit to the readings so set right explains more than chance does.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.comparison.channel_residual import ChannelResidual
from network.analysis.diagnosis.hypothesis import Case, Hypothesis, fit_hypothesis
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.result import Quantity
from network.catalogue.declaration.declare import Array, Mask
from network.platform.refusal import Failed, Refused
from network.recordings.recording import Recording

EDGE = 100.0
"""s about a jump in which readings are left out."""
PER_WINDOW = 14.0
"""Nats that the instants of a window cost: ln of as many runs, channels, shapes and instants as are tried."""
LEFT = 0.5
"""Share of the excess χ² − 1 that the fault may leave."""


@dataclass(frozen=True, eq=False)
class ReadingFault(ABC):
    """recordings: as they were; gain: what it explains [nats]."""

    recordings: tuple[Recording, ...]
    gain: float

    @property
    @abstractmethod
    def kind(self) -> str:
        """What the catalogue calls it."""

    @property
    @abstractmethod
    def section(self) -> str:
        """Of the machine's file."""

    @property
    @abstractmethod
    def channel(self) -> str:
        """The channel that fails."""

    @property
    @abstractmethod
    def quantities(self) -> Mapping[str, Quantity]:
        """How large it is."""

    @property
    @abstractmethod
    def windows(self) -> tuple[Windows, ...]:
        """When it holds in each of the recordings."""

    @property
    @abstractmethod
    def told(self) -> str:
        """What is wrong, and when."""

    def list_left_out(self, windows: Windows) -> list[tuple[float, float]]:
        """Where it begins or ends, and readings are left out [s]."""
        return [(edge - EDGE, edge + EDGE) for window in windows for edge in window]

    @abstractmethod
    def undo(self, recording: Recording, values: Array, windows: Windows) -> Array:
        """The readings of its channel as they would be without it."""

    @abstractmethod
    def list_corrections(self, recording: Recording, channel: ChannelResidual) -> list[Recording]:
        """A recording of which only the residual is known, in all ways in which it may have to be set right."""

    def correct_windows(self, recording: Recording, windows: Windows, sets_right: bool = True) -> Recording:
        """A recording with the readings of the windows set right, and none about their ends."""
        column = recording.columns.get(self.channel)
        if column is None:
            return recording
        values = self.undo(recording, column.values, windows) if sets_right else column.values
        values = np.where(inside(recording.t, self.list_left_out(windows)), np.nan, values)
        return replace(recording, columns={**recording.columns, self.channel: replace(column, values=values)})


def inside(t: Array, windows: Iterable[tuple[float, float]]) -> Mask:
    """Which instants lie in some of the windows."""
    none = np.zeros(len(t), bool)
    return np.asarray(np.any([none, *((t >= begin) & (t < end) for begin, end in windows)], axis=0))


def fit_both(
    h: Hypothesis, fault: ReadingFault, begin: Hypothesis | None = None
) -> tuple[Hypothesis, Hypothesis, float] | None:
    """Fits to the readings as they were and set right, those around its jumps left out of both, and what the second
    explains more than chance does [nats]; None where what is set right is nothing that a machine could show. begin: a
    fit from whose numbers the second begins; default are those of the file, for those of a fit to readings that are not
    true are bent."""
    try:
        before = _fit(h, _with(h.case, fault, False), h.values)
        after = _fit(h, _with(h.case, fault, True), begin.values if begin else h.own_values)
    except (Failed, Refused, np.linalg.LinAlgError):
        return None
    return before, after, after.evidence - before.evidence - PER_WINDOW * sum(map(len, fault.windows))


def _fit(h: Hypothesis, case: Case, begin: Mapping[str, float]) -> Hypothesis:
    return fit_hypothesis(case, h.machine, h.found, h.own, begin)


def is_mended(before: Hypothesis, after: Hypothesis) -> bool:
    """Whether hardly anything is left of the excess."""
    return after.chi**2 - 1 <= LEFT * (before.chi**2 - 1)


def _with(case: Case, fault: ReadingFault, sets_right: bool) -> Case:
    runs = zip(case.recordings, fault.windows, strict=True)
    return replace(case, recordings=tuple(fault.correct_windows(r, windows, sets_right) for r, windows in runs))
