"""Means over cells of a run and of its answers to pushes: exact at the samples, though only knots are computed.

At a time τ after the beginning of an interval of length h a mode stands at e^(−λτ) m + τ φ₁ p₀ + τ² φ₂ (p₁ − p₀)/h, so
its sum over the samples of the interval, each with its share, is E m + F₀ p₀ + F₁ p₁, with factors of interval and rate
only. Modes are averaged before they are read, which is the lesser work.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.response.cells import Averages, Samples, sum_rows
from network.engine.response.heat_series import HeatSeries
from network.engine.response.linear_run import LinearRun
from network.engine.response.output_map import OutputMap
from network.engine.response.segments import Push, Segment, as_modes, rates_of
from network.engine.response.series import Pieces, compile_means, pieces_of
from network.engine.response.state_jumps import Kicks

Modal = Callable[[int, Indices, Array], tuple[list[Array], Array]]
"""What follows the modes over a stretch: from its number, where its cells begin and modal states (pushes, n) to means
(cells, pushes, n) for each set of samples, and the states after it."""

SLOW = 1e-3
"""λ h below which the factors come from a series, for their differences would cancel."""


@dataclass(frozen=True, eq=False)
class Factors:
    """E, F₀, F₁ of intervals (k, n)."""

    E: Array
    F0: Array
    F1: Array

    def within(self, s: Segment) -> Factors:
        """Those of a stretch."""
        return Factors(*(as_modes(own[s.first : s.last], s.modes) for own in (self.E, self.F0, self.F1)))


@dataclass(frozen=True, eq=False)
class Means:
    """The cells of a run, seen through averages."""

    course: LinearRun
    over: Averages

    @cached_property
    def factors(self) -> tuple[tuple[Factors, ...], ...]:
        """Of every stretch, for each set of samples."""
        return tuple(tuple(f.within(s) for f in self._whole_factors) for s in self.course.segments)

    @cached_property
    def _whole_factors(self) -> list[Factors]:
        problem, rates = self.course.problem, rates_of(self.course.modes)
        return [_factors(samples, rates, problem.regime_of, problem.plan.steps) for samples in self.over.samples]

    def _rows(self, output_map: OutputMap) -> list[Array]:
        """Rows over the modes of every regime (count, n)."""
        return [over @ modes.V for over, modes in zip(output_map.over, self.course.modes, strict=True)]

    def bulge(self, output_map: OutputMap) -> Array:
        """What the run's own means differ by from those of straight lines between its ends: (count, cells)."""
        return self._average(output_map, self.over.left, self.over.right)

    def follow_states(self, output_map: OutputMap) -> Array:
        """Means of what is seen of the states: (count, cells)."""
        none = np.zeros((len(self.over.samples), 1))
        return self._average(output_map, none, none)

    def _average(self, output_map: OutputMap, left: Array, right: Array) -> Array:
        """Means over cells of what is seen of the states, less that of weights on both ends of the intervals."""
        out = np.zeros((output_map.count, self.over.cells), complex if self._is_complex else float)
        is_bent, by_regime = bool(left.any() or right.any()), self._rows(output_map)
        for s, factors, ends in zip(self.course.segments, self.factors, self.course.modal_ends, strict=True):
            here = slice(s.first, s.last)
            cells, starts = self.over.find_touched(s.first, s.last)
            rows = by_regime[s.index]
            for i, channels in self.over.groups():
                f = factors[i]
                mean = f.F0 * ends.p0
                mean += f.F1 * ends.p1
                if is_bent:
                    mean += (f.E - left[i, here, None]) * ends.m0
                    mean -= right[i, here, None] * ends.m1
                else:
                    mean += f.E * ends.m0
                out[channels, cells] += rows[channels] @ sum_rows(mean, starts).T
        return np.real(out)

    @property
    def _is_complex(self) -> bool:
        return any(np.iscomplexobj(m.rates) for m in self.course.modes)

    def respond_to(self, pushes: Sequence[Push], output_map: OutputMap) -> Array:
        """Means over cells of the outputs, for resolved pushes: (pushes, count, cells)."""
        out = np.zeros((len(pushes), output_map.count, self.over.cells))
        single = [i for i, push in enumerate(pushes) if push.series == 1]
        many = [i for i, push in enumerate(pushes) if push.series > 1]
        for heats, follow in ((single, self._follow_series), (many, self._follow_pushes)):
            for some in self.course.portions(len(heats)):
                mine = heats[some]
                out[_as_slice(mine)] = self._by_heat([pushes[i] for i in mine], output_map, follow)
        kicked = [i for i, push in enumerate(pushes) if push.is_kicked]
        if kicked:
            out[_as_slice(kicked)] += self._by_kicks([pushes[i] for i in kicked], output_map)
        return out

    def _by_heat(self, pushes: Sequence[Push], output_map: OutputMap, follow: Callable[[HeatSeries], Modal]) -> Array:
        out = np.zeros((self.over.cells, len(pushes), output_map.count))
        x, by_regime = np.zeros((len(pushes), self.course.problem.order)), self._rows(output_map)
        modal = follow(HeatSeries.of(pushes, self.course))
        for index, s in enumerate(self.course.segments):
            cells, starts = self.over.find_touched(s.first, s.last)
            rows = by_regime[s.index].T
            means, end = modal(index, starts, x @ s.modes.W.T)
            x = np.real(end @ s.modes.V.T)
            for i, channels in self.over.groups():
                out[cells][..., channels] += np.real(means[i] @ rows[:, channels])
                if output_map.sees_heat:
                    out[cells][..., channels] += self._direct(s, i, pushes, output_map, starts)[..., channels]
        return out.transpose(1, 2, 0)

    def _follow_series(self, heat: HeatSeries) -> Modal:
        """For pushes of one series."""
        if compile_means() is not None and not self._is_complex:
            return partial(self._step_series, heat)
        return partial(self._average_series, heat, [own.bring(heat.q0, heat.q1) for own in self.pieces])

    def _step_series(self, heat: HeatSeries, index: int, starts: Indices, x: Array) -> tuple[list[Array], Array]:
        s, step = self.course.segments[index], compile_means()
        assert step is not None
        (q0, q1, by), means = heat.within(s), []
        which = np.repeat(np.arange(len(starts)), np.diff(np.append(starts, s.last - s.first)))
        for f in self.factors[index]:
            out, end = np.zeros((len(starts), *x.shape)), x.copy()
            step(which, q0, q1, by, s.gain, s.c0, s.c1, f.E, f.F0, f.F1, end, out)
            means.append(out)
        return means, end

    def _average_series(
        self, heat: HeatSeries, brought: list[Array], index: int, starts: Indices, x: Array
    ) -> tuple[list[Array], Array]:
        s, means = self.course.segments[index], []
        for pieces, own in zip(self.pieces, brought, strict=True):
            mean, end = pieces.average_modes(index, s.modes, own, heat.by[s.index], x)
            means.append(mean)
        return means, end

    @cached_property
    def pieces(self) -> list[Pieces]:
        """For each set of samples: what the cells do to series."""
        segments = self.course.segments
        cells = [s.first + self.over.find_touched(s.first, s.last)[1] for s in segments]
        gain, c0, c1 = (np.concatenate(own) for own in zip(*((s.gain, s.c0, s.c1) for s in segments), strict=True))
        return [pieces_of(cells, gain, c0, c1, f.E, f.F0, f.F1) for f in self._whole_factors]

    def _follow_pushes(self, heat: HeatSeries) -> Modal:
        """For any pushes."""
        return partial(self._force_pushes, heat)

    def _force_pushes(self, heat: HeatSeries, index: int, starts: Indices, x: Array) -> tuple[list[Array], Array]:
        """From interval to interval."""
        s, factors = self.course.segments[index], self.factors[index]
        p0, p1 = heat.force_modes(s)
        m, end = s.march_forced(p0, p1, x)
        means = []
        for i, f in enumerate(factors):
            is_last = i == len(factors) - 1
            weighed = _scale(f.E, m, is_last)
            weighed += _scale(f.F0, p0, is_last)
            weighed += _scale(f.F1, p1, is_last)
            means.append(sum_rows(weighed, starts))
        return means, end

    def _direct(self, s: Segment, i: int, pushes: Sequence[Push], output_map: OutputMap, starts: Indices) -> Array:
        here, parts = slice(s.first, s.last), []
        left, right = self.over.left[i, here, None], self.over.right[i, here, None]
        for push in pushes:
            q = sum_rows(left * push.q0[here] + right * push.q1[here], starts)
            parts.append(q @ push.into(output_map.direct[s.index]))
        return np.stack(parts, axis=1)

    def _by_kicks(self, pushes: Sequence[Push], output_map: OutputMap) -> Array:
        kicks, by_regime = Kicks(self.course, pushes), self._rows(output_map)
        out = np.zeros((len(pushes), self.over.cells, output_map.count))
        x = np.zeros((len(pushes), self.course.problem.order))
        for s, factors in zip(self.course.segments, self.factors, strict=True):
            m, decays, rows = x @ s.modes.W.T, kicks.decays(s), by_regime[s.index]
            cells, starts = self.over.split(kicks.cuts(s))
            seen = np.empty((len(starts), output_map.count, m.shape[1]), np.result_type(rows, decays))
            for i, channels in self.over.groups():
                seen[:, channels] = sum_rows(factors[i].E * decays, starts)[:, None] * rows[channels]
            for a, b, states in kicks.pieces(s, m):
                first, last = starts.searchsorted((a - s.first, b - s.first)).tolist()
                read = np.real(states @ seen[first:last].reshape(-1, m.shape[1]).T)
                out[: len(states), cells[first] : cells[last - 1] + 1] += read.reshape(len(states), last - first, -1)
            x = np.real(m @ s.modes.V.T)
        return kicks.in_order(out).transpose(0, 2, 1)


