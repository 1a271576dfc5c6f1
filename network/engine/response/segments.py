"""Stretches of a run in one regime: how the modes move over their intervals, and what heat at the ends of these adds.

Within an interval the heat runs straight from q₀ to q₁, so a mode with rate λ moves as m(h) = e^(−λh) m + c₀ p₀ + c₁ p₁
with c₁ = h φ₂(−λh), c₀ = h φ₁(−λh) − c₁ (solvers.modal).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.response.recursion import recur
from network.engine.solvers.elimination import Regime
from network.engine.solvers.linear import LinearProblem
from network.engine.solvers.modal import Modes, phi


@dataclass(frozen=True, eq=False)
class Push:
    """A small further heat: q0, q1 [W] into some lumps, just after and before the edges of every interval (K, lumps);
    kicks: (interval, jump of the states at its beginning); jumps: more of these, at intervals (E,) that the pushes of a
    run share, by (E, n).

    spread: with it, q0 and q1 are series (K, r) that go into the lumps by spread (r, lumps).
    """

    lumps: Indices
    q0: Array
    q1: Array
    kicks: tuple[tuple[int, Array], ...] = ()
    spread: Array | None = None
    jumps: tuple[Indices, Array] | None = None

    @property
    def is_kicked(self) -> bool:
        return bool(self.kicks) or self.jumps is not None

    @property
    def all_kicks(self) -> Iterator[tuple[int, Array]]:
        """Kicks and jumps."""
        yield from self.kicks
        if self.jumps is not None:
            yield from zip(self.jumps[0].tolist(), self.jumps[1], strict=True)

    @property
    def series(self) -> int:
        return int(self.q0.shape[1])

    @property
    def is_heat(self) -> bool:
        return self.series > 0

    def into(self, by_lump: Array) -> Array:
        """Rows for its series from columns for all lumps (·, N): (r, ·)."""
        own = by_lump[:, self.lumps].T
        return own if self.spread is None else self.spread @ own


@dataclass(frozen=True, eq=False)
class Segment:
    """Intervals first to last (excluded) in regime `index`. heat: modes by the heat of lumps (n, N); ended: the last
    intervals of runs among them, whose factors are zero so that nothing is carried on, and what these factors are."""

    first: int
    last: int
    index: int
    regime: Regime
    modes: Modes
    heat: Array
    gain: Array
    c0: Array
    c1: Array
    ended: tuple[Indices, Array, Array, Array] | None = None

    def forget(self, ends: Iterable[int]) -> Segment:
        """The stretch carrying nothing beyond some of its intervals, which are the last of their runs."""
        at = np.array(sorted(ends), int) - self.first
        if not len(at):
            return self
        gain, c0, c1 = (factor.copy() for factor in (self.gain, self.c0, self.c1))
        gain[at] = c0[at] = c1[at] = 0.0
        return replace(self, gain=gain, c0=c0, c1=c1, ended=(at, self.gain[at], self.c0[at], self.c1[at]))

    @property
    def factors(self) -> tuple[Array, Array, Array]:
        """gain, c0 and c1 as the run itself goes, whether anything is carried on or not."""
        if self.ended is None:
            return self.gain, self.c0, self.c1
        at, *own = self.ended
        gain, c0, c1 = (factor.copy() for factor in (self.gain, self.c0, self.c1))
        gain[at], c0[at], c1[at] = own
        return gain, c0, c1

    def march_pushes(self, pushes: Sequence[Push], start: Array) -> tuple[Array, Array, Array]:
        """Modal states of pushes (k, pushes, n) just after the beginnings and just before the ends of the intervals,
        and after the last, from modal states (pushes, n)."""
        p0, p1 = self.force_modes(pushes)
        forcing = self.integrate_forcing(p0, p1).astype(start.dtype, copy=False)
        jumps = list(self.kicks(pushes))
        for k, i, jump in jumps:
            if k:
                forcing[k - 1, i] += jump
            else:
                start[i] += jump
        m, end = recur(self.gain, forcing, start)
        stop = np.concatenate([m[1:], end[None]])
        for k, i, jump in jumps:
            if k:
                stop[k - 1, i] -= jump
        if self.ended is not None:
            at, gain, c0, c1 = self.ended
            stop[at] = gain[:, None] * m[at] + c0[:, None] * p0[at] + c1[:, None] * p1[at]
        return m, stop, end

    def march_forced(self, p0: Array, p1: Array, start: Array) -> tuple[Array, Array]:
        """Modal states at the beginnings, and after the last, under forcings at both ends (k, pushes, n)."""
        return recur(self.gain, self.integrate_forcing(p0, p1).astype(start.dtype, copy=False), start)

    def integrate_forcing(self, p0: Array, p1: Array) -> Array:
        """What the forcing of every interval adds to its modes: (k, pushes, n)."""
        own = self.c0[:, None] * p0
        own += self.c1[:, None] * p1
        return own

    def force_modes(self, pushes: Sequence[Push]) -> tuple[Array, Array]:
        """Forcings of the modes by the heat of pushes, at both ends of every interval: (k, pushes, n) each."""
        here, shape = slice(self.first, self.last), (self.last - self.first, len(pushes), len(self.heat))
        first, last = np.empty(shape, self.heat.dtype), np.empty(shape, self.heat.dtype)
        for i, push in enumerate(pushes):
            by = push.into(self.heat)
            if len(by) == 1:
                np.multiply(push.q0[here], by, out=first[:, i])
                np.multiply(push.q1[here], by, out=last[:, i])
            else:
                first[:, i], last[:, i] = push.q0[here] @ by, push.q1[here] @ by
        return first, last

    def kicks(self, pushes: Sequence[Push]) -> Iterator[tuple[int, int, Array]]:
        """Kicks within: interval of the stretch, push, jump of the modes."""
        for i, push in enumerate(pushes):
            for k, jump in push.all_kicks:
                if self.first <= k < self.last:
                    yield k - self.first, i, self.modes.W @ jump


def segments(problem: LinearProblem, modes: Sequence[Modes]) -> Iterator[Segment]:
    """The segments of a run, in order."""
    cuts = (np.flatnonzero(np.diff(problem.regime_of)) + 1).tolist()
    heat = [regime.see_driven(m.W) for m, regime in zip(modes, problem.regimes, strict=True)]
    factors = _factors(problem, modes)
    for first, last in zip([0, *cuts], [*cuts, len(problem.regime_of)], strict=True):
        r = int(problem.regime_of[first])
        gain, c0, c1 = (as_modes(factor[first:last], modes[r]) for factor in factors)
        yield Segment(first, last, r, problem.regimes[r], modes[r], heat[r], gain, c0, c1)


def as_modes(values: Array, modes: Modes) -> Array:
    """Values of the modes of one regime, which stood among those of others; real where its modes are."""
    return np.ascontiguousarray(values.real) if modes.is_real and np.iscomplexobj(values) else values


def rates_of(modes: Sequence[Modes]) -> Array:
    """Decay rates of the modes of every regime (regimes, n)."""
    return np.array([m.rates for m in modes])


def _factors(problem: LinearProblem, modes: Sequence[Modes]) -> tuple[Array, Array, Array]:
    """Decay over every step, and what heat at its two ends adds (K, n); steps of one length in one regime are worked
    out once."""
    lengths, of_step = problem.plan.step_lengths
    kinds, kind = np.unique(problem.regime_of * len(lengths) + of_step, return_inverse=True)
    r, length = np.divmod(kinds, len(lengths))
    h: Array = lengths[length, None]
    z = -rates_of(modes)[r] * h
    one, two, _ = phi(z)
    late = h * two
    gain, c0, c1 = (np.take(factor, kind, axis=0) for factor in (np.exp(z), h * one - late, late))
    return gain, c0, c1
