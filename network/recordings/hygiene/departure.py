"""A temperature that leaves its peers from one sample to the next, for good: an offset, a loose contact, or a unit that
changed on the way. It jumps as its own steps do not explain, no other channel does, and no input did. What comes back
is left to the diagnosis, unless another unit explains it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from network.catalogue.declaration.declare import Array
from network.recordings.columns import Column
from network.recordings.hygiene.jumps import SPARED, chance_of_steps, is_driven
from network.recordings.hygiene.set_aside import SetAside
from network.recordings.time_order import FALSE_ALARM

PEERS = 2
"""Other temperatures that a recording has to have."""
WINDOW = 9
"""Samples on either side whose medians tell whether a jump stays; it is no lone reading then."""
STAYS = 0.5
"""Share of a jump that has to be left."""
TOGETHER = 0.01
"""Chance of as many large steps of other channels at one instant, below which something happened to the machine."""
UNITS = (("degF", 1.8, 32.0), ("K", 1.0, 273.15))
CLOSE = 0.05
"""Of a jump: how near it has to be to that of another unit."""


def find_departures(t: Array, columns: Mapping[str, Column], inputs: Array) -> Iterator[SetAside]:
    """Each with the stretch up to a jump back, or up to the end."""
    if len(columns) <= PEERS:
        return
    chance = {name: chance_of_steps(t, column.values) for name, column in columns.items()}
    for name, column in columns.items():
        own, values = chance[name], column.values
        others = np.array([chance[other] for other in columns if other != name])
        rows = np.flatnonzero(own < FALSE_ALARM).tolist()
        kept = [k for k in rows if own[k] < FALSE_ALARM / len(columns) and _stays(values, k)]
        kept = [k for k in kept if _unit_of(values, k) or not _happened(values, own, others, inputs, k)]
        yield from _stretches(t, column, kept, rows)


def _happened(values: Array, chance: Array, others: Array, inputs: Array, k: int) -> bool:
    """Whether something happened to the machine at that instant: an input jumped, others moved, or it moves on."""
    is_input = bool(is_driven(inputs, np.array([k]), WINDOW // 2)[0])
    return is_input or _moves_on(values, chance, k) or _is_shared(others, k)


def _moves_on(values: Array, chance: Array, k: int) -> bool:
    """Whether the next step goes the same way and is one of the largest, too: a body that relaxes, and no jump."""
    if k + 1 >= len(values) or chance[k + 1] >= SPARED + 1:
        return False
    return bool((values[k + 1] - values[k]) * (values[k] - values[k - 1]) > 0)


def _is_shared(others: Array, k: int) -> bool:
    """Whether more other channels have one of their largest steps at that instant than chance would bring there: a
    Poisson number reaches n with the probability P(n, mean), the incomplete gamma function."""
    from scipy.special import gammainc

    steps = np.isfinite(others).sum()
    largest = others < SPARED + 1
    return bool(gammainc(largest[:, k].sum(), len(others) * largest.sum() / max(steps, 1)) < TOGETHER)


def _jump(values: Array, k: int) -> float:
    """The median of the readings from k on less that of those before it."""
    before, after = values[max(k - WINDOW, 0) : k], values[k : k + WINDOW]
    return float(np.nanmedian(after) - np.nanmedian(before))


def _stays(values: Array, k: int) -> bool:
    before, after = values[max(k - WINDOW, 0) : k], values[k : k + WINDOW]
    if np.isfinite(before).sum() < 2 or np.isfinite(after).sum() < WINDOW // 2 + 1:
        return False
    last = before[np.isfinite(before)][-1]
    step = float(values[k] - last)
    return bool(_jump(values, k) * np.sign(step) >= STAYS * abs(step))


def _stretches(t: Array, column: Column, away: list[int], jumps: list[int]) -> Iterator[SetAside]:
    """From a jump away to the end; where one of the jumps leads back, only what another unit explains."""
    values, done = column.values, 0
    for k in away:
        size, why = _jump(values, k), _unit_of(values, k)
        end = next((j for j in jumps if j > k and _jump(values, j) * np.sign(size) < -STAYS * abs(size)), len(t))
        if k < done:
            continue
        done = end + 1
        if end < len(t) and not why:
            continue
        rows = k + np.flatnonzero(np.isfinite(values[k:end]))
        why = why or "leaves the other temperatures at once, for good,"
        yield SetAside.of(t, column, rows, why, size)


def _unit_of(values: Array, k: int) -> str:
    before, size = float(np.nanmedian(values[max(k - WINDOW, 0) : k])), _jump(values, k)
    for text, factor, offset in UNITS:
        if abs(before * factor + offset - before - size) < CLOSE * abs(size):
            return f"reads as if it were told in {text} from then on, and jumps"
    return ""
