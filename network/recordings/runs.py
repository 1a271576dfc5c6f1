"""Recordings as the runs that a machine is laid beside: parted where they are to be, each with a start of its own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from network.machine.machine import Machine
from network.recordings.call_arguments import as_several
from network.recordings.counted_readings import drop_uncounted
from network.recordings.hygiene.judgement import judge
from network.recordings.pieces import piece_column
from network.recordings.recording import Recording


def runs_of(
    machine: Machine, recordings: Recording | Iterable[Recording], *, keeps_departures: bool = False
) -> tuple[Recording, ...]:
    """The runs of one recording or of several, in their order, without readings that cannot be true (see judge)."""
    pieces = (piece for recording in as_several(recordings) for piece in _pieces(machine, recording))
    counted = (drop_uncounted(machine, piece) for piece in pieces)
    return tuple(judge(machine, piece, keeps_departures=keeps_departures) for piece in counted)


def _pieces(machine: Machine, recording: Recording) -> tuple[Recording, ...]:
    """What a probe was zeroed at lies behind a later piece's start, so a channel with `zero: start` begins at zero
    there, as the simulated one does."""
    first, *later = recording.pieces
    zeroed = [name for name, sensor in machine.sensors.items() if sensor.zero and name in recording.columns]
    return first, *(_zero(piece, zeroed) for piece in later)


def _zero(piece: Recording, names: Iterable[str]) -> Recording:
    columns = {**piece.columns, **{n: piece_column(piece.columns[n], slice(None), True) for n in names}}
    return replace(piece, columns=columns)


def tell_excluded(runs: Iterable[Recording]) -> list[str]:
    """A sentence on everything that was set aside."""
    return [aside.sentence(run.file) for run in runs for aside in run.excluded or ()]
