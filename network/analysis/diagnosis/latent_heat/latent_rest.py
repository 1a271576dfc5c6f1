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
from functools import cached_property

import numpy as np

from network.analysis.calibration.gauss_newton import linearise
from network.analysis.diagnosis.hypotheses.compact_fit import expand
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import linearise_at_file
from network.analysis.diagnosis.latent_heat.locate import explain_unknown, locate, rows_of
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import by_weight, distinct
from network.catalogue.declaration.declare import Array
from network.platform.parallel import run_all
from network.platform.refusal import Failed

ROUNDS = 3
"""Steps of the numbers together with the heat, at most; the first takes nearly all of the way."""
ENOUGH = 1.0
"""nats that a step has to bring for another."""
SHARES = (1.0, 0.5, 0.25)
"""Of such a step that are tried, one after the other, as long as it loses more than ENOUGH: far from where it leads,
the slopes are others."""
RANKED = 6
"""Rivals that are weighed beside such heat."""


@dataclass(frozen=True, eq=False)
class Rest:
    """A hypothesis with heat of any course beside it, where that explains most."""

    beside: Hypothesis
    heat: UnknownHeat

    @cached_property
    def evidence(self) -> float:
        """Log evidence of both [nats], at the least of J that the slopes tell."""
        at = self.beside.linearised
        to_go = 0.5 * float(self._pull @ np.linalg.solve(at.precision, self._pull))
        return at.log_evidence + to_go + max(0.0, self.heat.gain) - self.beside.price

    @cached_property
    def left(self) -> float:
        """χ² that is left beside the heat, the numbers where it lets them be."""
        at = self.beside.linearised
        return max(1.0, float(np.mean((at.left - self._rows - self._step @ at.slopes) ** 2)))

    @cached_property
    def _rows(self) -> Array:
        """What the heat does."""
        return rows_of(self.beside.linearised, self.heat)

    @cached_property
    def _step(self) -> Array:
        """A⁻¹(p − S Gf)."""
        at = self.beside.linearised
        return np.asarray(np.linalg.solve(at.precision, self._pull - at.slopes @ self._rows))

    @property
    def _pull(self) -> Array:
        """What draws the numbers; not instants, which have no slope that could hold them."""
        at = self.beside.linearised
        moves = np.ones(len(at.pull))
        moves[: at.free] = [not p.field.is_instant for p in at.problem.parameters]
        return np.asarray(at.pull * moves)

    def move_numbers(self) -> Rest | None:
        """The numbers a step further beside the heat at its place; None where there is no heat, or none of the shares
        of that step is any good."""
        if self.heat.gain <= 0:
            return None
        moves = (self._move_numbers_by(share) for share in SHARES)
        return next((m for m in moves if m is not None and m.evidence > self.evidence - ENOUGH), None)

    def _move_numbers_by(self, share: float) -> Rest | None:
        """None where a run breaks down."""
        at = self.beside.linearised
        low, high = (np.array([getattr(p, side) for p in at.problem.parameters]) for side in ("low", "high"))
        try:
            moved = linearise(at.problem, np.clip(at.theta + share * self._step[: at.free], low, high))
            if not np.isfinite(moved.residual).all():
                return None
            return find_rest_at(replace(self.beside, fit=moved), self.heat)
        except (Failed, np.linalg.LinAlgError):
            return None


def find_rest(h: Hypothesis, refit: bool = True, in_rooms: bool = True) -> Rest:
    """What is left of a hypothesis as heat, where nothing but noise is left beside that; refit: together with it;
    in_rooms: whether it may be surroundings of any course."""
    first = _beside(expand(h), in_rooms)
    best = refit_together(first) if refit else first
    return best if best is first else _beside(best.beside, in_rooms)


def state_at_file(h: Hypothesis) -> Hypothesis | None:
    """A hypothesis at the numbers of the file, under the priors as stated; None where a run breaks down."""
    at = linearise_at_file(h)
    return None if at is None else replace(h, fit=at.temper(1.0, 1.0))


def find_rest_at(h: Hypothesis, of: UnknownHeat) -> Rest:
    """The same, not refitted, at the place of an unknown heat."""
    return Rest(h, explain_unknown(h.linearised, of))


def refit_together(rest: Rest, rounds: int = ROUNDS) -> Rest:
    """With the numbers that stand beside the heat at its place."""
    for _ in range(rounds):
        moved = rest.move_numbers()
        if moved is None or moved.evidence < rest.evidence + ENOUGH:
            break
        rest = moved
    return rest


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
    return [*by_weight(weighed), *rest]


def _weigh_beside(h: Hypothesis) -> float:
    """Its evidence with such heat beside it [nats], which is in a part, for surroundings of any course are themselves
    one of the explanations: beside them all that is none tells the same."""
    return find_rest(h, in_rooms=False).evidence


def share_of_rest(before: Rest, after: Rest) -> float:
    """By what share the variance of the heat that explains most of what was left before falls with what was found."""
    now = explain_unknown(after.beside.linearised, before.heat)
    left = now.rms if now.gain > 0 else 0.0
    return float(np.clip(1 - (left / max(before.heat.rms, 1e-300)) ** 2, 0.0, 1.0))


def _beside(h: Hypothesis, in_rooms: bool) -> Rest:
    able = [u for u in locate(h.linearised, h.machine, 1.0) if in_rooms or not u.is_room]
    return Rest(h, max(able, key=lambda u: u.gain))
