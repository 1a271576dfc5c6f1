from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import channel, param
from network.catalogue.declaration.machine_protocol import MachineLike
from network.catalogue.expansions.base import Expansion, Reading
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.typical_values import SPEED, name_input, usual_input, usual_speed


class CentrifugalGrowth(Expansion, kind="centrifugal_growth"):
    """A turning shaft moves at once with the square of its speed: δ = d (n/n_ref)², d the displacement at n_ref.

    Centrifugal load is ρ ω² r; an elastic shaft widens and, by its Poisson ratio, shortens in proportion, and balls
    pressed outward shift a preloaded shaft along its axis. No heat and no delay: that tells it from a thermal drift.
    """

    displacement = param("um", 0, 1000, "displacement at the reference speed", typical=10)
    reference_speed = param("rpm", 0, 300_000, "speed at which it is given", positive=True, typical=10_000)
    input = channel("speed", "rpm")
    strength = "displacement"
    sentence = "the shaft moves the tool centre point along {way} by {displacement} at {reference_speed}"

    def readings(self) -> tuple[Reading, ...]:
        return ()

    def movement(self, u: Inputs, *readings: Array) -> Array:
        d: Array = self.direction * self.displacement * (u[self.input] / self.reference_speed) ** 2
        return d

    @classmethod
    def subjects(cls, machine: MachineLike, axis: str) -> Iterator[tuple[str, dict[str, Any]]]:
        if name_input(SPEED, machine) is not None:
            yield "", {**usual_speed(machine), **usual_input(cls, machine)}
