"""Times in which a channel is read otherwise, from its residual alone: it jumps when they begin and when they end.

A part cannot jump, a reading can. Of the residual in bins the step at k is the mean of the bins after it less that of
those before, less the median of such steps around it, so that a slow drift leaves nothing. A step towards what would be
read at full strength, then back by the same share, makes a window. Source: robust change points in scan statistics,
e.g. Glaz, Naus & Wallenstein, Scan Statistics (2001); unverified.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from network.catalogue.declaration.declare import Array, Mask
from network.recordings.hygiene.data_quality import NORMAL, quantum_of

BIN = 60.0
"""s."""
SIDE, AROUND = 2, 7
"""Bins on each side of a step, and of steps around it whose median is drift."""
CLEAR = 8.0
"""Robust deviations of such steps from which one is a jump."""
ALIKE, MOST_OTHERS = 0.25, 0.35
"""How far jumps may differ in their share, and the part of all jumps that may be others."""
FEWEST, PAIR = 4, 2
"""Jumps, of all runs together; of those that no other channel shares, there and back once."""
SHARES = (0.02, 0.95)
"""Least and largest share that is told."""

COST, MOST, BLURRED = 8.0, 40.0, 0.1
"""Nats that a switch costs in looking for windows, what a step may cost without one at most, and how far a jump's size
may be off."""

Windows = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class LooseContact:
    """share: of full strength, and its 1σ; windows: of each run [s]."""

    share: float
    std: float
    windows: tuple[Windows, ...]


@dataclass(frozen=True, eq=False)
class Steps:
    """Steps of one run's residual at the middles t [s] of its bins; full: what full strength would change there;
    scatter: their robust 1σ; end: of the run [s]; driven: when inputs may make it jump [s]."""

    t: Array
    size: Array
    full: Array
    scatter: float
    end: float
    driven: tuple[float, ...] = ()

    @property
    def shares(self) -> Array:
        """Of the clear jumps, in shares of full strength; not of those that an input may make."""
        peak = self._peaks & (np.abs(self.full) > 0)
        for t in self.driven:
            peak &= np.abs(self.t - t) > self.reach
        return np.asarray(self.size[peak] / self.full[peak])

    @property
    def reach(self) -> float:
        """What a step spans on each side [s]."""
        return SIDE * max(BIN, float(np.median(np.diff(self.t))))

    @property
    def clear(self) -> list[float]:
        """When the clear jumps are [s], the largest first."""
        at = np.flatnonzero(self._peaks)
        return [float(self.t[k]) for k in at[np.argsort(-np.abs(self.size[at]))]]

    def covers(self, t: float, reach: float) -> bool:
        """Whether a jump within reach of that time would show: not where readings are missing."""
        return bool((np.abs(self.t - t) < reach).any())

    @property
    def _peaks(self) -> Mask:
        size = np.abs(self.size)
        near = sliding_window_view(np.pad(size, SIDE), 2 * SIDE + 1).max(axis=1)
        return np.asarray((size > CLEAR * self.scatter) & (size == near))

    def windows(self, share: float) -> Windows:
        """The windows of a share that explain the steps best (Viterbi's algorithm over the two states)."""
        there, back = self._worth(share * self.full), self._worth(-share * self.full)
        best, came = np.array([0.0, -COST]), np.zeros((len(there), 2), bool)
        for k in range(len(there)):
            moved = np.array([best[1] + back[k], best[0] + there[k]])
            came[k] = moved > best
            best = np.maximum(best, moved)
        return self._trace(came, int(best.argmax()))

    def _worth(self, jump: Array) -> Array:
        """Nats by which every step is more likely with a jump than without, where others may happen too."""
        without = np.minimum(self.size**2 / (2 * self.scatter**2), MOST)
        scatter2 = self.scatter**2 + (BLURRED * jump) ** 2
        return np.asarray(without - np.minimum((self.size - jump) ** 2 / (2 * scatter2), 2 * MOST) - COST)

    def _trace(self, came: Mask, state: int) -> Windows:
        """Windows from the switches on the best path, from its end on."""
        windows, end = list[tuple[float, float]](), self.end
        for k in range(len(came) - 1, -1, -1):
            if came[k, state]:
                if state:
                    windows.append((float(self.t[k]), end))
                end, state = float(self.t[k]), 1 - state
        if state:
            windows.append((0.0, end))
        return tuple(reversed(windows))


def find_steps(t: Array, residual: Array, change: Array, digit: float = 0.0) -> Steps | None:
    """Steps of a residual with gaps (NaN), a slow drift taken out; change: what full strength would add to the reading
    if it were true, of the two sides of a step the one where that is more: a reading that fails is nearer to what it
    fails to; digit: by which readings go at least, so that no step of one is a jump. None for runs that are too
    short."""
    middles, r = _average_bins(t, residual)
    width = 2 * SIDE + 1
    if len(r) < width + 2 * AROUND:
        return None
    inner = sliding_window_view(r, width)
    step = inner[:, SIDE + 1 :].mean(axis=1) - inner[:, :SIDE].mean(axis=1)
    drift = np.median(sliding_window_view(np.pad(step, AROUND, "edge"), 2 * AROUND + 1), axis=1)
    scatter = float(np.median(np.abs(step - drift))) / NORMAL
    at = middles[SIDE:-SIDE]
    _, full = _average_bins(t, np.where(np.isfinite(residual), change, np.nan))
    return Steps(at, step - drift, _list_farther(full), max(scatter, digit / CLEAR, 1e-12), float(t[-1]))


def digit_of(values: Array) -> float:
    """By which readings with gaps go at least; 0 where they do not show it."""
    return quantum_of(values[np.isfinite(values)])


def _list_farther(bins: Array) -> Array:
    """Of the means of bins before and after each step, the one farther from nothing."""
    inner = sliding_window_view(bins, 2 * SIDE + 1)
    before, after = inner[:, :SIDE].mean(axis=1), inner[:, SIDE + 1 :].mean(axis=1)
    return np.asarray(np.where(np.abs(before) > np.abs(after), before, after))


def _average_bins(t: Array, values: Array) -> tuple[Array, Array]:
    """Middles and medians of the bins; empty ones are bridged."""
    good = np.isfinite(values)
    which = ((t - t[0]) // max(BIN, 2 * float(np.median(np.diff(t))))).astype(int)
    middles = np.bincount(which, t) / np.maximum(np.bincount(which), 1)
    known, first = np.unique(which[good], return_index=True)
    return middles[known], np.array([np.median(some) for some in np.split(values[good], first[1:]) if len(some)])


def find_loose_contact(runs: Sequence[Steps | None], fewest: int = FEWEST) -> LooseContact | None:
    """What the jumps of one channel in all runs have in common; None where that is nothing. Runs that are too short to
    tell, or do not read it, have no windows."""
    shares = np.abs(np.concatenate([np.empty(0), *(steps.shares for steps in runs if steps is not None)]))
    if len(shares) < fewest:
        return None
    near = np.abs(shares[:, None] - shares) < ALIKE * shares[:, None]
    alike = shares[near[near.sum(axis=1).argmax()]]
    share = float(np.median(alike))
    if len(alike) < fewest or len(shares) - len(alike) > MOST_OTHERS * len(shares):
        return None
    windows = tuple(() if steps is None else steps.windows(share) for steps in runs)
    if not SHARES[0] < share < SHARES[1] or not any(windows):
        return None
    return LooseContact(share, float(np.std(alike) / np.sqrt(len(alike))), windows)
