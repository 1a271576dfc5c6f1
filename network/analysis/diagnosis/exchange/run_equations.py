"""The normal equations of one run, with any two of its channels exchanged: no run is computed for it.

J(x) = c − 2 gᵀx + xᵀN x of the whitened rows is a sum over channels. Where a and b are exchanged, the readings of a are
compared to what the machine does at the place of b: these two parts of the sum change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import add

import numpy as np

from network.analysis.calibration.linearised import Linearised, divide_mean_slopes
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.noise import Whitener
from network.analysis.diagnosis.exchange.exchanged_columns import Pair, exchange_columns
from network.catalogue.declaration.declare import Array, Mask
from network.engine.network import Network
from network.engine.start import start_temperatures
from network.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations: J(x) = c − 2 gᵀx + xᵀN x."""

    N: Array
    g: Array
    c: float

    def __add__(self, other: Normal) -> Normal:
        return Normal(self.N + other.N, self.g + other.g, self.c + other.c)

    @classmethod
    def prior(cls, mean: Array, spread: Array) -> Normal:
        """Of independent unknowns with mean and 1σ."""
        P = spread**-2.0
        return cls(np.diag(P), P * mean, float(mean @ (P * mean)))

    @property
    def least(self) -> float:
        return self.c - float(self.g @ np.linalg.solve(self.N, self.g))

    def fold(self, own: Normal) -> Normal:
        """With the last unknowns, whose prior is given, at their most probable."""
        k = len(self.g) - len(own.g)
        g, across = self.g[k:] + own.g, self.N[k:, :k]
        taken = np.linalg.solve(self.N[k:, k:] + own.N, np.column_stack([across, g]))
        N, toward = self.N[:k, :k] - across.T @ taken[:, :-1], self.g[:k] - across.T @ taken[:, -1]
        return Normal(N, toward, self.c + own.c - float(g @ taken[:, -1]))


@dataclass(frozen=True, eq=False)
class RunEquations:
    """One run. truth: of its channels (channels, cells); slopes: of it by θ and what is the run's own (unknowns,
    channels, cells); offsets: channels whose constant errors are unknown, common to all runs; free: parameters."""

    data: Measured
    whitener: Whitener
    network: Network
    truth: Array
    slopes: Array
    offsets: tuple[str, ...]
    free: int

    @property
    def names(self) -> Sequence[str]:
        return self.data.run.channels

    @cached_property
    def own(self) -> list[Normal]:
        """Of every channel at its own place."""
        return [self.compare(j, j) for j in range(len(self.names))]

    @cached_property
    def as_it_is(self) -> Normal:
        return reduce(add, self.own)

    def exchange(self, pair: Pair) -> Normal:
        """With two of its channels exchanged."""
        a, b = (self.names.index(name) for name in pair)
        rest = [normal for j, normal in enumerate(self.own) if j not in (a, b)]
        return reduce(add, [*rest, self.compare(a, b), self.compare(b, a)])

    def compare(self, reads: int, at: int) -> Normal:
        """The readings of one channel against what the machine does at the place of another."""
        cells, n, m = self.data.run.knots.cells, self.free, self.free + len(self.offsets)
        rows = slice(reads * cells, (reads + 1) * cells)
        known, (_, root) = self.data.known[rows], self.whitener.blocks[reads]
        columns = np.zeros((m + len(self.slopes) - n + 1, int(known.sum())))
        columns[:n], columns[m:-1] = np.split(self.slopes[:, at, known], [n])
        if self.data.recording.offsets and self.names[reads] in self.offsets:
            columns[n + self.offsets.index(self.names[reads])] = 1.0
        columns[-1] = self.data.means[rows][known] - self.truth[at, known]
        white = columns / root if root.ndim == 1 else np.linalg.solve(root, columns.T).T
        products = white @ white.T
        return Normal(products[:-1, :-1], products[:-1, -1], float(products[-1, -1]))

    def move_starts(self, pair: Pair) -> Array:
        """By how much the parts begin elsewhere where first readings are exchanged [K]; 0 for what else is the run's
        own."""
        after = self._begin(exchange_columns(self.data.recording, pair))
        moved = [after[n.name] - self._begins[n.name] for n in self.data.starts]
        return np.array([*moved, *np.zeros(len(self.data.own) - len(moved))])

    @cached_property
    def _begins(self) -> dict[str, float]:
        """Where the parts begin as it was read."""
        return self._begin(self.data.recording)

    def _begin(self, recording: Recording) -> dict[str, float]:
        T = start_temperatures(self.network, self.data.run.schedule, recording)
        return {name: float(T[part].mean()) for name, part in self.network.parts.items()}


def list_runs(at: Linearised) -> tuple[RunEquations, ...]:
    """Of all runs of a fit."""
    problem = at.problem
    network = problem.model.at(at.theta)[1]
    offsets = tuple(n.name for n in problem.offsets)
    slopes = [of.whole for of in divide_mean_slopes(problem, at.theta, at.predictions)]
    runs = zip(problem.data, problem.whiteners, at.predictions, slopes, strict=True)
    return tuple(_run(data, w, network, p.cells, by, offsets, at.free) for data, w, p, by in runs)


def _run(
    data: Measured, whitener: Whitener, network: Network, cells: Array, slopes: Array, offsets: tuple[str, ...],
    free: int,
) -> RunEquations:  # fmt: skip
    """What the machine does at a channel whose cells are empty lies between the cells that are not."""
    shape = (len(data.run.channels), data.run.knots.cells)
    known = data.known.reshape(shape)
    values = np.concatenate([cells[None], slopes]).reshape(-1, *shape)
    for j in np.flatnonzero(~known.all(axis=1)):
        values[:, j] = _bridge(values[:, j], data.centres, known[j])
    return RunEquations(data, whitener, network, values[0], values[1:], offsets, free)


def _bridge(rows: Array, t: Array, known: Mask) -> Array:
    return np.array([np.interp(t, t[known], row[known]) for row in rows])
