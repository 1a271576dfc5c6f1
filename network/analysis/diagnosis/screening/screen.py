"""Screening: which candidates are worth a fit of their own. A linear score picks whom to refit, never who wins.

About a fit with slopes S (whitened, prior precision V⁻¹) that leaves r a candidate that changes the channels by d per
unit of its strength gains a g − a²κ/2 at most, g = dᵀr, κ = dᵀMd, M = I − Sᵀ(SSᵀ + V⁻¹)⁻¹S: the parameters are refitted
with it, and what relieves numbers that are bent against their priors gains by that, too. Source: the score (Lagrange
multiplier) test with nuisance parameters, Rao 1948; Davidson & MacKinnon, Econometric Theory and Methods (2004), ch.
15; unverified.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidate_response import respond_to_candidates
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter
from network.platform.parallel import go_on

if TYPE_CHECKING:
    from network.analysis.diagnosis.screening.crossed_splits import CrossedSplits

MOST = 30.0
"""Multiples of the typical strength that the linear score may suppose."""
SCALES = (0.25, 4.0)
"""Multiples of the usual size tried where the answer is not one of heat alone."""
SIZED = 2
"""Numbers of such a candidate that are tried so."""
LIKELY, RESIZED = 0.1, 8
"""Share of the best gain at the usual size from which such a candidate is tried at other sizes, and how many are."""
SHOWS = 1.0
"""Nats of a linear score from which a candidate is looked at."""
OFF = (-3.0, -1.0, -0.3, 0.0, 0.3, 1.0, 3.0)
"""Prior 1σ by which a temperature that a candidate brings is moved."""
SEEN = 1e-6
"""κ from which a candidate changes anything that can be seen."""
LEAST = 0.02
"""Multiple of the typical strength that a fit begins from at least."""


@dataclass(frozen=True)
class Score:
    """The linear gain [nats] of a candidate at its best strength (a multiple of the typical one); detectable: change at
    the typical strength that no parameter takes up [σ]; lean: whitened d with the parameters' share taken out; own: its
    numbers, by path, that this was found at."""

    candidate: Candidate
    gain: float
    amplitude: float
    detectable: float
    lean: Array
    own: Mapping[str, float] = field(default_factory=dict)

    @property
    def best(self) -> dict[str, float]:
        """Its numbers at the best strength."""
        first = self.candidate.own[0]
        amplitude = np.copysign(max(abs(self.amplitude), LEAST), self.amplitude)
        return {**self.own, first.path: _within(first, first.value(first.centre) * float(amplitude))}


def whiten(fit: Linearised, means: Array) -> Array:
    """Changes of the cells' means of all runs (…, cells), whitened."""
    cuts = np.cumsum([len(d.means) for d in fit.problem.data])[:-1]
    parts = np.split(means, cuts, axis=-1)
    return np.concatenate([w(x) for w, x in zip(fit.problem.whiteners, parts, strict=True)], axis=-1)


def screen(
    fit: Linearised, found: Sequence[Candidate], values: Mapping[str, float], jobs: int = 1,
    splits: CrossedSplits | None = None,
) -> list[Score]:  # fmt: skip
    """Scores of the candidates that a linear answer can be had for, about a fit at these numbers, best first: of each
    the best along the bars that it touches. splits: looks at their shapes, too."""
    placed = [placed for c in _able(found) for placed in _list_places(c)]
    return score_candidates(fit, placed, values, jobs, splits)


def _list_places(c: Candidate) -> tuple[Candidate, ...]:
    go_on()
    return (c, *c.stretches)


def score_candidates(
    fit: Linearised, candidates: Sequence[Candidate], values: Mapping[str, float], jobs: int = 1,
    splits: CrossedSplits | None = None,
) -> list[Score]:  # fmt: skip
    """The same of candidates as they are: all at their usual sizes, then one number after the other of the likely ones
    that bring states at others. splits: looks at the usual ones alone, which no half of the recordings has chosen."""
    usual = [(c, *variant) for c in _able(candidates) for variant in _list_usual(c)]
    best = {s.candidate.key: s for s in score_variants(fit, usual, values, jobs, splits)}
    ranked = sorted(best.values(), key=lambda s: -s.gain)
    least = max(SHOWS, LIKELY * ranked[0].gain) if ranked else 0.0
    likely = [s.candidate.key for s in ranked if s.gain >= least and _brings_states(s.candidate)][:RESIZED]
    for number in range(SIZED):
        sized = [(best[key].candidate, *variant) for key in likely for variant in _resize(best[key], number)]
        for s in score_variants(fit, sized, values, jobs):
            best[s.candidate.key] = max(s, best[s.candidate.key], key=lambda each: each.gain)
    return sorted(best.values(), key=lambda s: -s.gain)


