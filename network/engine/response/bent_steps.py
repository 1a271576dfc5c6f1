"""A stretch of a bent course from interval to interval: what heat that follows readings makes of the modes.

With m the modes at the beginning of an interval, R what they show there and B what a reading brings as heat, they go
over into (m (Γ + R B₀ C₀) + a)(1 + R B₁ C₁), a what comes from outside: a recursion that is linear in m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.response.output_map import OutputMap
from network.engine.response.recursion import chain_blocks, recur_coupled
from network.engine.response.segments import Push, Segment

MIXED = 48
"""Modes up to which an interval is one matrix; of more, only what goes through the readings is worked out."""


@dataclass(frozen=True, eq=False)
class BentSteps:
    """What every interval of a stretch does to readings and to the heat of bends. read: readings by modes (n, r); gain:
    of the modes (k, n); begin, end: heats by readings there (k, r, series); by_begin, by_end: what these heats make of
    the modes (k, r, n)."""

    s: Segment
    output_map: OutputMap
    read: Array
    gain: Array
    begin: Array
    end: Array
    by_begin: Array
    by_end: Array

    @classmethod
    def of(cls, s: Segment, output_map: OutputMap, spread: Array, B0: Array, B1: Array) -> BentSteps:
        """spread: what each series brings into the lumps; B0, B1: series by readings just after and before the edges
        (k, series, r)."""
        read, into, (gain, c0, c1) = (output_map.over[s.index] @ s.modes.V).T, (s.heat @ spread.T).T, s.factors
        at_once = output_map.direct[s.index] @ spread.T
        one = np.eye(output_map.count)
        G = np.real(c1 @ _spread_pairs(read, into)).reshape(-1, read.shape[1], len(into)) + at_once
        before = np.linalg.inv(one - at_once @ B0) if at_once.any() else one
        after = np.linalg.inv(one - G @ B1)
        begin, end = ((B @ y).transpose(0, 2, 1) for B, y in ((B0, before), (B1, after)))
        by_begin, by_end = (_bring(heats, into, c) for heats, c in ((begin, c0), (end, c1)))
        return cls(s, output_map, read, gain, begin, end, by_begin, by_end)

    def along(self, pushes: Sequence[Push], m: Array, h0: Array, h1: Array) -> Array:
        """Fills the heats just after and before the edges (k, pushes, series); modal states after the last interval."""
        s, direct, (_, c0, c1) = self.s, self._direct(pushes), self.s.factors
        added, p1 = s.force_modes(pushes)
        added *= c0[:, None]
        p1 *= c1[:, None]
        added += p1
        if direct is not None:
            added += direct[0] @ self.by_begin
        before, end = self._follow(added, direct and direct[1], m, list(s.kicks(pushes)))
        y0 = self._see(before)
        left = self._pass(before, y0)
        left += added
        y1 = self._see(left)
        if direct is not None:
            y0, y1 = y0 + direct[0], y1 + direct[1]
        h0[:], h1[:] = y0 @ self.begin, y1 @ self.end
        return end

    def _see(self, modes: Array) -> Array:
        """What modes show (k, pushes, r), in one product."""
        return np.asarray((modes.reshape(-1, len(self.read)) @ self.read).real.reshape(*modes.shape[:2], -1))

    def _pass(self, before: Array, seen: Array) -> Array:
        """What is left of the modes at the ends of their intervals, with the heat that they bring at the beginnings."""
        left = self.gain[:, None] * before
        left += seen @ self.by_begin
        return left

    def _follow(
        self, added: Array, direct: Array | None, start: Array, kicks: Sequence[tuple[int, int, Array]]
    ) -> tuple[Array, Array]:
        """Modes at the beginnings of all intervals, kicks counted, and after the last (k, pushes, n)."""
        seen = self._see(added)
        push = (seen if direct is None else seen + direct) @ self.by_end
        push += added
        begun = start.copy()
        push[self._ends] = 0.0
        for k, i, jump in kicks:
            if k:
                push[k - 1, i] += jump
            else:
                begun[i] += jump
        if len(self.read) > MIXED:
            return self._step(push, begun)
        return recur_coupled(self._through, push, begun, self._chained)

    @property
    def _ends(self) -> Indices:
        """The last intervals of runs."""
        return np.empty(0, int) if self.s.ended is None else self.s.ended[0]

    @cached_property
    def _through(self) -> Array:
        """What every interval makes of the modes at its beginning (k, n, n)."""
        n = len(self.read)
        step = self.read @ self.by_begin
        step[:, np.arange(n), np.arange(n)] += self.gain
        through = step + (step @ self.read) @ self.by_end
        through[self._ends] = 0.0
        return np.asarray(through)

    @cached_property
    def _chained(self) -> tuple[Array, Array]:
        return chain_blocks(self._through)

    def _step(self, push: Array, x: Array) -> tuple[Array, Array]:
        """The recursion interval by interval, the modes kept apart but for what they show."""
        passes = np.ones(len(push))
        passes[self._ends] = 0.0
        for k, goes_on in enumerate(passes):
            now = self.gain[k] * x + (x @ self.read).real @ self.by_begin[k]
            now += (now @ self.read).real @ self.by_end[k]
            push[k], x = x, goes_on * now + push[k]
        return push, x

    def _direct(self, pushes: Sequence[Push]) -> tuple[Array, Array] | None:
        """What is seen at once of the pushes themselves (k, pushes, r), if anything is."""
        s, by = self.s, self.output_map.direct[self.s.index]
        if not self.output_map.sees_heat:
            return None
        sides = ([(q[s.first : s.last] @ p.into(by)) for p, q in zip(pushes, side, strict=True)]
                 for side in ([p.q0 for p in pushes], [p.q1 for p in pushes]))  # fmt: skip
        first, last = (np.stack(side, axis=1) for side in sides)
        return first, last


def _spread_pairs(read: Array, into: Array) -> Array:
    """What heat of a series shows by each mode, for every pair of a reading and a series (n, r series): one product
    with the factors of all intervals takes the place of one each."""
    return (read[:, :, None] * into.T[:, None, :]).reshape(len(read), -1)


def _bring(heats: Array, into: Array, factor: Array) -> Array:
    """What heats by readings (k, r, series) make of the modes (k, r, n)."""
    modes = (np.ascontiguousarray(heats).reshape(-1, len(into)) @ into).reshape(*heats.shape[:2], -1)
    return np.asarray(np.multiply(modes, factor[:, None], out=modes if modes.dtype == factor.dtype else None))
