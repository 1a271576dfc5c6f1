"""Latent heat beside what was found, the honest rest: a kind counts by what it adds beside heat of any course.

E(h) + max over places of ½ (gᵀ B g − log |I + K GᵀMG|) is the log evidence of a hypothesis h with heat f of any course
at one place beside it (locate; σ and ℓ at their best there), its numbers refitted together with f: by steps
A⁻¹(p − S Gf), p what draws the numbers, A their precision. A finding that only imitates what the catalogue does not
have, or what the form of another one is off by, adds nothing to that: heat of any course tells the rest as well
without it. What the findings explain is by how much the variance of that heat falls. Source: Kennedy & O'Hagan, J. R.
Stat. Soc. B 63 (2001) 425, for the discrepancy beside a model; unverified.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, linearise
from network.analysis.diagnosis.hypotheses.compact_fit import expand
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.locate import explain_unknown, locate, rows_of
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import distinct
from network.catalogue.declaration.declare import Array
from network.platform.parallel import run_all
from network.platform.refusal import Failed

ROUNDS = 3
"""Steps of the numbers together with the heat, at most; the first takes nearly all of the way."""
ENOUGH = 1.0
"""nats that a step has to bring for another."""
RANKED = 6
"""Rivals that are weighed beside such heat."""


@dataclass(frozen=True, eq=False)
class Rest:
    """A hypothesis with heat of any course beside it, where that explains most."""

    beside: Hypothesis
    heat: UnknownHeat

    @property
    def evidence(self) -> float:
        """Log evidence of both [nats], at the least of J that the slopes tell."""
        at = self.beside.linearised
        to_go = 0.5 * float(at.pull @ np.linalg.solve(at.precision, at.pull))
        return at.log_evidence + to_go + max(0.0, self.heat.gain) - self.beside.price


def find_rest(h: Hypothesis, refit: bool = True) -> Rest:
    """What is left of a hypothesis as heat, where nothing but noise is left beside that; refit: together with it."""
    best = _beside(expand(h))
    for _ in range(ROUNDS if refit else 0):
        moved = _refit_together(best)
        if moved is None or moved.evidence < best.evidence + ENOUGH:
            break
        best = moved
    return best


def rank_beside_rest(ranked: Sequence[Hypothesis], jobs: int = 1) -> list[Hypothesis]:
    """Rivals by their evidence with heat of any course beside each, as far as they are among the best without: what
    has the right form leaves the least to such heat, also where lumps or laws leave more than noise. As they are where
    the best leaves nothing that such heat could explain."""
    if not ranked or ranked[0].chi <= SETTINGS.noise:
        return [*ranked]
    first = distinct(ranked)[:RANKED]
    rest = [h for h in ranked if not any(h is other for other in first)]
    told = iter(run_all(_weigh_beside, [h for h in first if h.beside is None], jobs))
    weighed = [h if h.beside is not None else replace(h, beside=next(told)) for h in first]
    return [*sorted(weighed, key=lambda h: -h.weighed), *rest]


def _weigh_beside(h: Hypothesis) -> float:
    """Its evidence with such heat beside it [nats]."""
    return find_rest(h).evidence


def share_of_rest(before: Rest, after: Rest) -> float:
    """By what share the variance of the heat that explains most of what was left before falls with what was found."""
    now = explain_unknown(after.beside.linearised, before.heat)
    left = now.rms if now.gain > 0 else 0.0
    return float(np.clip(1 - (left / max(before.heat.rms, 1e-300)) ** 2, 0.0, 1.0))


def _beside(h: Hypothesis) -> Rest:
    return Rest(h, max(locate(h.linearised, h.machine, 1.0), key=lambda u: u.gain))


def _refit_together(rest: Rest) -> Rest | None:
    """One step of the numbers beside the heat; None where there is no heat, or a run breaks down."""
    at = rest.beside.linearised
    if rest.heat.gain <= 0:
        return None
    try:
        moved = linearise(at.problem, _step_beside(at, rest.heat))
    except (Failed, np.linalg.LinAlgError):
        return None
    return _beside(replace(rest.beside, fit=moved))


def _step_beside(at: Linearised, heat: UnknownHeat) -> Array:
    """θ after a full step, within its bounds, with what the heat shows taken out."""
    step = np.linalg.solve(at.precision, at.pull - at.slopes @ rows_of(at, heat))[: at.free]
    low, high = (np.array([getattr(p, side) for p in at.problem.parameters]) for side in ("low", "high"))
    return np.asarray(np.clip(at.theta + step, low, high))
