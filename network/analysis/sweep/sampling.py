"""Numbers of a machine drawn at random: those with ± from their priors, or given ones from ranges; Latin hypercubes.

Each number's distribution is cut into as many equally likely pieces as there are runs, and every piece is drawn from
once, in an order of its own (McKay, Beckman & Conover, Technometrics 21 (1979) 239).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import NumberPath
from network.engine.response.parameters import Parameter, free_parameters, parameter
from network.machine.machine import Machine
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import NUMBER, BadNumber, Number, unit, unit_of_output
from network.platform.refusal import Spot, likely, refuse, short

MOST_SAMPLES = 1_000_000
_RANGE = re.compile(rf"({NUMBER})\s*\.\.\s*({NUMBER})(.*)", re.DOTALL)
_FORM = "write it like 'links.skin.conductance=3..9 W/K'"


@dataclass(frozen=True)
class Drawn:
    """A number that is drawn: by its prior, or evenly between two values [SI]."""

    parameter: Parameter
    ends: tuple[float, float] | None = None

    @property
    def path(self) -> str:
        return self.parameter.path

    @property
    def unit(self) -> str:
        return self.parameter.field.unit

    def at(self, quantiles: Array) -> Array:
        """Values at quantiles from 0 to 1 [SI]."""
        from scipy.special import ndtri

        p = self.parameter
        if self.ends is not None:
            return np.asarray(self.ends[0] + quantiles * (self.ends[1] - self.ends[0]))
        flat = p.low + quantiles * (p.high - p.low)
        theta = flat if p.is_unknown else np.clip(p.centre + p.spread * ndtri(quantiles), p.low, p.high)
        return np.asarray(np.exp(theta) if p.is_log else theta)

    def shown(self, values: Array) -> Array:
        """Values [SI] in the unit of the number."""
        return in_own_unit(values, unit_of_output(self.unit))

    def summary(self) -> dict[str, Any]:
        prior = "uniform" if self.ends is not None or self.parameter.is_unknown else "normal"
        return {"path": self.path, "unit": self.unit or "1", "prior": prior,
                "in_logarithm": self.parameter.is_log and self.ends is None}  # fmt: skip


def choose_drawn(machine: Machine, vary: Sequence[str]) -> tuple[Drawn, ...]:
    """The numbers with ± of the file, or those of some ranges. Raises Refused where there are none."""
    if vary:
        return tuple(_read_range(machine, text) for text in vary)
    found = tuple(Drawn(p) for p in free_parameters(machine) if p.entry.section != "sensors")
    if not found:
        right = "write a ± behind some numbers of the file, or give ranges with --vary"
        raise refuse(Spot("--sample"), "no number of the machine has a ±, so that nothing can be drawn", right)
    return found


def _read_range(machine: Machine, text: str) -> Drawn:
    path, _, wanted = (part.strip() for part in text.partition("="))
    spot, match = Spot(f"--vary {short(text)}"), _RANGE.fullmatch(wanted)
    if not match or ":" in match[3]:
        raise refuse(spot, "is no range to draw from", _FORM)
    number = NumberPath.parse(path, machine.paths)
    if number is None:
        raise refuse(spot, f"there is no number '{short(path)}'", likely(path, machine.uncertain))
    found = parameter(machine, number, Number(1.0))
    try:
        given = unit(match[3].strip())
    except BadNumber as bad:
        raise refuse(spot, bad.wrong, bad.right) from None
    low, high = (given.to_si(float(value)) for value in match.groups()[:2])
    if given.dimension != unit(found.field.unit).dimension:
        raise refuse(spot, f"is in {given.text}", f"give it in a unit like {found.field.unit or '1'}")
    if not (found.field.low <= low < high <= found.field.high):
        raise refuse(spot, f"runs from {match[1]} to {match[2]}", f"smaller end first, from {found.field.range}")
    return Drawn(found, (low, high))


def latin_hypercube(count: int, width: int, seed: int) -> Array:
    """Quantiles (count, width): of every column one in each of `count` equal pieces."""
    draw = np.random.default_rng(seed)
    order = np.stack([draw.permutation(count) for _ in range(width)], axis=1)
    return np.asarray((order + draw.uniform(size=(count, width))) / count)