def _as_slice(indices: list[int]) -> slice | list[int]:
    """A slice where indices follow each other, which is quicker."""
    follow = indices[-1] - indices[0] == len(indices) - 1
    return slice(indices[0], indices[-1] + 1) if follow else indices


def _scale(factor: Array, values: Array, in_place: bool) -> Array:
    return np.multiply(factor[:, None], values, out=values if in_place else None)


def _factors(samples: Samples, rates: Array, regime_of: Indices, steps: Array) -> Factors:
    """Those of all intervals, by the rates of their regimes (regimes, n)."""
    E, h, rates = samples.sum_decays(rates, regime_of), steps[:, None], rates[regime_of]
    w, first, *_ = samples.moments.T[:, :, None]
    fast = np.abs(rates) * h >= SLOW
    safe = np.where(fast, rates, 1.0)
    one = (w - E) / safe
    two = (first - one) / safe
    if not fast.all():
        k, j = np.nonzero(~fast)
        slow, (_, first, t2, t3, t4) = rates[k, j], samples.moments[k].T
        one[k, j] = first - slow * t2 / 2 + slow**2 * t3 / 6
        two[k, j] = t2 / 2 - slow * t3 / 6 + slow**2 * t4 / 24
    F1 = two / h
    return Factors(E, one - F1, F1)


def first_seen(course: LinearRun, pushes: Sequence[Push], output_map: OutputMap, first: int = 0) -> Array:
    """The outputs at the beginning of a run, whose first interval is given: (pushes, count)."""
    r, out = int(course.problem.regime_of[first]), np.zeros((len(pushes), output_map.count))
    for i, push in enumerate(pushes):
        for jump in (jump for k, jump in push.all_kicks if k == first):
            out[i] += output_map.over[r] @ jump
        if push.is_heat and output_map.sees_heat:
            out[i] += push.q0[first] @ push.into(output_map.direct[r])
    return out
