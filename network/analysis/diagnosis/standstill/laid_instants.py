"""A recording with instants laid between its samples, so that an input may jump there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.machine.machine import Machine
from network.recordings.columns import Column
from network.recordings.recording import Recording

CLOSE = 1.0
"""s: a sample so near to an edge stands for it; a further one so long before it says that nothing jumped until then."""


def lay_instants(machine: Machine, recording: Recording, edges: Iterable[float]) -> Recording:
    """A recording with samples at some instants and just before them, where there are none near: inputs as they are
    held or run there, and no readings."""
    new = np.array([t for edge in edges for t in _list_new(recording.t, edge)])
    if not len(new):
        return recording
    t, index = np.unique(np.concatenate([recording.t, new]), return_index=True)
    columns = {n: _lay_column(machine, recording, c, new, index) for n, c in recording.columns.items()}
    lines = None if recording.lines is None else recording.lines[np.searchsorted(recording.t, t, side="right") - 1]
    return replace(recording, t=t, columns=columns, lines=lines)


def _list_new(t: Array, edge: float) -> Iterator[float]:
    """The two instants of an edge within the recording; none where a sample is near."""
    if t[0] < edge - CLOSE and edge < t[-1] and np.abs(t - edge).min() >= CLOSE:
        yield from (edge - CLOSE, edge)


def _lay_column(machine: Machine, recording: Recording, column: Column, new: Array, index: Indices) -> Column:
    """One column with its values at further instants; index: of the samples in time, among the old and the new."""
    if column.name in machine.sensors or not np.isfinite(column.values).all():
        between = np.full(len(new), np.nan)
    else:
        between = recording.signal(column.name, is_switch=column.name in machine.switches).at(new)
    return replace(column, values=np.concatenate([column.values, between])[index])
