"""A hypothesis on ever finer lumps, while that helps."""

from __future__ import annotations

import numpy as np

from network.analysis.diagnosis.coarse_surrogate import correction_of, fit_on_finer_lumps_afresh
from network.analysis.diagnosis.hypothesis import Case, Hypothesis
from network.analysis.diagnosis.lump_refinement import FINEST, list_finer_machines
from network.analysis.diagnosis.screen import whiten
from network.analysis.diagnosis.settings import SETTINGS
from network.platform.refusal import Failed

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


def do_finer_lumps_promise(h: Hypothesis) -> bool:
    """Whether still finer lumps, the numbers refitted, would take something of the misfit away, linearly: the residual
    r is M (r − d) then, d what the channels have more on them."""
    fit, finer = h.linearised, next(list_finer_machines(h.root, FINEST), None)
    try:
        lack = None if finer is None else np.concatenate(correction_of(h, finer))
    except (Failed, np.linalg.LinAlgError):
        return False
    if lack is None:
        return False
    now, then = fit.left, fit.left - whiten(fit, lack)
    left = np.einsum("ij,ij->i", fit.project(np.array([now, then])), np.array([now, then]))
    return bool(left[1] < (1 - LITTLE) ** 2 * left[0])
