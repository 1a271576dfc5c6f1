"""A recording in which two channels stand under each other's names."""

from __future__ import annotations

from dataclasses import replace

from network.recordings.recording import Recording

Pair = tuple[str, str]


def exchange_columns(recording: Recording, pair: Pair) -> Recording:
    """The readings of two channels exchanged; the recording as it is where it lacks one."""
    a, b = pair
    if not {a, b} <= {*recording.columns}:
        return recording
    one, other = recording.columns[a], recording.columns[b]
    swapped = {a: replace(one, values=other.values), b: replace(other, values=one.values)}
    return replace(recording, columns={**recording.columns, **swapped})
