"""Series of heat that pushes bring, side by side, and how they go into the modes of every regime of a course."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.linear_run import LinearRun
from network.engine.response.segments import Push, Segment


@dataclass(frozen=True, eq=False)
class HeatSeries:
    """q0, q1 [W]: series just after and just before the edges of the intervals (K, series); by: regime → modes by
    series (series, n); first: the first series of every push."""

    q0: Array
    q1: Array
    by: dict[int, Array]
    first: list[int]

    @classmethod
    def of(cls, pushes: Sequence[Push], course: LinearRun) -> HeatSeries:
        heat = {s.index: s.heat for s in course.segments}
        by = {r: np.concatenate([push.into(own) for push in pushes]) for r, own in heat.items()}
        first = np.cumsum([0, *(push.series for push in pushes[:-1])]).tolist()
        return cls(np.hstack([push.q0 for push in pushes]), np.hstack([push.q1 for push in pushes]), by, first)

    def within(self, s: Segment) -> tuple[Array, Array, Array]:
        """Those of a stretch, and how they go into its modes."""
        return self.q0[s.first : s.last], self.q1[s.first : s.last], self.by[s.index]

    def force_modes(self, s: Segment) -> tuple[Array, Array]:
        """Forcings of the modes of a stretch at both ends of every interval: (k, pushes, n) each."""
        q0, q1, by = self.within(s)
        shape = len(q0), len(self.first), by.shape[1]
        first, last = np.empty(shape, by.dtype), np.empty(shape, by.dtype)
        for i, (a, b) in enumerate(zip(self.first, [*self.first[1:], len(by)], strict=True)):
            if b - a == 1:
                np.multiply(q0[:, a:b], by[a:b], out=first[:, i])
                np.multiply(q1[:, a:b], by[a:b], out=last[:, i])
            else:
                first[:, i], last[:, i] = q0[:, a:b] @ by[a:b], q1[:, a:b] @ by[a:b]
        return first, last
