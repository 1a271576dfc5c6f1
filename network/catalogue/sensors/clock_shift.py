from __future__ import annotations

from typing import Self

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, word
from network.catalogue.expansions.base import choose
from network.catalogue.mechanisms.base import Inputs
from network.catalogue.sensors.base import SensorEffect


class ClockShift(SensorEffect, kind="clock_shift"):
    """A channel whose clock runs beside that of the inputs: reading(t) = truth(t − late).

    Two loggers that were started by hand, a displacement that is written down after it was averaged. Late is above
    zero; `with: dz` takes the number of another channel of the same logger. Straight between the instants that are
    computed; before the first it reads what was there at the start, and an early channel (late < 0) keeps its last
    value over the end. A lag rounds what a shift only moves. Between jumps of the inputs a fit finds `late` by slopes;
    from more than half the time between two jumps away only a search without gradients does.
    """

    late = param("s", -36_000, 36_000, "how much later than the inputs its clock says", default=None, typical=60)
    logger = word("a channel of the same logger, whose shift it takes", default=None, key="with")
    one_of = (("late",), ("logger",))
    taken: Array | None = None
    looks_back = True
    strength = "late"
    sentence = "{channel} is {much} late against the inputs"

    @property
    def much(self) -> str:
        """By how much, in words."""
        return str(self.fields["late"].tell(self.late)) if self.late is not None else f"as much as {self.logger}"

    @property
    def follows(self) -> str:
        return str(self.logger or "")

    def take(self, other: Self) -> Self:
        return self.replaced(taken=other.late)

    def is_steady(self) -> bool:
        return False

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        t = np.real(u["time"]) * np.ones(np.shape(truth))
        if not t.ndim:
            return truth
        late = choose(self.late, self.taken)
        order = np.argsort(t, kind="stable")
        return np.asarray(np.interp(t - late, t[order], truth[order]))

    @classmethod
    def is_searched(cls) -> bool:
        """Not yet: it takes every channel along, which no quick look shows."""
        return False
