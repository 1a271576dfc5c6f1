"""What is kept of a fit that is only compared with others: its numbers, not the runs and slopes behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from network.calibration.parameters import Parameter
from network.calibration.predictor import Model
from network.diagnosis.candidates import Candidate
from network.diagnosis.case import Case, Hypothesis, suppose
from network.refusal import Failed

FIT = ("eta", "left", "cost", "misfit", "precision", "covariance", "folded", "_solved")
OWN = ("chi", "evidence", "shift", "strain", "values")


def slim(h: Hypothesis) -> Hypothesis:
    """The hypothesis without its runs; whoever needs these fits it again from its numbers."""
    fit, own = ({n: getattr(of, n) for n in names} for of, names in ((h.fit, FIT), (h, OWN)))
    problem = h.fit.problem
    problem = replace(problem, model=Model(problem.model.machine, problem.parameters, problem.model.runs))
    kept = replace(h, fit=replace(h.fit, problem=problem, predictions=(), parts=(), residual=h.fit.residual[:0]))
    kept.fit.__dict__.update(fit)
    kept.__dict__.update(own)
    return kept


def beside(
    case: Case, current: Hypothesis, c: Candidate, start: Mapping[str, float], steps: int
) -> Hypothesis | None:  # fmt: skip
    """A candidate fitted beside what is there, a few steps from some numbers; None where it runs away."""
    return tried(case, (*current.found, c), (*current.own, *c.own), start, steps)


def tried(
    case: Case, found: Sequence[Candidate], own: Sequence[Parameter], start: Mapping[str, float], steps: int
) -> Hypothesis | None:  # fmt: skip
    """Findings, each laid over those before it, fitted a few steps from some numbers; None where they run away."""
    try:
        return slim(suppose(case, found[-1].machine, found, own, start, steps=steps))
    except (Failed, np.linalg.LinAlgError):
        return None
