"""Backward: the first finding is judged again beside the others, each is taken out once, and runs are left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from network.analysis.diagnosis.candidates import Candidate
from network.analysis.diagnosis.coarse_surrogate import build_surrogate
from network.analysis.diagnosis.compact_fit import compact
from network.analysis.diagnosis.hypothesis import Case, Hypothesis, estimate_noise, fit_findings, reweight
from network.analysis.diagnosis.lump_refinement import GAIN
from network.analysis.diagnosis.refit import cross_validation_misfit
from network.platform.parallel import run_all

HOLDS = 1.02
"""Misfit on left-out runs, relative to before, that findings may leave."""
ALIKE, ENOUGH = 1.1, 3
"""Misfit on left-out runs over that of the fit to all, relative to before, from which findings tell only what they were
fitted to; and with how many runs that is asked: of two, the other alone need not tell every number."""
RERANKED, REACH = 3, 3.0
"""Rivals of the first finding that are tried in its stead, and how many times what the later findings gained they may
be behind it."""
STEPS = 8
"""Of a fit with other findings."""


def eliminate_backward(
    null: Hypothesis, case: Case, current: Hypothesis, befores: Sequence[Hypothesis],
    steps: Sequence[Sequence[Hypothesis]], threshold: float, jobs: int,
) -> tuple[Hypothesis, tuple[float, ...]]:  # fmt: skip
    """What was found without what is superfluous, and the evidence that each finding adds; the null where it does not
    tell runs left out. befores, steps: what stood before each step, and its rivals."""
    before = reweight(case, null)
    if not current.found:
        return before, ()
    later = sum(ranked[0].evidence - h.evidence for h, ranked in zip(befores[1:], steps[1:], strict=True))
    close = [h for h in steps[0][1 : RERANKED + 1] if steps[0][0].evidence - h.evidence < REACH * later]
    current = _rerank_first(current, close, jobs)
    current, gains = _eliminate_at_end(current, threshold, jobs)
    if not current.found:
        return _bare_or_null(null, current), ()
    holds = _cross_validates(build_surrogate(before), build_surrogate(current), jobs)
    return (current, gains) if holds else (before, ())


def _refit(current: Hypothesis, other: tuple[Sequence[Candidate], Mapping[str, float]]) -> Hypothesis | None:
    """Other findings from some numbers in the stead of those of a hypothesis."""
    found = fit_findings(current.case, current.root, *other, steps=STEPS)
    return found and compact(found)


def _rerank_first(current: Hypothesis, rivals: Sequence[Hypothesis], jobs: int) -> Hypothesis:
    """The first finding against its rivals, now that the others are in."""
    others = [((h.found[-1], *current.found[1:]), h.values | current.values) for h in rivals]
    told = run_all(partial(_refit, current), others, jobs)
    better = max((h for h in told if h is not None), key=lambda h: h.evidence, default=current)
    return _finish_fit(better) if better.evidence > current.evidence else current


def _eliminate_at_end(current: Hypothesis, threshold: float, jobs: int) -> tuple[Hypothesis, tuple[float, ...]]:
    """The findings that still add what chance does not, under the noise that they leave in the end, on the final lumps
    and beside each other, and how much."""
    while True:
        count = len(current.found)
        current, gains = _eliminate(reweight(estimate_noise(current.case, current), current), threshold, jobs)
        if len(current.found) in (0, count):
            return current, gains


def _bare_or_null(null: Hypothesis, bare: Hypothesis) -> Hypothesis:
    """The null, or its machine on the finer lumps that were come to with findings, where these mend it alone."""
    before = reweight(bare.case, null)
    return bare if bare.evidence > before.evidence + GAIN else before


def _eliminate(current: Hypothesis, threshold: float, jobs: int) -> tuple[Hypothesis, tuple[float, ...]]:
    """Without the findings that add less than the threshold beside the others, and the evidence that each of the rest
    adds."""
    gains: list[float] = []
    while current.found:
        rests = [[c for c in current.found if c is not out] for out in current.found]
        less = run_all(partial(_refit, current), [(rest, current.values) for rest in rests], jobs)
        gains = [float("inf") if h is None else current.evidence - h.evidence for h in less]
        k = int(np.argmin(gains))
        other = less[k]
        if other is None or gains[k] >= threshold:
            break
        current = _finish_fit(other)
    return current, tuple(gains) if current.found else ()


def _finish_fit(h: Hypothesis) -> Hypothesis:
    return fit_findings(h.case, h.root, h.found, h.values) or h


def _cross_validates(before: Hypothesis, after: Hypothesis, jobs: int) -> bool:
    """Whether runs left out of the fit are told at least as well as before, and like those in it."""
    was, now = (cross_validation_misfit(h, jobs) for h in (before, after))
    if not np.isfinite(was) or now >= HOLDS * was:
        return not np.isfinite(was)
    is_asked = len(after.case.recordings) >= ENOUGH
    return not is_asked or now < ALIKE * max(1.0, was / before.chi) * max(1.0, after.chi)