def score_variants(
    fit: Linearised, tried: Sequence[tuple[Candidate, float, Mapping[str, float]]], values: Mapping[str, float],
    jobs: int = 1, splits: CrossedSplits | None = None,
) -> list[Score]:  # fmt: skip
    """Of candidates, each at some numbers with the multiple of its typical strength there, the best of each."""
    each = [(c, {**values, **numbers}) for c, _, numbers in tried]
    changes = respond_to_candidates(each, fit.problem.data, fit.predictions, jobs)
    kept = [(*of, d) for of, d in zip(tried, changes, strict=True) if d is not None and np.isfinite(d).all()]
    if not kept:
        return []
    D = whiten(fit, np.array([d for *_, d in kept]))
    M_D = fit.project(D)
    if splits is not None:
        splits.look([c for c, *_ in kept], D, MOST)
    scores: dict[tuple[str, ...], Score] = {}
    for (c, scale, numbers, _), d, M_d in zip(kept, D, M_D, strict=True):
        score = _score(fit, c, scale, numbers, d, M_d)
        if score is not None and (c.key not in scores or score.gain > scores[c.key].gain):
            scores[c.key] = score
    return sorted(scores.values(), key=lambda s: -s.gain)


def firm_of(fit: Linearised) -> float:
    """The square of the misfit that is left, in which gains count."""
    return max(1.0, float(np.mean(fit.left**2)))


def best_amplitude(g: Array, kappa: Array, least: float, firm: float) -> tuple[Array, Array]:
    """Multiples of the typical strength, from the least that may be, that gain most, and their gains [nats]."""
    a = np.clip(g / kappa, least, MOST)
    return a, (a * g - a * a * kappa / 2) / firm


def _able(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Those that a linear answer can be had for."""
    return [c for c in candidates if not (c.is_structural or c.switches)]


def _score(
    fit: Linearised, candidate: Candidate, scale: float, numbers: Mapping[str, float], d: Array, M_d: Array
) -> Score | None:  # fmt: skip
    """None where it changes nothing that can be seen."""
    kappa, g = d @ M_d, d @ fit.unexplained
    if kappa <= SEEN:
        return None
    a, gain = best_amplitude(g, kappa, -MOST if candidate.is_signed else 0.0, firm_of(fit))
    return Score(candidate, float(gain), float(a) * scale, float(np.sqrt(kappa)), M_d, numbers)


def _list_usual(c: Candidate) -> Iterator[tuple[float, dict[str, float]]]:
    """The numbers at which a candidate is looked at, each with the multiple of the typical strength: the usual ones,
    and temperatures that it brings up to 3σ off the middle of their priors, for they say which way its heat flows."""
    warm = [p for p in c.own[1:] if p.field.unit == "degC"]
    for off in OFF if warm else (0.0,):
        yield 1.0, {**c.usual, **{p.path: p.value(p.centre + off * p.spread) for p in warm}}


def _resize(s: Score, number: int) -> Iterator[tuple[float, dict[str, float]]]:
    """The same with one of the numbers at other sizes than it was found at: where a candidate brings states of its own
    its answer is not proportional to its strength."""
    first, sized = s.candidate.own[0], [p for p in s.candidate.own if p.is_log]
    for p in sized[number : number + 1]:
        for x in SCALES:
            own = {**s.own, p.path: _within(p, s.own[p.path] * x)}
            yield own[first.path] / s.candidate.usual[first.path], own


def _within(p: Parameter, value: float) -> float:
    return float(np.clip(value, p.value(p.low), p.value(p.high)))


def _brings_states(c: Candidate) -> bool:
    brings_parts = any(c.machine.nodes[n].is_part for n in c.patch.get("nodes", ()))
    return brings_parts or any(e.has_state for n in c.channels for e in c.machine.sensors[n].effects)
