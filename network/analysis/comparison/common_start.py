"""One rule for where the runs of a call begin, and what their first readings say against a start that was stated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from network.engine.assembly import build
from network.engine.simulation import schedule_for
from network.engine.start import begins_cold, first_readings, start_temperatures
from network.machine.machine import Machine
from network.platform.quantities.text_table import digits
from network.recordings.inputs import Start
from network.recordings.recording import Recording

START, TOLD = 0.3, 3.0
"""K: 1σ of where a part begins that a reading, a cold machine or a mapping tells, and how many of them are told."""


def share_start_rule(machine: Machine, recordings: Iterable[Recording], start: Start | None = None) -> list[Recording]:
    """The recordings, all of which begin at their first readings if some do and others would begin at the reference, or
    if those did that the machine was calibrated on."""
    several = list(recordings)
    network = build(machine)
    silent = [r for r in several if start is None and r.start is None]
    cold = {id(r): begins_cold(network, r) for r in silent}
    is_known = machine.calibrated is not None and machine.calibrated.starts_read
    if len(set(cold.values())) < 2 and not is_known:
        return several
    return [replace(r, start=Start(read=True)) if id(r) in cold else r for r in several]


def share_starts(
    machine: Machine, train: Sequence[Recording], held_out: Sequence[Recording], start: Start | None
) -> tuple[list[Recording], list[Recording]]:
    """The same of recordings learned from and held out."""
    runs = share_start_rule(machine, (*train, *held_out), start)
    return runs[: len(train)], runs[len(train) :]


def doubt_starts(machine: Machine, recordings: Sequence[Recording], start: Start | None = None) -> Iterator[str]:
    """Sentences on channels that begin elsewhere than the start that is stated."""
    network = build(machine)
    for recording in recordings:
        stated = start or recording.start
        if stated is None or stated.read:
            continue
        T0 = start_temperatures(network, schedule_for(machine, recording, start), recording)
        for name, reading in first_readings(network, recording).items():
            there = float(network.row(reading.place) @ T0)
            off = min(abs(reading.begins - there), abs(reading.first - there))  # some move much within the minute
            if off > TOLD * (START**2 + reading.std**2) ** 0.5:
                first, begins = digits(reading.begins, 4), digits(there, 4)
                yield f"{recording.file}: {name} is stated to begin at {begins} degC, and reads {first} degC first"
