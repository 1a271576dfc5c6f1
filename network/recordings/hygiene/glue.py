"""Two recordings glued together: most temperatures jump at one instant, and no input that could have made them does.

Each channel alone would be wrong in a share α/2 of recordings. However much channels depend on each other, at least
half of them are wrong at once in no more than a share α (Markov).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from network.catalogue.declaration.declare import Array, Mask
from network.platform.quantities.units import unit
from network.recordings.columns import Column
from network.recordings.hygiene.jumps import chance_of_steps
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
    at_once = jumps.mean(axis=0) > MOST
    inputs = held_inputs(several, len(t))
    rows = [k for k in np.flatnonzero(at_once).tolist() if not _may_be_driven(inputs, at_once, k)]
    return [(k, [c.name for c, at in zip(temperatures, jumps[:, k], strict=True) if at]) for k in rows]


def _may_be_driven(inputs: Array, at_once: Mask, k: int) -> bool:
    """Whether an input jumps there that never jumped by half as much elsewhere and left the temperatures alone."""
    for values in inputs:
        steps = np.abs(np.nan_to_num(np.diff(values, prepend=values[:1])))
        own = steps[max(k - AT_ONCE, 0) : k + AT_ONCE + 1].max()
        alike = (steps >= own / 2) & ~at_once
        alike[max(k - AT_ONCE, 0) : k + AT_ONCE + 1] = False
        if own > 0 and not alike.any():
            return True
    return False


def held_inputs(columns: Iterable[Column], count: int) -> Array:
    """What is held between samples (speeds, feeds, switches, levels), channels × samples; displacement is measured."""
    held = [c.values for c in columns if not is_slow(unit(c.unit)) and unit(c.unit).dimension != unit("um").dimension]
    return np.array(held, float).reshape(-1, count)
