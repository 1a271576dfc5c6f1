"""White-noise evidence: the candidate of the catalogue with the best BIC, as if the file's white noise were all."""

from __future__ import annotations

from typing import Any

import numpy as np
from bench.baselines.given import Given, nothing

from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_hypothesis
from network.analysis.diagnosis.screening.screen import Score, screen
from network.platform.refusal import Failed

REFITTED = 5
"""Candidates that are refitted, the best by their linear score."""


def white_evidence(given: Given) -> dict[str, Any]:
    """The best is told where BIC speaks for it at all: no bootstrap, no finer lumps, no run left out."""
    null = given.calibrated
    proposed = candidates(given.machine, given.case.drivers)
    best = screen(null.fit, proposed, null.values)[:REFITTED]
    fits = [h for score in best if (h := refitted(null, score)) is not None]
    won = max(fits, key=lambda h: gain(null, h), default=None)
    if won is None or gain(null, won) <= 0:
        return nothing()
    return {"verdict": "sensor_fault" if won.found[0].channels else "missing_physics", "findings": [told(null, won)]}


def refitted(null: Hypothesis, score: Score) -> Hypothesis | None:
    c = score.candidate
    try:
        return fit_hypothesis(null.case, c.machine, (c,), c.own, {**null.values, **score.best})
    except (Failed, np.linalg.LinAlgError):
        return None


def gain(null: Hypothesis, h: Hypothesis) -> float:
    """BIC's log evidence [nats]: half of what χ² falls, less ½ ln N for each number."""
    fall = null.fit.left @ null.fit.left - h.fit.left @ h.fit.left
    return float(fall - len(h.own) * np.log(len(null.fit.left))) / 2


def told(null: Hypothesis, h: Hypothesis) -> dict[str, Any]:
    c = h.found[0]
    sure = float(1 / (1 + np.exp(-min(gain(null, h), 700.0))))
    return {"kind": c.kind.kind, "places": list(c.places), "channels": list(c.channels), "confidence": sure}
