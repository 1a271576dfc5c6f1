"""Answers of a network that is not linear in temperature: those of its windows' straight laws, and the rest as heat.

What a law's slope at an instant lies beside that of its window gives a further heat as the temperature it reads moves;
that heat is answered in turn, and so on: δ ← answer to B(t) δ, whose sum converges as the windows are narrow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from network.calibration.course import Course, Push
from network.calibration.sight import Sight, sight_of
from network.declare import Array, Indices
from network.graph import Flows, Heats, Network
from network.mechanisms.base import Source
from network.refusal import Failed

ROUNDS, CLOSE = 30, 1e-4
"""Rounds at most, and the share of an answer that may be missing."""
LEAST = 1e-9
"""W/K: bends below it are none."""

Off = Sequence[tuple[Flows | Heats[Source], tuple[Array, ...]]]


@dataclass(frozen=True, eq=False)
class Bends:
    """Heat series h_e = Σ slopes[j] · (rows @ T)[reads[j]] for the pairs j with into[j] = e.

    rows: what is read, over all lumps (r, N); reads, into: row and series of each pair; slopes (pairs, 2 K); spread:
    what of each series goes into which lump (series, N).
    """

    rows: Array
    reads: Indices
    into: Indices
    slopes: Array
    spread: Array

    def heat(self, seen: Array) -> Array:
        """Series (pushes, series, 2 K) from changes of what is read (pushes, r, 2 K)."""
        h = np.zeros((len(seen), len(self.spread), seen.shape[2]))
        for read, into, slope in zip(self.reads, self.into, self.slopes, strict=True):
            h[:, into] += slope * seen[:, read]
        return h


def bends_of(network: Network, off: Off) -> Bends:
    """The bends of some groups of laws, from how far their slopes lie beside the windows': each (2 K, members)."""
    rows: dict[bytes, int] = {}
    pairs: list[tuple[int, int, Array]] = []
    spread: list[Array] = []
    for group, slopes in off:
        for m in range(len(group.entry)):
            known = [(row, s[:, m]) for row, s in zip(_rows(network, group, m), slopes, strict=True)]
            felt = [(row, s) for row, s in known if row.any() and np.abs(s).max() > LEAST]
            for row, s in felt:
                weight = group.w[m] if isinstance(group, Flows) else 1.0
                pairs.append((rows.setdefault(row.tobytes(), len(rows)), len(spread), weight * s))
            if felt:
                spread.append(group.spread[m] if isinstance(group, Flows) else group.into[:, m])
    N = network.size
    read, into, slopes_of = zip(*pairs, strict=True) if pairs else ((), (), ())
    return Bends(
        np.array([np.frombuffer(row) for row in rows]).reshape(len(rows), N), np.array(read, int), np.array(into, int),
        np.array(slopes_of), np.array(spread).reshape(len(spread), N),
    )  # fmt: skip


def _rows(network: Network, group: Flows | Heats[Source], m: int) -> list[Array]:
    """What one member reads, without held lumps."""
    if isinstance(group, Flows):
        unit = np.eye(network.size)
        rows = [unit[group.a[m]], unit[group.b[m]]]
    else:
        rows = [R[m] for R in group.reads]
    return [np.where(np.isinf(network.capacity), 0.0, row) for row in rows]


@dataclass(frozen=True, eq=False)
class BentCourse(Course):
    """A course whose answers take the bends along."""

    bends: Bends | None = None

    def resolved(self, pushes: Sequence[Push], by_guard: Array | None = None) -> Sequence[Push]:
        """Pushes with the heat that bent laws add as temperatures answer to it."""
        if self.bends is None or not len(self.bends.spread):
            return pushes
        sight = sight_of(self.problem, self.bends.rows)
        return [p for some in self.portions(len(pushes)) for p in self._settled(pushes[some], sight, self.bends)]

    def _settled(self, pushes: Sequence[Push], sight: Sight, bends: Bends) -> list[Push]:
        K, lumps = len(self.x0), np.flatnonzero(bends.spread.any(axis=0))
        seen = self.ends(pushes, sight)
        size = np.maximum(np.abs(seen).max(axis=(1, 2)), 1e-300)
        total = np.zeros((len(pushes), len(bends.spread), 2 * K))
        for _ in range(ROUNDS):
            h = bends.heat(seen)
            total += h
            seen = self.ends([Push(lumps, q[:, :K].T, q[:, K:].T, (), bends.spread[:, lumps]) for q in h], sight)
            if (np.abs(seen).max(axis=(1, 2)) < CLOSE * size).all():
                return [_joined(p, q, lumps, bends.spread[:, lumps]) for p, q in zip(pushes, total, strict=True)]
        raise Failed("the answers of the network to a change of its numbers do not settle: a heat source may run away")


def _joined(push: Push, series: Array, lumps: Indices, spread: Array) -> Push:
    """A push with further series (·, 2 K)."""
    K, both = len(push.q0), np.union1d(push.lumps, lumps)
    own = np.eye(len(push.lumps)) if push.spread is None else push.spread
    into = np.zeros((len(own) + len(spread), len(both)))
    into[: len(own), np.searchsorted(both, push.lumps)] = own
    into[len(own) :, np.searchsorted(both, lumps)] = spread
    heat = [np.hstack([q, s.T]) for q, s in ((push.q0, series[:, :K]), (push.q1, series[:, K:]))]
    return Push(both, heat[0], heat[1], push.kicks, into)
