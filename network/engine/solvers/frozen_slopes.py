"""Steps on the slopes of an earlier step, for intervals that are short beside what bends in them.

Recorded inputs change at every sample, so that no step goes beyond one. There the rates about (t, x) are taken as

    f(s, y) ≈ f(t, x) + J (y − x) + (s − t) (f(t + h, x) − f(t, x))/h,

J from an earlier step. What the laws bend, in temperatures and inputs, and J has changed since, is told by the true
rates in the middle and at the end: defects d₁ and d₂, of mean (4 d₁ + d₂)/6 by Simpson's rule. To the state they do
(2 M/h − J)⁻¹ (4 d₁ + d₂)/3, M the capacities: right for slow states and, where defects grow evenly, for massless ones.
The state is corrected by that, and where it is more than the tolerance, a step is made as usual, and its slopes are
those of the next. It takes four rates a step instead of seven and slopes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.solvers import rodas
from network.engine.solvers.slope_layout import Dense, Solve

MOST_SKIPPED = 64
"""Steps after which it is tried again, where it failed time and again."""
Made = tuple[Array, rodas.Bend, float]
"""The state after a step, the vectors of its dense output, and its error over the tolerance."""


@dataclass
class FrozenSlopes:
    """Of a run whose Jacobian is dense. slopes: of the last step that was made as usual; solves: by 2 M/h − J, of the
    length h of a step; skipped, wait: steps since the last try, and for how many none is made."""

    rate: Callable[[float, Array], Array]
    mass: Array
    layout: Dense
    slopes: Array | None = None
    solves: dict[float, Solve] = field(default_factory=dict)
    skipped: int = 0
    wait: int = 0

    def renew(self, slopes: Array) -> None:
        """The slopes of a step that was made as usual."""
        self.slopes, self.solves = slopes, {}

    def step(self, t: float, x: Array, h: float, rate: Array, tolerance: float) -> Made | None:
        """A step over h; None where its error is more than the tolerance, or none was tried."""
        if self.slopes is None or self.skipped < self.wait:
            self.skipped += 1
            return None
        made = self._make(self.slopes, t, x, h, rate, tolerance)
        is_good, self.skipped = made[2] <= 1, 0
        self.wait = 0 if is_good else min(max(1, 2 * self.wait), MOST_SKIPPED)
        return made if is_good else None

    def _make(self, slopes: Array, t: float, x: Array, h: float, rate: Array, tolerance: float) -> Made:
        matrix = slopes.reshape(len(x), len(x)).T
        drift = (self.rate(t + h, x) - rate) / h

        def straight(s: float, y: Array) -> Array:
            return np.asarray(rate + matrix @ (y - x) + (s - t) * drift)

        end, bend, error = rodas.step(straight, self.mass, self.layout, t, x, h, rate, slopes, drift)
        middle, half = rodas.between(np.array(0.5), x, end, bend), t + h / 2
        defects = [self.rate(s, y) - straight(s, y) for s, y in ((half, middle), (t + h, end))]
        correction = self._solve(h)((4 * defects[0] + defects[1]) / 3)
        size = rodas.size_error(np.abs(error) + np.abs(correction), x, end, tolerance)
        return end + correction, bend, size if np.isfinite(size) else np.inf

    def _solve(self, h: float) -> Solve:
        assert self.slopes is not None
        if h not in self.solves:
            self.solves = {h: self.layout.factorise(2 * self.mass / h, self.slopes)}
        return self.solves[h]
