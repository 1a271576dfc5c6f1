"""A run without readings that cannot be true: what was set aside stands with it, and counts in no figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.machine.machine import Machine
from network.platform.quantities.units import unit
from network.recordings.columns import Column
from network.recordings.hygiene.beyond_range import find_beyond_range
from network.recordings.hygiene.departure import find_departures
from network.recordings.hygiene.frozen import hanging
from network.recordings.hygiene.glue import held_inputs
from network.recordings.hygiene.lone_readings import find_lone_readings
from network.recordings.hygiene.scatter import find_scatter
from network.recordings.hygiene.set_aside import ALWAYS, SetAside
from network.recordings.hygiene.wrong_unit import find_wrong_units
from network.recordings.recording import Recording
from network.recordings.recording_checks import temperatures


def judge(machine: Machine, recording: Recording, *, keeps_departures: bool = False) -> Recording:
    """The recording with NaN for what is set aside of the machine's channels. keeps_departures: channels that leave
    their peers are only told, for a diagnosis names them by itself. Judged once: what was judged comes back as is."""
    if recording.excluded is not None:
        return recording
    names = [name for name, sensor in machine.sensors.items() if _is_read(recording.columns.get(name), sensor.unit)]
    inputs = held_inputs(recording.columns.values(), len(recording.t))
    found = list[SetAside]()
    for name in names:
        beyond = [*find_beyond_range(recording.t, recording.columns[name], machine.sensors[name].sigma)]
        recording = _without(recording, beyond)
        found += beyond
        for aside in _of_channel(machine, recording, recording.columns[name], inputs):
            found.append(aside)
            recording = _without(recording, [aside])
    found += _of_peers(machine, recording, inputs, keeps_departures)
    return replace(_without(recording, found), excluded=tuple(found))


def _is_read(column: Column | None, by: str) -> bool:
    """Whether there is a column that a sensor with a unit could have written."""
    return column is not None and unit(column.unit).dimension == unit(by).dimension


def _of_channel(machine: Machine, recording: Recording, column: Column, inputs: Array) -> Iterator[SetAside]:
    rows = np.flatnonzero(hanging(column.values))
    if len(rows):
        always = len(rows) == np.isfinite(column.values).sum()
        yield SetAside.of(recording.t, column, rows, ALWAYS if always else "is stuck")
        return
    yield from find_lone_readings(recording.t, column, machine.sensors[column.name].sigma, inputs)


def _of_peers(machine: Machine, recording: Recording, inputs: Array, keeps_departures: bool) -> Iterator[SetAside]:
    every = temperatures(machine, recording)
    wrong = list(find_wrong_units(machine, recording))
    yield from wrong
    names = {aside.channel for aside in wrong}
    sensed = {n: c for n, c in every.items() if n not in names and np.isfinite(c.values).any()}
    for aside in find_departures(recording.t, sensed, inputs):
        if aside.channel in machine.sensors:
            yield replace(aside, is_told_only=keeps_departures)
    yield from (aside for aside in find_scatter(recording.t, sensed) if aside.channel in machine.sensors)


def _without(recording: Recording, found: Sequence[SetAside]) -> Recording:
    columns = dict(recording.columns)
    for aside in found:
        if not aside.is_told_only:
            values = columns[aside.channel].values.copy()
            values[aside.rows] = np.nan
            columns[aside.channel] = replace(columns[aside.channel], values=values)
    return replace(recording, columns=columns)
