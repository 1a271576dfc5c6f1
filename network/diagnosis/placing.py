"""Where along a bar a finding sits: its stretch is moved, widened and narrowed while that explains more."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from network.calibration.linearised import linearise
from network.diagnosis.candidates import STRETCHES, Candidate
from network.diagnosis.case import Hypothesis
from network.diagnosis.directions import directions
from network.diagnosis.screen import lean, whitened
from network.diagnosis.slimming import tried
from network.diagnosis.together import spread

STEPS = (0.1, 0.05)
"""Shares of a bar's length by which the ends of a stretch are moved, one round each."""
LEAST = 0.05
"""Shortest stretch."""
GAIN = 6.0
"""Log evidence that another stretch must add."""
MOST, NEAR = 3, 0.7
"""Rivals that are moved at most, and the share of the best gain in evidence that is not much less."""
TRIED, FIT_STEPS = 2, 4
"""Stretches that are fitted in a round, and in how many steps."""


def placed(best: Hypothesis, jobs: int = 1) -> Hypothesis:
    """The hypothesis with the stretches of its last finding where they explain most."""
    for step in (None, *STEPS):
        moved = [c for place in _stretches(best.found[-1]) for c in _moved(best.found[-1], place, step)]
        fits = spread(partial(_fitted, best), _promising(best, moved), jobs, None)
        better = max((h for h in fits if h is not None), key=lambda h: h.evidence, default=None)
        if better is not None and better.evidence > best.evidence + GAIN:
            best = better
    return best


def well_placed(before: Hypothesis, ranked: Sequence[Hypothesis], jobs: int = 1) -> list[Hypothesis]:
    """Rivals beside a hypothesis, the best evidence first, those that come near the best of them where they explain
    most."""
    close = near(before, ranked, MOST)
    return sorted([*(placed(h, jobs) for h in close), *ranked[len(close) :]], key=lambda h: -h.evidence)


def near(before: Hypothesis, ranked: Sequence[Hypothesis], most: int) -> list[Hypothesis]:
    """The first of some rivals beside a hypothesis, as far as they gain not much less than the best."""
    needed = before.evidence + NEAR * (ranked[0].evidence - before.evidence) if ranked else 0.0
    return [h for h in ranked[:most] if h is ranked[0] or h.evidence > needed]


def _stretches(c: Candidate) -> list[str]:
    """The stretches that a patch names, like 'bed@0..0.25'."""
    return sorted(set(re.findall(r"[^'\"\[\]{},:]+@[0-9.]+\.\.[0-9.]+", str(dict(c.patch)))))


def _moved(c: Candidate, place: str, step: float | None) -> Iterator[Candidate]:
    """The candidate with both ends of a stretch a step further in or out, or one of them; without a step, at others."""
    name, _, ends = place.strip().partition("@")
    first, last = (float(x) for x in ends.split(".."))
    for low, high in (*STRETCHES, (0.0, 1.0)) if step is None else _stepped(first, last, step):
        if high - low >= LEAST and (low, high) != (first, last):
            moved = c.moved(place.strip(), f"{name}@{low:.4g}..{high:.4g}")
            if moved is not None:
                yield moved


def _stepped(first: float, last: float, step: float) -> Iterator[tuple[float, float]]:
    for a, b in ((-1, 0), (1, 0), (0, -1), (0, 1), (1, 1), (-1, -1)):
        yield max(0.0, first + a * step), min(1.0, last + b * step)


def _promising(best: Hypothesis, moved: Sequence[Candidate]) -> list[Candidate]:
    """Those that would gain most, linearly, about the fit, as in the screening."""
    if not moved:
        return []
    fit = linearise(best.fit.problem, best.fit.theta)
    changes = directions([(c, best.values) for c in moved], fit.problem.data, fit.predictions)
    told = [k for k, d in enumerate(changes) if d is not None]
    if not told:
        return []
    D = whitened(fit, np.array([changes[k] for k in told]))
    M_D = lean(fit, D)
    gains = M_D @ fit.left - np.einsum("ij,ij->i", D, M_D) / 2
    return [moved[told[i]] for i in np.argsort(gains)[::-1][:TRIED] if gains[i] > 0]


def _fitted(best: Hypothesis, c: Candidate) -> Hypothesis | None:
    return tried(best.case, (*best.found[:-1], c), best.own, best.values, FIT_STEPS)
