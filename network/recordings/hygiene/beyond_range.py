"""Readings that no sensor gives: farther from the others than a million of its noise.

A 16 bit converter tells 65536 steps apart and its noise is about one of them; what lies twenty times beyond is an
overflow, a lost exponent, or the course of a simulation that ran away. A wire that came off reads the end of the scale,
which is nearer and looked for elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.catalogue.declaration.declare import Array
from network.recordings.columns import Column
from network.recordings.hygiene.set_aside import SetAside

FARTHEST = 1e6
"""1σ of a sample from the median of the first readings."""
FIRST = 9
"""Readings of which the median is what the others are compared with: the rest may be what ran away."""


def find_beyond_range(t: Array, column: Column, declared: float) -> Iterator[SetAside]:
    """All of a channel as one; declared: 1σ of a sample."""
    known = column.values[np.isfinite(column.values)]
    if not len(known) or declared <= 0:
        return
    away = column.values - np.median(known[:FIRST])
    rows = np.flatnonzero(np.abs(away) > FARTHEST * declared)
    if len(rows):
        yield SetAside.of(t, column, rows, "has readings beyond what any sensor gives")
