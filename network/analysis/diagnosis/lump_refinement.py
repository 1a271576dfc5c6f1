"""Structure before physics: more lumps where that mends the misfit, until the answer stops changing."""

from __future__ import annotations

from collections.abc import Iterator

from network.analysis.diagnosis.candidates import Candidate, candidates
from network.analysis.diagnosis.hypothesis import Case, Hypothesis, fit_hypothesis
from network.analysis.diagnosis.settings import SETTINGS
from network.catalogue.declaration.patch import Patch
from network.machine.machine import Machine

LEVELS = 3
"""Times that lumps are refined."""
FINEST = 400
"""Lumps beyond which a machine is not refined."""


def list_finer_machines(machine: Machine, most: int | None = None) -> Iterator[Machine]:
    """The machine with all structural proposals laid over it, and again over that, to so many lumps."""
    for _ in range(LEVELS):
        patch = Patch.of(entry for c in list_structural(machine) for entry in c.patch.by_name())
        if not patch:
            return
        machine = machine.patched(patch)
        if most is not None and machine.lumps > most:
            return
        yield machine


def list_structural(machine: Machine) -> list[Candidate]:
    return list(candidates(machine, machine.inputs, structural=True))


def refine_lumps(case: Case, written: Hypothesis) -> list[Hypothesis]:
    """The machine as written, then ever finer ones while that helps."""
    levels = [written]
    for machine in list_finer_machines(written.machine):
        if levels[-1].chi < SETTINGS.noise:
            break
        best = max(levels, key=lambda h: h.evidence)
        finer_one = fit_hypothesis(case, machine, start=best.values if best is not written else None)
        levels.append(finer_one)
        if finer_one.evidence < best.evidence + SETTINGS.structure or finer_one.chi > SETTINGS.doubtful:
            break
    return levels
