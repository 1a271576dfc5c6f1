"""Numbers of a machine file that a sweep varies: `path=lo..hi unit:N` or `path=a,b,c unit`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any, ClassVar

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.trajectory import axis_unit
from network.machine.machine import Machine
from network.machine.overrides import set_value
from network.platform.quantities.unit_values import in_difference_unit
from network.platform.quantities.units import NUMBER
from network.platform.refusal import Complaints, Refusal, Refused, Spot, refuse, short

MOST_RUNS = 10_000
MOST_TRIED = 50
"""Values of each number that are tried on the machine before the first run."""
_FORM = "write it like 'links.skin.conductance=3..9 W/K:20' or 'links.skin.conductance=3,5,9 W/K'"
_RANGE = re.compile(rf"({NUMBER})\s*\.\.\s*({NUMBER})([^:]*):\s*([0-9]+)")
_LIST = re.compile(rf"({NUMBER}(?:\s*,\s*{NUMBER})*)(.*)", re.DOTALL)


@dataclass(frozen=True)
class Variation:
    """A number of the machine file and the values it takes, in `unit` (empty for a bare number)."""

    path: str
    values: tuple[float, ...]
    unit: str

    def setting(self, value: float) -> str:
        """path=value, as `--set` takes it."""
        return f"{self.path}={value:.12g} {self.unit}".rstrip()

    def summary(self) -> dict[str, Any]:
        return {"path": self.path, "unit": self.unit or "1", "values": list(self.values)}


def parse_variation(text: str) -> Variation:
    """Raises Refused for what is of neither form."""
    path, _, wanted = (part.strip() for part in text.partition("="))
    spot = Spot(f"--vary {short(text)}")
    if not path or not wanted:
        raise refuse(spot, "is not path=values", _FORM)
    if match := _RANGE.fullmatch(wanted):
        low, high, count = float(match[1]), float(match[2]), int(match[4])
        if not low < high:
            raise refuse(spot, f"runs from {low:g} to {high:g}", "write the smaller value first")
        if not 2 <= count <= MOST_RUNS:
            raise refuse(spot, f"asks for {count} values", f"give 2 to {MOST_RUNS}")
        return Variation(path, tuple(np.linspace(low, high, count).tolist()), match[3].strip())
    if ".." in wanted:
        raise refuse(spot, "is a range without a number of values", _FORM)
    match = _LIST.fullmatch(wanted)
    if not match or ":" in match[2] or "," in match[2]:
        raise refuse(spot, f"'{short(wanted)}' is not values with a unit", _FORM)
    return Variation(path, tuple(float(value) for value in match[1].split(",")), match[2].strip())


def check_grid(machine: Machine, variations: Sequence[Variation]) -> None:
    """Raises Refused with every path that leads nowhere and every value that cannot be, or for too many runs."""
    complaints, spot = Complaints(), Spot("--vary")
    paths = [variation.path for variation in variations]
    for path in sorted({path for path in paths if paths.count(path) > 1}):
        complaints.refuse(spot, f"{path} is varied twice", "give its values in one --vary")
    if (runs := prod(len(variation.values) for variation in variations)) > MOST_RUNS:
        complaints.refuse(spot, f"makes {runs} runs", f"give fewer values: at most {MOST_RUNS} runs")
    complaints.raise_if_any()
    for variation in variations:
        faults = (_fault(machine, variation, value) for value in variation.values[:MOST_TRIED])
        complaints.refusals.extend(next(filter(None, faults), ()))
    complaints.raise_if_any()


def _fault(machine: Machine, variation: Variation, value: float) -> tuple[Refusal, ...]:
    """What is wrong with one value alone."""
    try:
        vary(machine, [variation], [value])
    except Refused as refused:
        spot = Spot(f"--vary {variation.path}")
        return tuple(replace(fault, spot=spot) for fault in refused.refusals)
    return ()


def vary(machine: Machine, variations: Sequence[Variation], values: Sequence[float]) -> Machine:
    """The machine with these values. Raises Refused."""
    tree = machine.tree
    for variation, value in zip(variations, values, strict=True):
        tree = set_value(tree, variation.setting(value))
    return Machine.read(tree, machine.file)


@dataclass(frozen=True)
class Extremes:
    """Of one TCP axis over a run, in its unit."""

    NUMBERS: ClassVar[tuple[str, ...]] = ("highest", "lowest", "final")

    highest: float
    lowest: float
    final: float
    unit: str

    @classmethod
    def of(cls, axis: str, values: Array) -> Extremes:
        shown = in_difference_unit(values, axis_unit(axis))
        return cls(float(shown.max()), float(shown.min()), float(shown[-1]), axis_unit(axis))

    @property
    def numbers(self) -> tuple[float, ...]:
        return tuple(getattr(self, name) for name in self.NUMBERS)

    def summary(self) -> dict[str, Any]:
        """As in summary.json."""
        return {"max": self.highest, "min": self.lowest, "final": self.final, "unit": self.unit}
