"""A fit that leaves much, made again from other numbers: it may be held up on the way to better ones."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from network.analysis.calibration.gauss_newton import STEPS
from network.analysis.diagnosis.hypotheses.falling_short import FallsShort
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import best_of
from network.platform.refusal import Failed

KICKS = (3 / 4, 4 / 3)
"""Times the strength from which it is fitted again."""


def fit_afresh(best: Hypothesis) -> Hypothesis:
    """What leaves much, fitted from the numbers of the file, too, for those at hand were bent for want of it, and with
    its strength larger and smaller, for a fit may be held up on the way there."""
    if best.chi <= SETTINGS.adequate or best.switches:
        return best
    first = best.found[-1].own[0].path
    kicked = [best.values | {first: best.values[first] * kick} for kick in KICKS]
    return best_of(best, *(_fit_from(best, start) for start in (best.own_values, *kicked))) or best


def _fit_from(best: Hypothesis, start: Mapping[str, float]) -> Hypothesis | None:
    """The same fitted from other numbers, given up where it falls short of it; None where that breaks down."""
    until = FallsShort(best.evidence, STEPS)
    try:
        return fit_hypothesis(best.case, best.machine, best.found, best.own, start, until=until)
    except (Failed, np.linalg.LinAlgError):
        return None
