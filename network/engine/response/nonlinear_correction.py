"""Answers of a network that is not linear in temperature: those of its straight laws, and the rest as heat.

What a law's slope lies beside the one in the matrix gives a further heat as the temperature it reads moves: h = B(t) y.
Over an interval it runs straight as other heats do, so its value at the end follows from a small linear system,
(1 − G B₁) y₁ = z, G what a heat at the end does to the readings there: exact, step by step, for all pushes at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.entry_groups import Flows
from network.engine.network import Network
from network.engine.response.bent_steps import BentSteps
from network.engine.response.linear_run import LinearRun
from network.engine.response.nonlinear_laws import Group, Slopes
from network.engine.response.output_map import map_outputs
from network.engine.response.segments import Push

LEAST = 1e-9
"""W/K: bends below it are none."""
TOGETHER = 1_600_000
"""Numbers in the modal states of pushes that are answered together (measured: fewer steps beat the cache)."""
KEPT = 5_000_000
"""Intervals times modes times readings up to which a course keeps what its intervals do."""

Off = Sequence[tuple[Group, Slopes]]


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

    @cached_property
    def matrices(self) -> tuple[Array, Array]:
        """B just after and just before the edges of every interval (K, series, r)."""
        K = self.slopes.shape[1] // 2
        B = np.zeros((2 * K, len(self.spread), len(self.rows)))
        for read, into, slope in zip(self.reads, self.into, self.slopes, strict=True):
            B[:, into, read] += slope
        return B[:K], B[K:]

    def within(self, run: slice) -> Bends:
        """Those of one of several runs that follow each other."""
        K = self.slopes.shape[-1] // 2
        slopes = [self.slopes[..., run], self.slopes[..., K + run.start : K + run.stop]]
        return replace(self, slopes=np.concatenate(slopes, axis=-1))

    def beside(self, other: Bends) -> Bends:
        """These and others."""
        slopes = [own.reshape(-1, other.slopes.shape[1]) for own in (self.slopes, other.slopes)]
        return Bends(
            np.vstack([self.rows, other.rows]), np.concatenate([self.reads, other.reads + len(self.rows)]),
            np.concatenate([self.into, other.into + len(self.spread)]), np.vstack(slopes),
            np.vstack([self.spread, other.spread]),
        )  # fmt: skip


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


def _rows(network: Network, group: Group, m: int) -> list[Array]:
    """What one member reads, without held lumps."""
    if isinstance(group, Flows):
        unit = np.eye(network.size)
        rows = [unit[group.a[m]], unit[group.b[m]], *(R[m] for R in group.reads)]
    else:
        rows = [R[m] for R in group.reads]
    return [np.where(np.isinf(network.capacity), 0.0, row) for row in rows]


@dataclass(frozen=True, eq=False)
class BentCourse(LinearRun):
    """A course whose answers take the bends along. melts: lumps that melt, and what more a watt counts in them than it
    does by the windows' capacities (2 K, ·)."""

    bends: Bends | None = None
    melts: tuple[Indices, Array] | None = None

    def complete_pushes(self, pushes: Sequence[Push], by_guard: Array | None = None) -> Sequence[Push]:
        """Pushes with the heat that bent laws add as temperatures answer to it."""
        own, bent = self.divide_pushes(pushes)
        return own if bent is None else [_append_series(*pair) for pair in zip(own, bent, strict=True)]

    def straighten(self, pushes: Sequence[Push]) -> Sequence[Push]:
        """As the windows' laws answer them."""
        return pushes if self.melts is None else [_stretch(p, *self.melts) for p in pushes]

    def divide_pushes(
        self, pushes: Sequence[Push], by_guard: Array | None = None
    ) -> tuple[Sequence[Push], Sequence[Push] | None]:  # fmt: skip
        """The same apart: as the windows' laws answer them, and the heat that the bends add."""
        if self.bends is None or not len(self.bends.spread):
            return pushes, None
        pushes, steps = self.straighten(pushes), self._list_steps(self.bends)
        parts = (self._bend(pushes[some], steps, self.bends) for some in self.portions(len(pushes), TOGETHER))
        return pushes, [push for part in parts for push in part]

    def _list_steps(self, bends: Bends) -> tuple[BentSteps, ...]:
        """What the intervals of every stretch do to the heat of the bends; kept where that is not much."""
        if len(self.x0) * self.problem.order * len(bends.rows) > KEPT:
            return self._make_steps(bends)
        if "kept" not in self.__dict__:
            self.__dict__["kept"] = self._make_steps(bends)
        kept: tuple[BentSteps, ...] = self.__dict__["kept"]
        return kept

    def _make_steps(self, bends: Bends) -> tuple[BentSteps, ...]:
        output_map, (B0, B1) = map_outputs(self.problem, bends.rows), bends.matrices
        here = (slice(s.first, s.last) for s in self.segments)
        return tuple(BentSteps.of(s, output_map, bends.spread, B0[at], B1[at])
                     for s, at in zip(self.segments, here, strict=True))  # fmt: skip

    def __getstate__(self) -> dict[str, object]:
        """Another process works its steps out for itself."""
        return {name: value for name, value in self.__dict__.items() if name != "kept"}

    def _bend(self, pushes: Sequence[Push], every: Sequence[BentSteps], bends: Bends) -> list[Push]:
        lumps, K = np.flatnonzero(bends.spread.any(axis=0)), len(self.x0)
        h0, h1 = (np.empty((K, len(pushes), len(bends.spread))) for _ in range(2))
        x = np.zeros((len(pushes), self.problem.order))
        for s, steps in zip(self.segments, every, strict=True):
            here = slice(s.first, s.last)
            end = steps.along(pushes, x @ s.modes.W.T, h0[here], h1[here])
            x = np.real(end @ s.modes.V.T)
        spread = bends.spread[:, lumps]
        return [Push(lumps, h0[:, i], h1[:, i], (), spread) for i in range(len(pushes))]


def _stretch(push: Push, lumps: Indices, gain: Array) -> Push:
    """A push whose heat into lumps that melt counts so much more."""
    if not push.is_heat:
        return push
    K, unit = len(push.q0), np.eye(int(max(push.lumps.max(), lumps.max())) + 1)[lumps]
    q0, q1 = (q @ push.into(unit) for q in (push.q0, push.q1))
    return _append_series(push, Push(lumps, gain[:K] * q0, gain[K:] * q1))


def _append_series(push: Push, more: Push) -> Push:
    """A push with the series of another one, which has no kicks."""
    both = np.union1d(push.lumps, more.lumps)
    own, further = (np.eye(len(p.lumps)) if p.spread is None else p.spread for p in (push, more))
    into = np.zeros((len(own) + len(further), len(both)))
    into[: len(own), np.searchsorted(both, push.lumps)] = own
    into[len(own) :, np.searchsorted(both, more.lumps)] = further
    return Push(both, np.hstack([push.q0, more.q0]), np.hstack([push.q1, more.q1]), push.kicks, into)
