"""Two sets of runs of one machine fitted together: what they share, and what the second has otherwise.

p: numbers θ (or their logarithms), then a constant error of every channel; the first set has p, the second p + d. Of d
only some entries are free: constant errors, which may differ by what sensors of a kind are off by, and those that are
`split`, about which nothing is supposed. J(p, d) = Σ J_r + |(p − p₀)/σ|² + |d/σ_d|², least by Gauss–Newton steps that
are halved until they gain; every run is weighed by the misfit that lasts in its set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.analysis.calibration.linearised import Linearised, linearise
from network.analysis.calibration.measured_means import OFFSET
from network.analysis.calibration.problem import Problem
from network.analysis.change.run_information import RunInformation, WeighedRun, weigh_runs
from network.catalogue.declaration.declare import Array, Mask
from network.engine.response.parameters import Parameter, centres
from network.machine.machine import Machine
from network.platform.refusal import Failed

STEPS, CLOSE = 10, 0.02
"""Gauss–Newton steps at most, and what J has to lose for another."""
HALVED = 5
LOOSE = 10.0
"""Prior 1σ of a split entry, in those that it has by itself: as good as nothing."""


@dataclass(frozen=True, eq=False)
class Sets:
    """Two problems, without offsets, of one machine: then and now; scales: of their noise; loose: prior 1σ of a split
    entry, in those that it has by itself; begin: θ that fits the first."""

    machine: Machine
    problems: tuple[Problem, Problem]
    begin: Array
    scales: tuple[float, float] = (1.0, 1.0)
    loose: float = LOOSE

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.problems[0].parameters

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """Channels that some run of both sets has."""
        now, then = ({n for d in problem.data for n in d.run.channels} for problem in self.problems)
        return tuple(n for n in self.machine.sensors if n in now and n in then)

    @cached_property
    def usual_offset(self) -> Array:
        """1σ of the constant error of sensors of each channel's kind [SI]."""
        return np.array([OFFSET[self.machine.sensors[n].unit] for n in self.channels])

    @cached_property
    def offset_spread(self) -> Array:
        """Prior 1σ of a constant error; next to nothing where recordings say that there is none."""
        heard = all(d.recording.offsets for problem in self.problems for d in problem.data)
        return self.usual_offset * (1.0 if heard else 1e-6)

    @cached_property
    def prior(self) -> tuple[Array, Array]:
        """Means and 1σ of p."""
        spread = np.array([p.spread for p in self.parameters])
        means = np.concatenate([centres(self.parameters), np.zeros(len(self.channels))])
        return means, np.concatenate([spread, self.offset_spread])

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        return np.array([p.low for p in self.parameters]), np.array([p.high for p in self.parameters])

    def spread_of_difference(self, split: Sequence[int]) -> Array:
        """Prior 1σ of d; 0 where it is none."""
        n = len(self.parameters)
        spread = np.concatenate([np.zeros(n), self.offset_spread])
        own = np.concatenate([self.prior[1][:n], self.usual_offset])
        spread[list(split)] = self.loose * own[list(split)]
        return spread


