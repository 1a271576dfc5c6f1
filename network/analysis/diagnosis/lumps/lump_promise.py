"""Whether finer lumps promise to explain more, before a fit is made on them.

What channels have more on finer lumps at some numbers, y_fine(θ) − y_coarse(θ), is taken from what was measured, and
the coarse machine is fitted to the rest (coarse_surrogate.py), from the numbers at hand and from those of the file. A
fit on the finer lumps comes to about as much. Where something else is missing numbers are bent to it with the profiles
of coarse lumps, and finer ones tell less.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from network.analysis.diagnosis.hypotheses.few_runs import on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis, theta_of
from network.analysis.diagnosis.lumps.additive_correction import AdditiveCorrection
from network.analysis.diagnosis.settings import SETTINGS
from network.engine.response.model import Model
from network.engine.response.parameters import centres, values_at
from network.machine.machine import Machine
from network.platform.refusal import Failed

STEPS = 8
"""Of such a fit."""


def promises_more(h: Hypothesis, finer: Machine) -> bool:
    """Whether a machine with finer lumps may explain more than a hypothesis without findings; also where its runs break
    down, which tells nothing. Where relays switch out of step no misfit is to be believed to that: only what stays
    far behind is left out."""
    few = on_few_runs(h)
    parameters = few.fit.problem.parameters
    runs = False
    for values in (few.values, values_at(parameters, centres(parameters))):
        if (other := _fit_rest(few, finer, values)) is not None:
            if _is_near(few, other):
                return True
            runs = True
    return not runs


def _is_near(h: Hypothesis, other: Hypothesis) -> bool:
    """Whether a fit to the rest promises that."""
    if h.fit.problem.model.switches:
        return other.chi < SETTINGS.hopeless * h.chi
    return other.evidence > h.evidence + SETTINGS.structure


def _fit_rest(h: Hypothesis, finer: Machine, values: Mapping[str, float]) -> Hypothesis | None:
    """The hypothesis fitted from some numbers to what was measured less what finer lumps have more there; None where
    that breaks down."""
    problem = h.fit.problem
    theta, runs = theta_of(problem.parameters, values), [d.run for d in problem.data]
    try:
        here, there = (Model(m, problem.parameters, runs).predict(theta) for m in (h.machine, finer))
        pairs = zip(problem.data, here, there, strict=True)
        lack = tuple(AdditiveCorrection.of(d, fine.cells - coarse.cells) for d, coarse, fine in pairs)
        return fit_hypothesis(replace(h.case, lacking=lack), h.machine, start=values, steps=STEPS)
    except (Failed, np.linalg.LinAlgError):
        return None
