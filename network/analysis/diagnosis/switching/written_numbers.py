"""Numbers of a fit written into a machine as if its file had them, so that they outlive what is laid over it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.engine.response.parameters import Parameter
from network.machine.machine import Machine
from network.platform.quantities.units import show
from network.platform.refusal import Refused

DIGITS = 17
"""Of numbers that are read again: none is lost."""


def write_numbers(machine: Machine, own: Sequence[Parameter], values: Mapping[str, float]) -> Machine:
    """The machine with those of some numbers (own) for which there is a value by their path. Raises Refused where one
    may not be so."""
    numbers = {p.path: show(values[p.path], p.field.unit, DIGITS) for p in own if p.path in values}
    return machine.patched(numbers) if numbers else machine


def write_or_leave(machine: Machine, own: Sequence[Parameter], values: Mapping[str, float]) -> Machine:
    """The same; the machine as it is where a file may not have them."""
    try:
        return write_numbers(machine, own, values)
    except Refused:
        return machine


def write_own(h: Hypothesis) -> Machine:
    """The machine of a hypothesis with the numbers of what was found in it, or as it is."""
    return write_or_leave(h.machine, h.own, h.values)
