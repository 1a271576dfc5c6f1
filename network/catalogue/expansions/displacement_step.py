from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import instant, param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.expansions.base import LINEAR_AXES, Expansion, Reading
from network.catalogue.mechanisms.mechanism import Inputs

SAME_INSTANT = 1e-6
"""s: a sample this close before the jump lies on it."""


class DisplacementStep(Expansion, kind="displacement_step"):
    """The tool centre point jumps at an instant and stays there: δ = d for t ≥ begins, else 0; t the time of the run.

    A probe that was knocked, a joint that slips, a clamp that lets go. No heat and no memory: neither temperatures nor
    speed foretell it. A fit finds `size` by slopes; `begins` has none, for the reading jumps at it: the search
    without gradients finds it. Beginning with the run it is an offset, which a probe that is zeroed does not show.
    """

    axes = LINEAR_AXES
    shows_in_readings = True
    size = param("um", 0, 10_000, "how far it jumps", typical=5)
    begins = instant(0, 1e6, "when it jumps", typical=60)
    strength = "size"
    searched = False
    """By no slope: its instant shows in the readings."""
    sentence = "the tool centre point jumps along {way} by {size} at {begins}"

    def readings(self) -> tuple[Reading, ...]:
        return ()

    def movement(self, u: Inputs, *readings: Array) -> Array:
        jumped = np.real(u["time"]) + SAME_INSTANT >= np.real(self.begins)
        d: Array = self.direction * self.size * jumped
        return d

    @classmethod
    def subjects(cls, machine: MachineLike, axis: str) -> Iterator[tuple[str, dict[str, Any]]]:
        yield "", {}
