"""The readings of a recording that count: those of a sensor with `while` only as long as its input is not zero."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array, Mask
from network.machine.machine import Machine
from network.recordings.columns import Column
from network.recordings.recording import Recording


def drop_uncounted(machine: Machine, recording: Recording) -> Recording:
    """The recording with gaps where a sensor of this machine reads while its input is zero; itself where there are
    none. A switch that lacks here is left to those who ask for the machine's inputs. Raises Refused where one has gaps
    and nobody said how to fill them."""
    columns = dict(recording.columns)
    for name, sensor in machine.sensors.items():
        if sensor.gate is not None and name in columns and sensor.gate in {*recording.columns, *recording.constants}:
            columns[name] = _drop(columns[name], is_on(recording, sensor.gate))
    same = all(columns[name] is column for name, column in recording.columns.items())
    return recording if same else replace(recording, columns=columns)


def is_on(recording: Recording, switch: str) -> Mask:
    """At which samples an input is not zero; at one at which it switches, what it is from then on."""
    values: Array = recording.signal(switch, is_switch=True).at(recording.t)
    return np.asarray(values != 0)


def _drop(column: Column, counts: Mask) -> Column:
    if not np.isfinite(column.values[~counts]).any():
        return column
    return replace(column, values=np.where(counts, column.values, np.nan))
