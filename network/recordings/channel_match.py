"""Which channels a fit hears of, and a word on each that it does not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches

import numpy as np

from network.machine.machine import Machine
from network.recordings.recording import Recording
from network.recordings.recording_checks import doubtful_units


def overheard(machine: Machine, recordings: Sequence[Recording], holdout: Sequence[Recording]) -> list[str]:
    """Sentences on how recordings were parted, on columns that may be meant for a sensor, sensors without any reading,
    and units that may be wrong."""
    told = [remark for one in (*recordings, *holdout) for remark in one.remarks]
    told += [*_find_misnamed(machine, (*recordings, *holdout)), *_unread(machine, recordings, holdout)]
    return told + [sentence for one in (*recordings, *holdout) for sentence in doubtful_units(machine, one)]


def _find_misnamed(machine: Machine, recordings: Sequence[Recording]) -> Iterator[str]:
    """Columns that nothing reads, and whose names are like those of sensors that lack one; files alike together."""
    files: dict[str, list[str]] = {}
    for recording in recordings:
        meant = _guess_sensors(machine, recording)
        if meant:
            are = "are no sensors" if len(meant) > 1 else "is no sensor"
            question = f"did you mean {', '.join(dict.fromkeys(meant.values()))}?"
            told = f"{', '.join(meant)} {are} of this machine ({question})"
            files.setdefault(told, []).append(recording.file)
    yield from (f"{', '.join(names)}: {told}" for told, names in files.items())


def _guess_sensors(machine: Machine, recording: Recording) -> dict[str, str]:
    """The sensor that a column may be meant for."""
    known = {*machine.sensors, *machine.inputs}
    lacking = [name for name in machine.sensors if name not in recording.columns]
    near = {name: get_close_matches(name, lacking, n=1) for name in recording.columns if name not in known}
    return {name: found[0] for name, found in near.items() if found}


def _unread(machine: Machine, recordings: Sequence[Recording], holdout: Sequence[Recording]) -> Iterator[str]:
    read, held_out = _read(recordings), _read(holdout)
    there = {name for recording in recordings for name in recording.columns}
    silent = [name for name in machine.sensors if name not in read]
    for names, where in (
        ([n for n in silent if n in held_out], "read only in what is held out"),
        ([n for n in silent if n not in held_out and n in there], "without any reading in the recordings"),
        ([n for n in silent if n not in held_out and n not in there], "in no recording"),
    ):
        if names:
            several = len(names) > 1
            sensors = f"the sensors {', '.join(names)} are" if several else f"the sensor {names[0]} is"
            yield f"{sensors} {where} and {'were' if several else 'was'} not used"


def _read(recordings: Iterable[Recording]) -> set[str]:
    """Columns with a reading."""
    return {name for r in recordings for name, column in r.columns.items() if np.isfinite(column.values).any()}
