"""Recordings that are given twice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from network.platform.refusal import Complaints, Spot
from network.recordings.recording import Recording


def is_same(a: Recording, b: Recording) -> bool:
    """One file, or all the same columns; a mapping that cuts another piece out of one file is another recording."""
    if len(a.t) != len(b.t) or not np.array_equal(a.t, b.t) or a.columns.keys() != b.columns.keys():
        return False
    return all(np.array_equal(c.values, b.columns[n].values, equal_nan=True) for n, c in a.columns.items())


def check_once(recordings: Sequence[Recording], complaints: Complaints) -> None:
    """Refuses what is given twice."""
    for i, one in enumerate(recordings):
        if any(is_same(one, other) for other in recordings[:i]):
            complaints.refuse(Spot(one.file), "is given twice, and would count twice", "give it once")
