"""Where nothing but noise is left, and a candidate shows all the same."""

from __future__ import annotations

from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.lumps.lump_convergence import refine_once
from network.analysis.diagnosis.screening.screening import Screening, leaves_something, screen_candidates
from network.analysis.diagnosis.settings import SETTINGS


def settle_lumps(begun: Hypothesis, first: Screening, seed: int, jobs: int) -> tuple[Hypothesis, Screening]:
    """Where steps begin, and its screening: where nothing is left but a candidate shows, on the lumps that it takes if
    these explain more than that, for what few of them lack looks like a candidate."""
    if leaves_something(begun) or not shows_name(begun, first):
        return begun, first
    finer = refine_once(begun, max(s.gain for s in first.scores), jobs)
    return (begun, first) if finer is begun else (finer, screen_candidates(finer, seed, jobs))


def shows_name(current: Hypothesis, first: Screening) -> bool:
    """Whether one candidate shows half of what lumps may leave, where nothing was found yet: what is missing may have
    passed for noise, constant errors of sensors and numbers near those of the file. Far from these a score tells
    little."""
    if current.found or current.is_bent:
        return False
    left = (SETTINGS.noise**2 - 1) / 2 * len(first.before.fit.left)
    return any(s.gain > max(SETTINGS.half * left, SETTINGS.least) for s in first.scores)
