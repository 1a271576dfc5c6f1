"""The search for a relay: draws first, from the best of them fits over ever more of the runs, so that it keeps step.

First about the null over the beginning of the runs; where nothing comes of that, over more of them, about a fit that
allows any heat at the places in question.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from network.diagnosis.candidates import Candidate
from network.diagnosis.case import Case, Hypothesis, rejudged, under_file_noise
from network.diagnosis.drawing import Look, Sought, parts_about, seek
from network.diagnosis.slimming import beside, slim
from network.diagnosis.together import spread
from network.diagnosis.verdict import UnknownHeat
from network.refusal import Failed

MOST = 3
"""Switched candidates that are drawn."""
NEAR, ALMOST = 0.85, 1.3
"""Misfit of the best draw over that of the null, and over that of the nearest candidate, up to which it is fitted."""
STEPS = 8
"""Of the fits from the draws, over the share of the runs that these looked at."""
LADDER = ((0.4, 5, 4), (0.53, 5, 3), (0.7, 6, 2), (1.0, 12, 1))
"""Shares of each run that fits are extended to, the steps there, and how many of them are."""
WELL = 0.9
"""Misfit χ over that of the null at which the search ends."""


@dataclass(frozen=True)
class _Start:
    """A candidate to be fitted from some numbers, about some starts of its parts."""

    candidate: Candidate
    values: Mapping[str, float]
    began: tuple[Mapping[str, float], ...]


def relays(
    case: Case, current: Hypothesis, switched: Sequence[Candidate], power: float, seed: int, jobs: int,
    looks: Sequence[Look],
) -> list[Hypothesis]:  # fmt: skip
    """The relay that comes nearest, fitted under the noise of the file and told under that of the case; none where no
    draw comes near. looks: at how much of the runs, one after the other until one shows."""
    white = under_file_noise(case)
    null = rejudged(white, current)
    for look in looks:
        found = spread(partial(_sought, null, power, seed, look), switched[:MOST], jobs, None)
        sought = [s for s in found if s is not None]
        least = min((s.ratio for s in sought), default=np.inf)
        near = [s for s in sought if s.ratio < min(NEAR, ALMOST * least)]
        best = _followed_up(white, null, near, look, jobs) if near else None
        if best is not None and best.chi < WELL * null.chi:
            return [slim(rejudged(case, best))]
    return []


def likely(switched: Sequence[Candidate], located: Sequence[UnknownHeat]) -> list[Candidate]:
    """Those at the places where unknown heat explains most first; of two there, the one with more to it."""
    gain = {u.name: u.gain for u in located}
    return sorted(switched, key=lambda c: (-max((gain.get(n, 0.0) for n in parts_about(c)), default=0.0), -len(c.own)))


def _sought(null: Hypothesis, power: float, seed: int, look: Look, candidate: Candidate) -> Sought | None:
    try:
        return seek(null, power, seed, look, candidate)
    except (Failed, np.linalg.LinAlgError):
        return None


def _followed_up(
    case: Case, null: Hypothesis, near: Sequence[Sought], look: Look, jobs: int
) -> Hypothesis | None:  # fmt: skip
    """The best fit from the draws; None where all run away."""
    starts = [_Start(s.space.candidate, {**s.values, **s.space.numbers(d.theta)}, _all(case, s.space.starts(d.theta)))
              for s in near for d in s.draws]  # fmt: skip
    alive = _fitted(case.until(look.share), null, starts, STEPS, jobs)
    for share, steps, count in LADDER:
        if share > look.share:
            starts = [_Start(h.found[-1], h.values, h.case.began) for h in alive[:count]]
            alive = _fitted(case.until(share) if share < 1 else case, null, starts, steps, jobs)
    return alive[0] if alive else None


def _all(case: Case, starts: Mapping[str, float]) -> tuple[Mapping[str, float], ...]:
    """The starts beside those known before, for every run."""
    before = case.began or ({},) * len(case.recordings)
    return tuple({**run, **starts} for run in before) if starts else case.began


def _fitted(
    case: Case, null: Hypothesis, starts: Sequence[_Start], steps: int, jobs: int
) -> list[Hypothesis]:  # fmt: skip
    """Fits from some starts, the best first."""
    fits = spread(partial(_fit, case, null, steps), starts, jobs, None)
    return sorted((h for h in fits if h is not None), key=lambda h: h.chi)


def _fit(case: Case, null: Hypothesis, steps: int, start: _Start) -> Hypothesis | None:
    return beside(replace(case, began=start.began), null, start.candidate, start.values, steps)
