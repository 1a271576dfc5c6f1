"""Knots: the instants at which a fit computes a run, dense after every jump of an input and sparse later.

After a jump the modes die out one by one, so what is left after a time s bends on a scale of s: knots whose distance
grows with the time since the last jump follow heats that bend with them. Samples are compared as means over cells of a
few knots, with the model's mean over just the same samples, so nothing is lost but what is faster than a cell.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.engine.response.intervals import first_from, interval_of
from network.recordings.inputs import Schedule, Signal, hold, linear

GROWTH = 0.2
"""Distance of knots over the time since the last jump."""
LONGEST = 120.0
"""s: the longest distance of knots."""
CELL_GROWTH, LONGEST_CELL = 0.5, 120.0
BUSY = 0.2
"""Share of its instants from which a held signal that changes there is noisy, or creeps."""
FAINT, FAINT_UNREAD = 0.01, 0.1
"""Share of its rms up to which such noise counts by its mean between knots, for beyond it a light part shows it; the
same of what the machine does not read: heat that goes with its square is 1 % off then."""
STEP = 8.0
"""σ of noise from which a change is a jump all the same: in 30 000 readings of noise alone there is one in one case of
2000."""
MEDIAN_CHANGE = 0.954
"""Median of |x₁ − x₂| of two readings of noise, in their σ."""
FEW_SAMPLES = 400
"""Samples up to which every one is a knot."""


@dataclass(frozen=True)
class Knots:
    """t: knots [s], from the first sample to the last; jumps: those at which a held input jumps; cell_ends: index of
    the knot that ends each cell."""

    t: Array
    jumps: Array
    cell_ends: Indices
    samples: Array

    @cached_property
    def cell_of(self) -> Indices:
        """The cell of each sample: from its beginning until before its end; a sample at a jump comes after it."""
        return interval_of(np.append(self.t[:1], self.t[self.cell_ends]), self.samples)

    @property
    def cells(self) -> int:
        return len(self.cell_ends)


def jumps_of(schedule: Schedule, unread: Container[str] = ()) -> Array:
    """Instants inside the run at which an input jumps; unread: inputs whose noise matters less."""
    times = [signal.t[1:][_jumps(signal, signal.name in unread)] for signal in schedule.signals.values()]
    inner = np.unique(np.concatenate([*times, np.empty(0)]))
    return np.asarray(inner[(inner > schedule.t[0]) & (inner < schedule.t[-1])])


def list_jumps(signal: Signal) -> tuple[Array, Array, Array]:
    """When a signal jumps [s], from where and to where."""
    at = _changes(signal)
    return signal.t[1:][at], signal.end[:-1][at], signal.start[1:][at]


def _jumps(signal: Signal, is_unread: bool) -> Mask:
    """At which of its own knots, after the first, a signal jumps, and is not only read with noise."""
    changes = _changes(signal)
    noise = _noise_of(signal, changes, FAINT_UNREAD if is_unread else FAINT)
    return np.asarray(changes & (np.abs(signal.start[1:] - signal.end[:-1]) > STEP * noise))


def _changes(signal: Signal) -> Mask:
    return np.asarray(np.abs(signal.start[1:] - signal.end[:-1]) > 1e-12 * (1 + np.abs(signal.start[1:])))


def _noise_of(signal: Signal, changes: Mask, faint: float) -> float:
    """1σ of what a held signal is read with, like the speed that a drive reports; 0 where it is set in steps, or varies
    by more than a share of its rms."""
    if not (signal.is_held and int(changes.sum()) > BUSY * len(changes)):
        return 0.0
    noise = float(np.median(np.abs(np.diff(signal.start)[changes]))) / MEDIAN_CHANGE
    return noise if noise <= faint * float(np.sqrt(np.mean(signal.start**2))) else 0.0


def make_knots(
    schedule: Schedule, growth: float = GROWTH, longest: float = LONGEST, unread: Container[str] = ()
) -> Knots:  # fmt: skip
    """The knots of a run; unread: inputs whose noise matters less."""
    samples = schedule.t
    jumps = jumps_of(schedule, unread)
    if len(samples) <= FEW_SAMPLES:
        t = np.unique(np.concatenate([samples, jumps]))
    else:
        shortest = float(np.median(np.diff(samples)))
        ends = [samples[0], *jumps, samples[-1]]
        pieces = [_spread(a, b, shortest, growth, longest) for a, b in pairwise(ends)]
        t = np.concatenate([*pieces, samples[-1:]])
    return Knots(t, jumps, _cells(t, jumps, samples), samples)


def _spread(a: float, b: float, shortest: float, growth: float, longest: float) -> Array:
    """Knots from a up to b (excluded) whose distance grows with the time since a."""
    distances, total = [], 0.0
    while total < b - a:
        step = min(max(shortest, growth * total), longest)
        distances.append(step)
        total += step
    if len(distances) > 1 and b - a - (total - distances[-1]) < distances[-1] / 2:
        distances.pop()
    edges = np.concatenate([[0.0], np.cumsum(distances)])
    return np.asarray(a + edges[:-1] * ((b - a) / edges[-1]))


def _cells(t: Array, jumps: Array, samples: Array) -> Indices:
    """Knots that end a cell: cells do not cross a jump, grow with the time since it, and hold at least a sample."""
    ends, begin, since = [], float(t[0]), float(t[0])
    jump = set(jumps.tolist())
    counts = first_from(samples, t)
    last_count = 0
    for k in range(1, len(t)):
        now = float(t[k])
        wide = now - begin >= min(max(CELL_GROWTH * (now - since) / 1.5, 0.0), LONGEST_CELL) - 1e-9
        if (wide or now in jump) and counts[k] > last_count:
            ends.append(k)
            begin, last_count = now, int(counts[k])
        if now in jump:
            since = now
    if ends and (ends[-1] == len(t) - 1 or counts[-1] == last_count):
        ends.pop()
    return np.array([*ends, len(t) - 1])


def on_knots(schedule: Schedule, knots: Knots, unread: Container[str] = ()) -> Schedule:
    """The schedule at its knots: inputs that run straight between many samples become straight lines between knots,
    by least squares, so that their own noise is averaged and not followed; held inputs are left with their jumps, and
    become their means between knots where they are noisy."""
    signals = {name: _smooth(signal, knots.t, name in unread) for name, signal in schedule.signals.items()}
    return Schedule(schedule.name, schedule.file, knots.t, signals, schedule.start)


def _smooth(signal: Signal, t: Array, is_unread: bool) -> Signal:
    inside = (signal.t > t[0]) & (signal.t < t[-1])
    if signal.is_held:
        kept = np.append(True, _jumps(signal, is_unread))
        if (kept[1:] != _changes(signal)).any():
            return hold(signal.name, signal.unit, t[:-1], _means_between(signal, t))
        return hold(signal.name, signal.unit, signal.t[kept], signal.start[kept])
    if inside.sum() <= len(t):
        return signal
    x = np.concatenate([t[:1], signal.t[inside], t[-1:]])
    return linear(signal.name, signal.unit, t, _hat_fit(t, x, signal.at(x)))


def _means_between(signal: Signal, t: Array) -> Array:
    """Of a held signal, between instants."""
    ends = np.append(signal.t, max(t[-1], signal.t[-1] + 1.0))
    total = np.append(0.0, np.cumsum(signal.start * np.diff(ends)))
    before = np.minimum(t - ends[0], 0.0) * signal.start[0]
    return np.asarray(np.diff(np.interp(t, ends, total) + before) / np.diff(t))


def _hat_fit(t: Array, x: Array, y: Array) -> Array:
    """Values at t of the broken line nearest to the points (x, y)."""
    from scipy.linalg import solveh_banded

    k = np.clip(np.searchsorted(t, x, side="right") - 1, 0, len(t) - 2)
    w = (x - t[k]) / (t[k + 1] - t[k])
    n = len(t)
    diagonal = 1.0 * np.bincount(k, (1 - w) ** 2, n) + np.bincount(k + 1, w**2, n)
    off_diagonal = 1.0 * np.bincount(k, w * (1 - w), n)
    right = np.bincount(k, (1 - w) * y, n) + np.bincount(k + 1, w * y, n)
    stiff = 1e-3 * float(np.median(diagonal))  # a knot without samples follows its neighbours
    diagonal[:-1] += stiff
    diagonal[1:] += stiff
    off_diagonal[:-1] -= stiff
    banded = np.vstack([np.concatenate([[0.0], off_diagonal[:-1]]), diagonal])
    return np.asarray(solveh_banded(banded, right))
