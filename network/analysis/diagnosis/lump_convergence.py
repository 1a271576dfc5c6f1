"""A hypothesis on ever finer lumps, while that helps."""

from __future__ import annotations

from network.analysis.diagnosis.coarse_surrogate import fit_on_finer_lumps_afresh
from network.analysis.diagnosis.hypothesis import Case, Hypothesis
from network.analysis.diagnosis.lump_refinement import FINEST, list_finer_machines
from network.analysis.diagnosis.settings import SETTINGS

LITTLE = 0.015
"""Share of the misfit χ that finer lumps must take away for still finer ones to be tried."""


def refine_until_converged(case: Case, best: Hypothesis) -> Hypothesis:
    """The hypothesis on as many lumps as it takes; relays are led back into step there. What numbers of the file are
    bent for is not converged, however little is left."""
    for root in list_finer_machines(best.root, FINEST):
        if best.found and best.chi < SETTINGS.noise and not best.is_bent:
            break
        other = fit_on_finer_lumps_afresh(case, best, root)
        if other is None or other.evidence < best.evidence + _least_gain(best, other):
            break
        is_little = other.chi > (1 - LITTLE) * best.chi
        best = other
        if is_little:
            break
    return best


def _least_gain(best: Hypothesis, other: Hypothesis) -> float:
    """Evidence [nats] that finer lumps must add: none where numbers of the file come back to it by them."""
    return 0.0 if best.is_bent and not other.is_bent else SETTINGS.structure
