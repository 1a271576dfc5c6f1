"""All the heat that a part lacks where what was found there is a part of it.

What a name takes of it and what it leaves are told apart by the form of a law that is not exactly that of the truth;
what both come to is not. It is the heat of any course that the part needs at the numbers that stand beside what was
found, once that is taken out.
"""

from __future__ import annotations

from dataclasses import replace

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings
from network.analysis.diagnosis.latent_heat.latent_rest import find_rest_at
from network.analysis.diagnosis.latent_heat.locate import trace
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.time_budget import TimeBudget
from network.catalogue.declaration.sections import TCP


def trace_lacking(h: Hypothesis, of: UnknownHeat) -> UnknownHeat | None:
    """Its course in every run, with its 1σ, where unknown heat sits in one part; None where nothing was found in that
    part alone, or the machine does not run without it. It is told however much time is left: it takes one run of each
    recording."""
    others = [c for c in h.found if c.parts != {*of.at.nodes} or c.section == TCP]
    if of.at.kind != "node" or len(others) == len(h.found):
        return None
    bare = fit_findings(replace(h.case, budget=TimeBudget()), h.root, others, h.values, steps=0)
    return None if bare is None else trace(bare.linearised, of, find_rest_at(bare, of).left)
