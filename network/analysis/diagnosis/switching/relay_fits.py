"""Fits of relays over ever more of the runs, so that they keep step, from where draws or readings begin them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, linearise
from network.analysis.calibration.measured_means import RunPoint
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import fit_with
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import theta_of
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.switching.relay_samples import ALIKE, NEAR, after
from network.analysis.diagnosis.switching.share_view import View
from network.catalogue.declaration.declare import Array
from network.platform.parallel import run_all

Ladder = Sequence[tuple[float, int, int]]
"""Shares of each run, from the onset on, over which relays are fitted, steps there, and how many go on."""
LADDER: Ladder = ((0.5, 5, 3), (0.75, 6, 2), (1.0, 12, 1))
"""Of those that were drawn."""
SHOWN_LADDER: Ladder = ((0.25, 5, 3), *LADDER)
"""The same for those that readings show, whose numbers are near from the start."""
WELL = 0.9
"""Misfit χ over that of the null from which a relay counts as found."""


@dataclass(frozen=True)
class RelayStart:
    """A candidate to be fitted from some numbers, about some starts of its parts. followed: misfit χ of a heat that
    follows the instants from which these come."""

    candidate: Candidate
    values: Mapping[str, float]
    began: tuple[RunPoint, ...]
    followed: float = np.inf


def fit_over_more(
    case: Case, null: Hypothesis, starts: Sequence[RelayStart], ladder: Ladder,
    leave: Callable[[float], float], onset: float, jobs: int,
) -> list[Hypothesis]:  # fmt: skip
    """The best fits from some starts over ever more of the runs, of each candidate one at least; none where all run
    away or leave about what the null leaves."""
    alive: list[Hypothesis] = []
    for share, steps, most in ladder:
        there = after(onset, share)
        fits = run_all(partial(_fit, case.until(there) if there < 1 else case, null, steps), starts, jobs)
        told = sorted((h for h in fits if h is not None), key=lambda h: h.chi)
        alive = keep_of_each(_keep_promising(told, leave(there)), most)
        starts = [RelayStart(h.found[-1], h.values, h.case.began) for h in alive]
    return alive


def keep_of_each(fits: Sequence[Hypothesis], most: int) -> list[Hypothesis]:
    """So many of some fits, the best first, and the best of every candidate."""
    first = {h.found[-1].key: h for h in reversed(fits)}
    return [h for k, h in enumerate(fits) if k < most or first[h.found[-1].key] is h]


def _keep_promising(fits: Sequence[Hypothesis], left: float) -> list[Hypothesis]:
    """Fits over a share, the best first, of which no two are the same, and that explain half of what the best does;
    none where that does not come as near as the draws had to; left: misfit χ of the null there."""
    kept: list[Hypothesis] = []
    if fits and fits[0].chi ** 2 < NEAR * left**2:
        least = SETTINGS.half * (left**2 - fits[0].chi ** 2)
        for h in fits:
            if left**2 - h.chi**2 >= least and not any(_is_same(h, other) for other in kept):
                kept.append(h)
    return kept


def _is_same(a: Hypothesis, b: Hypothesis) -> bool:
    """Whether two fits came to the same relay."""
    if a.found[-1].key != b.found[-1].key:
        return False
    apart = theta_of(a.found[-1].own, a.own_values) - theta_of(b.found[-1].own, b.own_values)
    return bool(np.abs(apart / [p.spread for p in a.found[-1].own]).max() < ALIKE)


def _fit(case: Case, null: Hypothesis, steps: int, start: RelayStart) -> Hypothesis | None:
    return fit_with(replace(case, began=start.began), null, start.candidate, start.values, steps)


def leave_of_null(abouts: Sequence[Linearised], share: float) -> float:
    """Misfit χ of the null over a share of the runs."""
    return min(float(np.sqrt(v.misfit / v.rows)) for v in (View(a, share) for a in abouts))


def linearise_firmly(null: Hypothesis, theta: Array) -> Linearised:
    return linearise(replace(null.fit.problem, firm_theta=1.0, firm_eta=1.0), theta)