@dataclass(frozen=True, eq=False)
class PairedFit:
    """A fit about some p and d. at: both problems there; runs: of both sets, weighed."""

    sets: Sets
    split: tuple[int, ...]
    p: Array
    d: Array
    at: tuple[Linearised, Linearised]
    runs: tuple[tuple[WeighedRun, ...], tuple[WeighedRun, ...]]

    @cached_property
    def information(self) -> tuple[tuple[RunInformation, ...], tuple[RunInformation, ...]]:
        first, second = (tuple(run.information for run in runs) for runs in self.runs)
        return first, second

    @property
    def spread(self) -> Array:
        return self.sets.spread_of_difference(self.split)

    @property
    def free(self) -> Mask:
        """Entries of d that may differ."""
        return np.asarray(self.spread > 0)

    @cached_property
    def cost(self) -> float:
        (mean, sigma), free = self.sets.prior, self.free
        prior = float(np.sum(((self.p - mean) / sigma) ** 2)) + float(np.sum((self.d[free] / self.spread[free]) ** 2))
        return prior + sum(run.cost for runs in self.information for run in runs)

    @cached_property
    def totals(self) -> tuple[Array, Array, Array, Array]:
        """N and g of both sets together, and of the second."""
        N, g = (sum((getattr(r, name) for runs in self.information for r in runs), start=0.0 * self.p)
                for name in ("precision", "gradient"))  # fmt: skip
        N2, g2 = (sum((getattr(r, name) for r in self.information[1]), start=0.0 * self.p)
                  for name in ("precision", "gradient"))  # fmt: skip
        return N, g, N2, g2

    def system(self, spread: Array) -> tuple[Array, Array]:
        """Precision and −½ gradient of J in (p, d where it is free), d with prior 1σ `spread`."""
        (mean, sigma), free = self.sets.prior, spread > 0
        N, g, N2, g2 = self.totals
        H = np.block([[N + np.diag(sigma**-2.0), N2[:, free]],
                      [N2[free], N2[np.ix_(free, free)] + np.diag(spread[free] ** -2.0)]])  # fmt: skip
        return H, np.concatenate([g + (mean - self.p) / sigma**2, g2[free] - self.d[free] / spread[free] ** 2])


def fit_sets(sets: Sets, split: Sequence[int] = (), near: PairedFit | None = None) -> PairedFit:
    """The most probable p and d, from those of another fit, or from where the sets begin. Raises Failed where runs run
    away."""
    nothing = np.zeros(len(sets.channels))
    p, d = (near.p, near.d) if near else (np.append(sets.begin, nothing), np.zeros(len(sets.prior[0])))
    d = np.where(sets.spread_of_difference(tuple(split)) > 0, d, 0.0)
    at = _fit_at(sets, tuple(split), p, d)
    for _ in range(STEPS):
        new = _improve(at)
        gain, at = at.cost - new.cost, new
        if gain < CLOSE:
            break
    return at


def _fit_at(sets: Sets, split: tuple[int, ...], p: Array, d: Array) -> PairedFit:
    n = len(sets.parameters)
    at = [linearise(problem, x[:n]) for problem, x in zip(sets.problems, (p, p + d), strict=True)]
    runs = [tuple(weigh_runs(one, sets.channels, x[n:], scale))
            for one, x, scale in zip(at, (p, p + d), sets.scales, strict=True)]  # fmt: skip
    return PairedFit(sets, split, p, d, (at[0], at[1]), (runs[0], runs[1]))


def _improve(at: PairedFit) -> PairedFit:
    """A step that gains, or the same."""
    H, gradient = at.system(at.spread)
    step = np.linalg.solve(H, gradient)
    size, free = len(at.p), at.free
    if float(step @ gradient) < CLOSE:
        return at
    for k in range(HALVED):
        move = step * 0.5**k
        d = at.d.copy()
        d[free] += move[size:]
        p, d = _within(at.sets, at.p + move[:size], d)
        try:
            new = _fit_at(at.sets, at.split, p, d)
        except Failed:
            continue
        if new.cost < at.cost:
            return new
    return at


def _within(sets: Sets, p: Array, d: Array) -> tuple[Array, Array]:
    """Numbers of both sets within their bounds."""
    n, (low, high) = len(sets.parameters), sets.bounds
    now = np.clip(p[:n] + d[:n], low, high)
    p = np.concatenate([np.clip(p[:n], low, high), p[n:]])
    return p, np.concatenate([np.where(d[:n] == 0, 0.0, now - p[:n]), d[n:]])


def weigh_again(at: PairedFit, scales: tuple[float, float]) -> PairedFit:
    """The same fit with other weights, about the same point."""
    return _fit_at(replace(at.sets, scales=scales), at.split, at.p, at.d)
