"""The finding that a part needs more lumps: which parts, and what their finer structure changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from network.analysis.diagnosis.candidates.candidate_response import respond_to_candidates
from network.analysis.diagnosis.findings.finding import Finding
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings
from network.analysis.diagnosis.lumps.lump_refinement import list_structural
from network.analysis.diagnosis.screening.screen import whiten
from network.analysis.diagnosis.steps.refit import linearise_at_priors
from network.analysis.diagnosis.time_budget import TimeBudget
from network.catalogue.declaration.patch import Patch
from network.machine.machine import Machine
from network.platform.wording import sentence

SURE = 0.95
STEPS = 8
"""Of what was found on the lumps of the file."""
CLEAR = 0.3
"""Share of the largest change that makes a part one of those meant."""


def gain_of_lumps(written: Hypothesis, null: Hypothesis, best: Hypothesis) -> float:
    """Evidence that finer lumps add [nats]: to the machine as written or, where the null was left on its lumps, to what
    was found beside it; none where that does not fit there."""
    if null.machine.lumps > written.machine.lumps or best.root.lumps <= written.machine.lumps:
        return null.evidence - written.evidence
    case = replace(best.case, budget=TimeBudget())
    coarse = fit_findings(case, written.machine, best.found, best.values, steps=STEPS)
    return best.evidence - coarse.evidence if coarse else 0.0


def find_lumping(written: Hypothesis, now: Machine, gain: float, threshold: float) -> Finding | None:
    """The finding for a machine that was refined, with the evidence that gained; None where nothing changes."""
    fit = linearise_at_priors(written.fit)
    if fit is None:
        return None
    able = [c for c in list_structural(written.machine) if c.places]
    moved = respond_to_candidates([(c, {}) for c in able], fit.problem.data, fit.predictions)
    changes = {c: float(np.linalg.norm(whiten(fit, d))) for c, d in zip(able, moved, strict=True) if d is not None}
    if not changes:
        return None
    largest = max(changes.values())
    meant = sorted((c for c, size in changes.items() if size > CLEAR * largest), key=lambda c: -changes[c])
    first = meant[0]
    places = tuple(dict.fromkeys(n for c in meant for n in c.places))
    tree = now.to_plain()["nodes"]
    nodes = {name: tree[name] for name in now.nodes if tree.get(name) != written.machine.to_plain()["nodes"].get(name)}
    said = sentence("; ".join(first.kind.told(now, c.patch) for c in meant)) + "."
    return Finding(first.kind.kind, first.section, places, (), SURE, {}, said, Patch({"nodes": nodes}), gain, threshold)
