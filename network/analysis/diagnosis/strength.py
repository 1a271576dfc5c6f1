"""How sure the size of a finding is."""

from __future__ import annotations

import numpy as np

from network.analysis.diagnosis.candidates import Candidate
from network.analysis.diagnosis.hypothesis import Hypothesis


def strength_in_errors(h: Hypothesis, c: Candidate) -> float:
    """How many standard errors the strength of a finding is from not there."""
    first = c.own[0]
    i = [p.path for p in h.fit.problem.parameters].index(first.path)
    spread = float(np.sqrt(h.fit.covariance[i, i])) * max(1.0, h.chi)
    value = float(h.fit.theta[i])
    std = first.std(value, spread)
    return abs(first.value(value)) / std if std > 0 else np.inf
