"""Tolerances of the tool centre point, as a user gives them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from network.engine.trajectory import axis_unit
from network.machine.machine import Machine
from network.platform.quantities.units import BadNumber, Unit, split_number, unit
from network.platform.refusal import Spot, refuse, short


@dataclass(frozen=True)
class Tolerance:
    """How far from the finest level the tool centre point may be, in SI."""

    value: float
    unit: Unit

    @property
    def text(self) -> str:
        return f"{self.unit.from_si(self.value):.4g} {self.unit.text}"

    def summary(self) -> dict[str, Any]:
        return {"value": self.unit.from_si(self.value), "unit": self.unit.text}

    def concerns(self, axis: str) -> bool:
        return unit(axis_unit(axis)).dimension == self.unit.dimension


def parse_tolerance(text: str, machine: Machine) -> Tolerance:
    """A displacement like '1 um', or an angle for a machine that only turns. Raises Refused."""
    spot = Spot(f"--tolerance {short(text)}")
    try:
        number, unit_text = split_number(text, "um")
        given = unit(unit_text)
    except BadNumber as error:
        raise refuse(spot, error.wrong, error.right) from None
    result = Tolerance(given.to_si(number), given)
    if not unit_text:
        raise refuse(spot, "has no unit", f"write it like '{number:g} um'")
    if not any(result.concerns(axis) for axis in machine.tcp):
        wanted = " or ".join(sorted({axis_unit(axis) for axis in machine.tcp}))
        raise refuse(spot, "is no movement of this machine's tool centre point", f"give it in {wanted}")
    if not result.value > 0:
        raise refuse(spot, "is not above zero", "give a tolerance above zero")
    return result
