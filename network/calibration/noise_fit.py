"""How much coloured noise and misplaced heat the residuals of a fit hold: the most probable amounts of both.

Maximised is the evidence with all parameters and nuisances integrated out, linearised where the fit stands. Only
products of columns are formed again, no run. Source: MacKay, Neural Computation 4 (1992) 415, on evidence maximisation.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from network.calibration.arrow import Part
from network.calibration.linearised import Linearised
from network.calibration.noise import Noise, slack_covariance, whitener
from network.calibration.noise_search import BEGINNINGS, Search
from network.calibration.threads import on_one_thread


@on_one_thread
def estimate_noise(at: Linearised, ell: float = Noise().ell) -> Noise:
    """The most probable coloured noise of every channel and slack heat of the parts, from a fit; none of either where
    that is no better. ell: correlation time of the slack [s].

    Climbed one by one from two beginnings, white and everything a little, for the hill may have two tops.
    """
    search = Search(at, ell)
    ends = [search.climbed(size) for size in BEGINNINGS]
    search.stand(max(ends, key=lambda end: end[0]))
    search.drop_idle()
    return search.noise


def rewhitened(at: Linearised, noise: Noise) -> Linearised:
    """The same linearised fit under another noise, without computing a run."""
    whiteners = []
    for data, prediction in zip(at.problem.data, at.predictions, strict=True):
        slack = slack_covariance(prediction, data, noise) if any(noise.slack.values()) else None
        whiteners.append(whitener(data, noise, slack))
    problem = replace(at.problem, whiteners=tuple(whiteners))
    parts, residual = [], np.empty_like(at.residual)
    for (rows, _), part, old, new in zip(at.blocks, at.parts, at.problem.whiteners, whiteners, strict=True):
        own = (new.again(old.undone(s)) for s in (part.by_theta, part.by_offset, part.by_own))
        parts.append(Part(*own))
        residual[rows] = new.again(old.undone(at.residual[rows]))
    return replace(at, problem=problem, residual=residual, parts=tuple(parts))
