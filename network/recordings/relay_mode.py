"""Whether a relay was on, where readings of what it watches tell."""

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

    def shift(self, later: Array) -> RelayMode:
        """With instants that are later by so much [s]; those that pass each other go."""
        at = np.clip(self.t[1:] + later, self.t[0], None)
        step = np.where(np.arange(len(at)) % 2 == 0, 1, -1) * (1 if self.first == 0 else -1)
        order = np.argsort(at, kind="stable")
        on = np.concatenate([[self.first > 0], self.first + np.cumsum(step[order]) > 0])
        kept = (np.diff(on.astype(int)) != 0) & (at[order] > self.t[0])
        return RelayMode(self.name, np.concatenate([self.t[:1], at[order][kept]]), self.spread[order][kept], self.first)
