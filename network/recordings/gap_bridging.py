"""Whether the inputs of a run can be drawn through a gap: as they were held before and after, and nothing else moved.

Under inputs that stay as they are every temperature relaxes, and its mean rate over the gap lies between its rates
before and after it (true of any sum of decaying exponentials of one sign). What changed by less or more than that,
beyond the uncertainty of the two rates, saw inputs that are not recorded.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.quantities.units import unit
from network.recordings.columns import Column
from network.recordings.inputs import is_slow
from network.recordings.time_order import FALSE_ALARM

STEADY = 1e-6
"""Of the largest value: as near as a held input is the same."""


def hinders(t: Array, columns: Iterable[Column], index: int, begin: int) -> str:
    """Why the run that began with sample `begin` cannot be drawn through the gap before `index`; '' where it can."""
    from scipy.special import ndtri  # slow to load, and few runs have gaps

    several = list(columns)
    gap = float(t[index] - t[index - 1])
    shorter = min(float(t[index - 1] - t[begin]), float(t[-1] - t[index]))
    if gap > shorter:
        return "it is longer than what is recorded beside it"
    fast = [column for column in several if not is_slow(unit(column.unit))]
    changed = [column.name for column in fast if _differs(column.values, index)]
    if changed:
        return f"{', '.join(changed)} {'are' if len(changed) > 1 else 'is'} another after it"
    slow = [column for column in several if is_slow(unit(column.unit))]
    level = -float(ndtri(FALSE_ALARM / 2 / max(len(slow), 1)))
    odd = [column.name for column in slow if _strays(t, column.values, index, begin, level)]
    return f"{', '.join(odd)} moved in it as under other inputs" if odd else ""


def _differs(values: Array, index: int) -> bool:
    """Whether a held quantity is another after the gap, beyond the scatter it has on either side."""
    before, after = (part[np.isfinite(part)] for part in (values[:index][-LOOKED:], values[index:][:LOOKED]))
    if not len(before) or not len(after):
        return False
    low, high = max(before.min(), after.min()), min(before.max(), after.max())
    return bool(low - high > STEADY * max(np.abs(before).max(), np.abs(after).max()))


LOOKED = 5
"""Samples on either side whose range is the scatter of a held quantity."""


def _strays(t: Array, values: Array, index: int, begin: int, level: float) -> bool:
    gap = float(t[index] - t[index - 1])
    before = _line(t[begin:index], values[begin:index], t[index - 1], gap)
    after = _line(t[index:], values[index:], t[index], gap)
    if before is None or after is None:
        return False
    (y0, rate0, var0), (y1, rate1, var1) = before, after
    spread = level * np.sqrt(var0 + var1)
    low, high = sorted((rate0 * gap, rate1 * gap))
    return not low - spread <= y1 - y0 <= high + spread


def _line(t: Array, values: Array, at: float, gap: float) -> tuple[float, float, float] | None:
    """A straight line through what lies within the length of the gap: value at its edge, rate, variance of the change
    over the gap that it foretells. None where fewer than four samples lie there."""
    near = (np.abs(t - at) <= gap) & np.isfinite(values)
    if near.sum() < 4:
        return None
    A = np.stack([np.ones(near.sum()), t[near] - at], axis=1)
    fit, *_ = np.linalg.lstsq(A, values[near], rcond=None)
    left = values[near] - A @ fit
    variance = float(left @ left) / (len(left) - 2)
    foretold = np.array([1.0, gap])
    return float(fit[0]), float(fit[1]), variance * float(foretold @ np.linalg.inv(A.T @ A) @ foretold)
