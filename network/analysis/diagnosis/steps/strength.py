"""How sure the size of a finding is."""

from __future__ import annotations

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.catalogue.declaration.declare import Array


def standard_errors(h: Hypothesis) -> Array:
    """1σ of the numbers of a hypothesis, by (SᵀS/χ² + V⁻¹)⁻¹: a misfit χ takes weight from the readings, and none from
    what was known before (uncertainty.py)."""
    now, stated = h.fit.problem.prior[1] ** -2.0, h.fit.problem.stated_prior[1] ** -2.0
    by_readings = np.linalg.inv(h.fit.covariance) - np.diag(now)
    covariance = np.linalg.inv(by_readings / max(1.0, h.chi) ** 2 + np.diag(stated))
    return np.asarray(np.sqrt(np.diag(covariance)))


def errors_from_nothing(gain: float, chi: float) -> float:
    """How many standard errors a finding is from not there: √(2 gain)/χ by the evidence [nats] that is lost without it,
    all other numbers fitted again, a misfit χ taken for noise. Signed root of the likelihood ratio, which unlike a
    number over its 1σ does not depend on how the number is written. Source: Pawitan, In All Likelihood (2001), ch. 9;
    unverified."""
    return float(np.sqrt(2 * max(gain, 0.0))) / max(1.0, chi)


def strength_in_errors(h: Hypothesis, c: Candidate) -> float:
    """How many of its standard errors the strength of a finding measures."""
    first = c.own[0]
    i = [p.path for p in h.fit.problem.parameters].index(first.path)
    value = float(h.fit.theta[i])
    std = first.std(value, float(standard_errors(h)[i]))
    return abs(first.value(value)) / std if std > 0 else np.inf
