"""Two recordings glued together: most temperatures jump at one instant, and no input does.

Each channel alone would be wrong in a share α/2 of recordings. However much channels depend on each other, at least
half of them are wrong at once in no more than a share α (Markov).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.units import unit
from network.recordings.columns import Column
from network.recordings.hygiene.jumps import chance_of_steps, is_driven
from network.recordings.inputs import is_slow
from network.recordings.time_order import FALSE_ALARM

FEWEST, MOST = 3, 0.5
"""Temperatures that a recording has to have, and the share of them that has to jump."""
AT_ONCE = 1
"""Samples about the instant in which an input may be what made them jump."""


def find_glued(t: Array, columns: Iterable[Column]) -> list[tuple[int, list[str]]]:
    """Samples with which another recording begins, and the channels that jump there."""
    several = list(columns)
    temperatures = [c for c in several if unit(c.unit).is_temperature and np.isfinite(c.values).any()]
    if len(temperatures) < FEWEST:
        return []
    chance = np.array([chance_of_steps(t, c.values) for c in temperatures])
    jumps = chance < FALSE_ALARM / 2
    inputs = held_inputs(several, len(t))
    rows = np.flatnonzero(jumps.mean(axis=0) > MOST)
    free = rows[~is_driven(inputs, rows, AT_ONCE)]
    return [(int(k), [c.name for c, at in zip(temperatures, jumps[:, k], strict=True) if at]) for k in free]


def held_inputs(columns: Iterable[Column], count: int) -> Array:
    """What is held between samples (speeds, feeds, switches, levels), channels × samples; displacement is measured."""
    held = [c.values for c in columns if not is_slow(unit(c.unit)) and unit(c.unit).dimension != unit("um").dimension]
    return np.array(held, float).reshape(-1, count)
