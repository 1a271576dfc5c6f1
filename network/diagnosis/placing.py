"""Where along a bar a finding sits: its stretch is moved, widened and narrowed while that explains more."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial

from network.diagnosis.candidates import Candidate, candidate, renamed
from network.diagnosis.case import Hypothesis
from network.diagnosis.slimming import tried
from network.diagnosis.together import spread

STEPS = (0.1, 0.05)
"""Shares of a bar's length by which the ends of a stretch are moved, one round each."""
LEAST = 0.05
"""Shortest stretch."""
GAIN = 6.0
"""Log evidence that another stretch must add."""
FIT_STEPS = 4


def placed(best: Hypothesis, jobs: int = 1) -> Hypothesis:
    """The hypothesis with the stretches of its last finding where they explain most."""
    for step in STEPS:
        moved = [c for place in _stretches(best.found[-1]) for c in _moved(best.found[-1], place, step)]
        fits = spread(partial(_fitted, best), moved, jobs, None)
        better = max((h for h in fits if h is not None), key=lambda h: h.evidence, default=None)
        if better is not None and better.evidence > best.evidence + GAIN:
            best = better
    return best


def _stretches(c: Candidate) -> list[str]:
    """The stretches that a patch names, like 'bed@0..0.25'."""
    return sorted(set(re.findall(r"[^'\"\[\]{},:]+@[0-9.]+\.\.[0-9.]+", str(dict(c.patch)))))


def _moved(c: Candidate, place: str, step: float) -> Iterator[Candidate]:
    """The candidate with both ends of a stretch a step further in or out, or one of them."""
    name, _, ends = place.strip().partition("@")
    first, last = (float(x) for x in ends.split(".."))
    for a, b in ((-1, 0), (1, 0), (0, -1), (0, 1), (1, 1), (-1, -1)):
        low, high = max(0.0, first + a * step), min(1.0, last + b * step)
        if high - low >= LEAST and (low, high) != (first, last):
            moved = candidate(c.base, c.kind, renamed(c.patch, place.strip(), f"{name}@{low:.4g}..{high:.4g}"))
            if moved is not None:
                yield moved


def _fitted(best: Hypothesis, c: Candidate) -> Hypothesis | None:
    return tried(best.case, (*best.found[:-1], c), best.own, best.values, FIT_STEPS)
