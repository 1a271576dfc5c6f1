"""A few readings far from their neighbours: a plug touched, a word of the bus lost.

Hampel's filter: farther than 8 robust deviations from the median of nine, which normal noise reaches in 1e-15 of
readings. No thermal channel goes and comes back within four samples; where an input jumped, a fast one might.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from network.catalogue.declaration.declare import Array
from network.recordings.columns import Column
from network.recordings.hygiene.data_quality import WINDOW, look_at
from network.recordings.hygiene.jumps import is_driven
from network.recordings.hygiene.set_aside import SetAside

FEW = 0.03
"""Share of the readings: where more lie apart, they are no exception."""


def find_lone_readings(t: Array, column: Column, declared: float, inputs: Array) -> Iterator[SetAside]:
    """All of a channel as one; declared: 1σ of a sample."""
    rows = np.flatnonzero(look_at(column.name, column.values, declared).apart)
    if len(rows) > FEW * np.isfinite(column.values).sum():
        return
    rows = rows[~is_driven(inputs, rows, WINDOW // 2)]
    if not len(rows):
        return
    around = [np.nanmedian(column.values[max(k - WINDOW // 2, 0) : k + WINDOW // 2 + 1]) for k in rows]
    away = column.values[rows] - np.array(around)
    size = float(away[np.argmax(np.abs(away))])
    why = "has readings far from their neighbours, up to" if len(rows) > 1 else "has a reading far from its neighbours,"
    yield SetAside.of(t, column, rows, why, size)
