"""A temperature told in another unit than its header says, all through: it starts where its peers do once it is read in
that unit, stays among them throughout, and lies beyond all of them as it stands.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.machine.machine import Machine
from network.platform.quantities.units import unit
from network.recordings.hygiene.set_aside import SetAside
from network.recordings.recording import Recording
from network.recordings.recording_checks import misread_units, temperatures


def find_wrong_units(machine: Machine, recording: Recording) -> Iterator[SetAside]:
    """One for each channel that is surely so; what is only doubtful is told by `doubtful_units`."""
    every = temperatures(machine, recording)
    for name, text, above in misread_units(machine, recording):
        others = np.array([c.values for n, c in every.items() if n != name])
        values, read = every[name].values, every[name].values * unit(text).scale + unit(text).offset
        low, high = np.nanmin(others), np.nanmax(others)
        reach = high - low
        known = np.isfinite(values)
        among = ((read[known] > low - reach) & (read[known] < high + reach)).all()
        if among and not ((values[known] >= low) & (values[known] <= high)).any():
            rows = np.flatnonzero(known)
            why = f"reads as if it were told in {text}, above the other temperatures"
            yield SetAside.of(recording.t, every[name], rows, why, above)
