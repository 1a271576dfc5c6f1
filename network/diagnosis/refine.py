"""Structure before physics: more lumps where that mends the misfit, until the answer stops changing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from network.diagnosis.candidates import Candidate, candidates
from network.diagnosis.case import Case, Hypothesis, suppose
from network.machine import Machine

LEVELS = 3
"""Times that lumps are refined."""
GAIN = 20.0
"""Log evidence that a finer structure must add to be looked at further."""
ENOUGH = 1.02
"""Misfit χ at which it is fine enough."""
FAR = 1.6
"""Misfit χ that lumps alone will not mend: what is missing is looked for first, and the lumps again with it."""
FINEST = 400
"""Lumps beyond which a machine is not refined."""


def finer(machine: Machine) -> Mapping[str, Any] | None:
    """One patch of all structural proposals, which a refinement may repeat; None where there is none."""
    merged: dict[str, dict[str, Any]] = {}
    for c in structural(machine):
        for section, entries in c.patch.items():
            merged.setdefault(section, {}).update(entries)
    return merged or None


def structural(machine: Machine) -> list[Candidate]:
    return list(candidates(machine, machine.inputs, structural=True))


def refined(case: Case, written: Hypothesis) -> list[Hypothesis]:
    """The machine as written, then ever finer ones while that helps."""
    levels, machine = [written], written.machine
    for _ in range(LEVELS):
        if levels[-1].chi < ENOUGH or (patch := finer(machine)) is None:
            break
        machine = machine.patched(patch)
        best = max(levels, key=lambda h: h.evidence)
        finer_one = suppose(case, machine, start=best.values if best is not written else None)
        levels.append(finer_one)
        if finer_one.evidence < best.evidence + GAIN or finer_one.chi > FAR:
            break
    return levels
