"""Whether a relay was on, as readings of what it watches, or all readings together, tell."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array
from network.recordings.inputs import Signal, hold


@dataclass(frozen=True, eq=False)
class RelayMode:
    """t: start of the run, then the instants at which it switched [s]; spread: 1σ of these [s]; first: whether it is on
    (1) or off (0) at the start."""

    name: str
    t: Array
    spread: Array
    first: float

    @cached_property
    def signal(self) -> Signal:
        """1 while it is on, 0 while off."""
        return hold(self.name, "1", self.t, np.where(np.arange(len(self.t)) % 2 == 0, self.first, 1 - self.first))

    def until(self, end: float) -> RelayMode:
        """What comes before an instant."""
        kept = self.t < end
        return RelayMode(self.name, self.t[kept], self.spread[kept[1:]], self.first)

    def shift(self, later: Array, end: float) -> RelayMode:
        """With instants that are later by so much [s]; those that pass each other, the start or the end go."""
        at = self.t[1:] + later
        order = np.argsort(at, kind="stable")
        step = np.where(np.arange(len(at)) % 2 == 0, 1, -1) * (1 if self.first == 0 else -1)
        at, on = at[order], np.concatenate([[self.first], self.first + np.cumsum(step[order])]) > 0
        kept = (np.diff(on.astype(int)) != 0) & (at > self.t[0]) & (at < end)
        first = float(on[np.searchsorted(at, self.t[0], side="right")])
        return RelayMode(self.name, np.concatenate([self.t[:1], at[kept]]), self.spread[order][kept], first)
