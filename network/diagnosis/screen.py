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
from network.diagnosis.candidates import Candidate, along
from network.diagnosis.directions import direction

MOST = 30.0
"""Multiples of the typical strength that the linear score may suppose."""
VARIED = 24
"""Candidates of which stretches of bars are looked at."""
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
    """Changes of the cells' means of all runs (…, cells), whitened."""
    cuts = np.cumsum([len(d.means) for d in fit.problem.data])[:-1]
    parts = np.split(means, cuts, axis=-1)
    return np.concatenate([w(x) for w, x in zip(fit.problem.whiteners, parts, strict=True)], axis=-1)


def lean(fit: Linearised, d: Array) -> Array:
    """M d, for one or many (…, rows)."""
    return np.asarray(d - np.linalg.solve(fit.precision, fit.slopes @ d.T).T @ fit.slopes)


def screen(fit: Linearised, found: Sequence[Candidate], values: Mapping[str, float]) -> list[Score]:
    """Scores of the candidates that a linear answer can be had for, about a fit at these numbers, best first: of each
    the best along the bars that it touches, which is looked for with those that score well as a whole."""
    scores = _scored(fit, [c for c in found if not (c.is_structural or c.switches)], values)
    finer = _scored(fit, [moved for s in scores[:VARIED] for moved in along(s.candidate)], values)
    best = {s.candidate.key: s for s in scores}
    for s in finer:
        if s.gain > best[s.candidate.key].gain:
            best[s.candidate.key] = s
    return sorted(best.values(), key=lambda s: -s.gain)


def _scored(fit: Linearised, found: Sequence[Candidate], values: Mapping[str, float]) -> list[Score]:
    """Scores of candidates as they are, the best of each."""
    tried = [(c, scale) for c in found for scale in _scales(c)]
    changes = [_change(fit, c, values, scale) for c, scale in tried]
    kept = [(c, scale, d) for (c, scale), d in zip(tried, changes, strict=True) if d is not None]
    if not kept:
        return []
    D = whitened(fit, np.array([d for _, _, d in kept]))
    M_D = lean(fit, D)
    scores: dict[tuple[str, ...], Score] = {}
    for (c, scale, _), d, M_d in zip(kept, D, M_D, strict=True):
        score = _score(fit, c, scale, d, M_d)
        if score is not None and (c.key not in scores or score.gain > scores[c.key].gain):
            scores[c.key] = score
    return sorted(scores.values(), key=lambda s: -s.gain)


def _change(fit: Linearised, candidate: Candidate, values: Mapping[str, float], scale: float) -> Array | None:
    """What a candidate changes at a multiple of its typical strength."""
    own = candidate.usual
    if scale != 1.0:
        first = candidate.own[0]
        own[first.path] = float(np.clip(own[first.path] * scale, first.value(first.low), first.value(first.high)))
    change = direction(candidate, {**values, **own}, fit.problem.data, fit.predictions)
    return change if change is not None and np.isfinite(change).all() else None


def _score(fit: Linearised, candidate: Candidate, scale: float, d: Array, M_d: Array) -> Score | None:
    """None where it changes nothing that can be seen."""
    kappa, g = float(d @ M_d), float(M_d @ fit.left)
    if kappa <= 1e-6:
        return None
    chi2 = max(1.0, float(np.mean(fit.left**2)))
    a = float(np.clip(g / kappa, 0.0, MOST))
    return Score(candidate, (a * g - a * a * kappa / 2) / chi2, a * scale, np.sqrt(kappa), M_d)


def _scales(candidate: Candidate) -> tuple[float, ...]:
    """More than one where it brings states of its own, so that its answer is not proportional to its strength."""
    brings_parts = bool(candidate.patch.get("nodes"))
    bent = any(e.has_state for n in candidate.channels for e in candidate.machine.sensors[n].effects)
    return SCALES if brings_parts or bent else (1.0,)
