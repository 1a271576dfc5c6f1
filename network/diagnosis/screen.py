"""Screening: which candidates are worth a fit of their own. A linear score picks whom to refit, never who wins.

About a fit with residual r and slopes S (whitened, prior precision V⁻¹) a candidate that changes the channels by d per
unit of its strength gains at most a g − a²(κ + 1/v)/2, g = dᵀr, κ = dᵀMd, M = I − Sᵀ(SSᵀ + V⁻¹)⁻¹S: the parameters are
refitted with it. Source: the score (Lagrange multiplier) test with nuisance parameters, Rao 1948; Davidson & MacKinnon,
Econometric Theory and Methods (2004), ch. 15; unverified.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from network.calibration.fitting import Linearised
from network.declare import Array
from network.diagnosis.candidates import Candidate
from network.diagnosis.directions import direction

MOST = 30.0
"""Multiples of the typical strength that the linear score may suppose."""
SCALES = (0.25, 1.0, 4.0)
"""Multiples of the typical strength tried where the answer is not one of heat alone."""


@dataclass(frozen=True)
class Score:
    """The linear gain [nats] of a candidate at its best strength (a multiple of the typical one); detectable: change at
    the typical strength that no parameter takes up [σ]; lean: whitened d with the parameters' share taken out."""

    candidate: Candidate
    gain: float
    amplitude: float
    detectable: float
    lean: Array


def whitened(fit: Linearised, means: Array) -> Array:
    """A change of the cells' means of all runs, whitened."""
    cuts = np.cumsum([len(d.means) for d in fit.problem.data])[:-1]
    parts = np.split(means, cuts)
    return np.concatenate([w(x) for w, x in zip(fit.problem.whiteners, parts, strict=True)])


def lean(fit: Linearised, d: Array) -> Array:
    """M d."""
    return np.asarray(d - fit.slopes.T @ np.linalg.solve(fit.precision, fit.slopes @ d))


def score(fit: Linearised, candidate: Candidate, values: Mapping[str, float], scale: float = 1.0) -> Score | None:
    """The score of one candidate about a fit; None where it changes nothing that can be seen."""
    own = {p.path: p.value(p.centre) for p in candidate.own}
    if scale != 1.0:
        first = candidate.own[0]
        own[first.path] = float(np.clip(own[first.path] * scale, first.value(first.low), first.value(first.high)))
    change = direction(candidate, {**values, **own}, fit.problem.data, fit.predictions)
    if change is None or not np.isfinite(change).all():
        return None
    d = whitened(fit, change)
    M_d = lean(fit, d)
    kappa, g = float(d @ M_d), float(M_d @ fit.left)
    if kappa <= 1e-6:
        return None
    chi2 = max(1.0, float(np.mean(fit.left**2)))
    a = float(np.clip(g / kappa, 0.0, MOST))
    return Score(candidate, (a * g - a * a * kappa / 2) / chi2, a * scale, np.sqrt(kappa), M_d)


def screen(
    fits: Sequence[Linearised], found: Sequence[Candidate], values: Sequence[Mapping[str, float]]
) -> list[list[Score]]:
    """Scores of all candidates about each of some fits, best first."""
    return [sorted(_scores(fit, found, v), key=lambda s: -s.gain) for fit, v in zip(fits, values, strict=True)]


def _scores(fit: Linearised, found: Sequence[Candidate], values: Mapping[str, float]) -> list[Score]:
    scores = []
    for candidate in found:
        if candidate.is_structural or candidate.switches:
            continue
        scales = SCALES if _is_bent(candidate) else (1.0,)
        own = [s for scale in scales if (s := score(fit, candidate, values, scale))]
        if own:
            scores.append(max(own, key=lambda s: s.gain))
    return scores


def _is_bent(candidate: Candidate) -> bool:
    """Whether it brings states of its own, so that its answer is not proportional to its strength."""
    brings_parts = bool(candidate.patch.get("nodes"))
    return brings_parts or any(e.has_state for n in candidate.channels for e in candidate.machine.sensors[n].effects)
