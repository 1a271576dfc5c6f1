"""What is kept of a fit that is only compared with others: its numbers, not the runs and slopes behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from network.analysis.calibration.linearised import Linearised
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis, reweight
from network.engine.response.parameters import Parameter
from network.platform.refusal import Failed


def compact(h: Hypothesis) -> Hypothesis:
    """The hypothesis without its runs; whoever needs these fits it again from its numbers."""
    return replace(h, fit=h.fit.estimate) if isinstance(h.fit, Linearised) else h


def expand(h: Hypothesis) -> Hypothesis:
    """The hypothesis with its runs again."""
    return h if isinstance(h.fit, Linearised) else reweight(h.case, h)


def fit_with(
    case: Case, current: Hypothesis, c: Candidate, start: Mapping[str, float], steps: int
) -> Hypothesis | None:  # fmt: skip
    """A candidate fitted beside what is there, a few steps from some numbers; None where it runs away."""
    return fit_or_none(case, (*current.found, c), (*current.own, *c.own), start, steps)


def fit_or_none(
    case: Case, found: Sequence[Candidate], own: Sequence[Parameter], start: Mapping[str, float], steps: int
) -> Hypothesis | None:  # fmt: skip
    """Findings, each laid over those before it, fitted a few steps from some numbers; None where they run away."""
    try:
        return fit_hypothesis(case, found[-1].machine, found, own, start, steps=steps)
    except (Failed, np.linalg.LinAlgError):
        return None
