from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Self

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import param, word
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.expansions.base import choose
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.sensors.base import SensorEffect
from network.platform.wording import join_names


class ClockShift(SensorEffect, kind="clock_shift"):
    """A channel whose clock runs beside that of the inputs: reading(t) = truth(t − late).

    Two loggers that were started by hand, a displacement that is written down after it was averaged. Late is above
    zero; `with: dz` takes the number of another channel of the same logger. Straight between the instants that are
    computed; before the first it reads what was there at the start, and an early channel (late < 0) keeps its last
    value over the end. A lag rounds what a shift only moves. Between jumps of the inputs a fit finds `late` by slopes,
    and so does a diagnosis; not from more than half the time between two jumps away. Of an early channel what a run
    starts from is not known either, and it is told too small.
    """

    late = param("s", -36_000, 36_000, "how much later than the inputs its clock says", default=None, typical=60)
    logger = word("a channel of the same logger, whose shift it takes", default=None, key="with")
    one_of = (("late",), ("logger",))
    taken: Array | None = None
    looks_back = True
    strength = "late"
    is_steady = False
    sentence = "the clock of {channel} is {much} late against that of the inputs"

    @property
    def much(self) -> str:
        """By how much, in words."""
        return str(self.fields["late"].tell(self.late)) if self.late is not None else f"as much as {self.logger}"

    @property
    def follows(self) -> str:
        return str(self.logger or "")

    def take(self, other: Self) -> Self:
        return self.replaced(taken=other.late)

    def reading(self, truth: Array, state: Array, u: Inputs) -> Array:
        t = np.real(u["time"]) * np.ones(np.shape(truth))
        if not t.ndim:
            return truth
        late = choose(self.late, self.taken)
        order = np.argsort(t, kind="stable")
        return np.asarray(np.interp(t - late, t[order], truth[order]))

    @classmethod
    def proposes(cls, machine: MachineLike) -> Iterator[Mapping[str, Any]]:
        """On all channels that run on no clock of their own yet, as of one logger, and on those of one quantity."""
        free = {n: s for n, s in machine.sensors.items() if not any(e.kind == cls.kind for e in s.effects)}
        alike = [tuple(n for n, s in free.items() if s.quantity == q) for q in {s.quantity: 0 for s in free.values()}]
        for *others, own in filter(None, dict.fromkeys([tuple(free), *alike])):
            yield {"sensors": {**{n: cls.put_on(free[n], {"kind": cls.kind, "with": own}) for n in others},
                               own: cls.put_on(free[own], cls.typical_on(machine))}}  # fmt: skip

    @classmethod
    def told(cls, machine: MachineLike, patch: Mapping[str, Any]) -> str:
        entry = machine.by_path[cls.path_to(cls.strength, patch).entry]
        assert isinstance(entry, cls)
        return entry.said(channel=join_names([*patch["sensors"]]))
