"""A channel that stands still as no working sensor does.

At most REPEATS of the readings repeat the one before elsewhere in the channel, so that STUCK in a row that do are met
by chance in n 2⁻⁶⁰ of recordings of n samples.
"""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array, Mask

STUCK, STUCK_SHARE, REPEATS = 60, 0.1, 0.5
"""Equal readings in a row (and share of all) that mean a hanging sensor, where fewer than REPEATS repeat elsewhere."""


def hanging(values: Array) -> Mask:
    """Where a channel stands still as no working sensor does: always, or long in a row while it else rarely repeats."""
    finite = np.flatnonzero(np.isfinite(values))
    out = np.zeros(len(values), bool)
    if len(finite) < 2:
        return out
    same = np.diff(values[finite]) == 0
    if same.all():
        out[finite] = len(finite) >= STUCK
        return out
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(int), [0]])))
    for first, last in edges.reshape(-1, 2):
        count = last - first + 1
        elsewhere = np.concatenate([same[:first], same[last:]])
        if count >= max(STUCK, STUCK_SHARE * len(finite)) and len(elsewhere) and elsewhere.mean() < REPEATS:
            out[finite[first + 1 : last + 1]] = True
    return out
