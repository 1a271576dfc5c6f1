"""Where along a bar a finding sits: its stretch is moved, widened and narrowed while that explains more."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product

import numpy as np

from network.analysis.calibration.linearised import Linearised, linearise
from network.analysis.diagnosis.candidates.candidate import STRETCHES, Candidate
from network.analysis.diagnosis.candidates.candidate_response import respond_to_candidates
from network.analysis.diagnosis.hypotheses.compact_fit import compact, fit_or_none
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.screen import whiten
from network.analysis.diagnosis.steps.ranking import best_first
from network.catalogue.declaration.places import Place
from network.platform.parallel import run_all

STEPS = (0.1, 0.05)
"""Shares of a bar's length by which the ends of a stretch are moved, one round each."""
LEAST, WHOLE = 0.05, (0.0, 1.0)
"""Shortest stretch, and the longest."""
COMBINED = 2
"""Bars whose stretches are changed together."""
GAIN = 6.0
"""Log evidence that another stretch must add."""
MOST, NEAR = 3, 0.7
"""Rivals that are moved at most, and the share of the best gain in evidence that is not much less."""
LITTLE, MUCH = 0.01, 0.1
"""Share of the misfit that another stretch must promise to be fitted, and where a candidate only begins."""
LEAST_SEEN = 1e-6
"""Squared change [σ²] of what counts as moved at least."""
TRIED, FIT_STEPS = 2, 4
"""Stretches that are fitted in a round, and in how many steps."""


def place_best(best: Hypothesis, jobs: int = 1) -> Hypothesis:
    """The hypothesis with the stretches of its last finding where they explain most."""
    about = None
    for step in (None, *STEPS):
        moved = list(_elsewhere(best.found[-1]) if step is None else _aside(best.found[-1], step))
        least = max(GAIN, LITTLE * float(best.fit.left @ best.fit.left) / 2)
        about = about or (_linearise(best) if moved else None)
        promising = [c for gain, c in _promise_of(best, about, moved)[:TRIED] if gain > least]
        fits = run_all(partial(_fit_at, best), promising, jobs)
        better = _widest(best, [h for h in fits if h is not None and h.evidence > best.evidence + GAIN])
        best, about = better, about if better is best else None
    return best


def _widest(best: Hypothesis, better: Sequence[Hypothesis]) -> Hypothesis:
    """The best of some that are better, or one over longer stretches that is hardly behind: on coarse lumps a short
    stretch may be the same as a long one, and on finer lumps it is not."""
    most = max((h.evidence for h in better), default=-np.inf)
    close = [h for h in better if h.evidence > most - GAIN]
    return max(close, key=lambda h: (_width(h.found[-1]), h.evidence), default=best)


def _width(c: Candidate) -> float:
    """Lengths of the stretches of a candidate in all, in shares of their bars."""
    return round(sum(bar.stop - bar.start for bar in c.seats), 6)


def move_stretch(h: Hypothesis) -> Hypothesis:
    """The hypothesis with its last finding at other stretches where much of what is left would go, and does."""
    moved = list(_elsewhere(h.found[-1]))
    promised = _promise_of(h, _linearise(h) if moved else None, moved)
    if not promised or promised[0][0] < MUCH * (h.fit.left @ h.fit.left) / 2:
        return h
    other = _fit_at(h, promised[0][1])
    return other if other is not None and other.evidence > h.evidence else h


def place_ranked(before: Hypothesis, ranked: Sequence[Hypothesis], jobs: int = 1) -> list[Hypothesis]:
    """Rivals beside a hypothesis, the best evidence first, those that come near the best of them where they explain
    most."""
    close = near(before, ranked, MOST)
    placed = run_all(partial(place_best, jobs=1 if len(close) > 1 else jobs), close, jobs)
    return best_first(*placed, *ranked[len(close) :])


def near(before: Hypothesis, ranked: Sequence[Hypothesis], most: int) -> list[Hypothesis]:
    """The first of some rivals beside a hypothesis, as far as they gain not much less than the best."""
    needed = before.evidence + NEAR * (ranked[0].evidence - before.evidence) if ranked else 0.0
    return [h for h in ranked[:most] if h is ranked[0] or h.evidence > needed]


def _elsewhere(c: Candidate) -> Iterator[Candidate]:
    """The candidate with every bar as a whole or at one of its stretches, in all combinations."""
    for stretches in product((WHOLE, *STRETCHES), repeat=len(bars := c.seats[:COMBINED])):
        moved = move_bars(c, bars, stretches)
        if moved is not None and moved is not c:
            yield moved


def _aside(c: Candidate, step: float) -> Iterator[Candidate]:
    """The candidate with both ends of a stretch a step further in or out, or one of them."""
    for bar in c.seats:
        for low, high in _step_along(bar.start, bar.stop, step):
            moved = _move_to(c, bar, (low, high)) if high - low >= LEAST else None
            if moved is not None and moved is not c:
                yield moved


def move_bars(c: Candidate, bars: Sequence[Place], to: Sequence[tuple[float, float]]) -> Candidate | None:
    """A candidate with each of some bars at another stretch; itself where it sits there, None where it does not fit."""
    moved: Candidate | None = c
    for bar, ends in zip(bars, to, strict=True):
        moved = moved and _move_to(moved, bar, ends)
    return moved


def _move_to(c: Candidate, bar: Place, to: tuple[float, float]) -> Candidate | None:
    there = Place(bar.node, *to)
    return c if there == bar else c.move_place(str(bar), str(there))


def _step_along(first: float, last: float, step: float) -> Iterator[tuple[float, float]]:
    for a, b in ((-1, 0), (1, 0), (0, -1), (0, 1), (1, 1), (-1, -1)):
        yield max(0.0, first + a * step), min(1.0, last + b * step)


def _linearise(h: Hypothesis) -> Linearised:
    return h.fit if isinstance(h.fit, Linearised) else linearise(h.fit.problem, h.fit.theta)


def _promise_of(
    best: Hypothesis, fit: Linearised | None, moved: Sequence[Candidate]
) -> list[tuple[float, Candidate]]:  # fmt: skip
    """What the way to others would gain, linearly, about the fit, the best first: as in the screening, and only the
    way, for the strength there may be far from that of where it sits now."""
    if fit is None:
        return []
    changes = respond_to_candidates([(c, best.values) for c in moved], fit.problem.data, fit.predictions)
    known = [k for k, d in enumerate(changes) if d is not None]
    if not known:
        return []
    D = whiten(fit, np.array([changes[k] for k in known]))
    M_D = fit.project(D)
    gains = np.maximum(D @ fit.unexplained, 0.0) ** 2 / (2 * np.maximum(np.einsum("ij,ij->i", D, M_D), LEAST_SEEN))
    pairs = [(float(gain), moved[k]) for gain, k in zip(gains, known, strict=True)]
    return sorted(pairs, key=lambda pair: (-round(pair[0], 1), -_width(pair[1])))


def _fit_at(best: Hypothesis, c: Candidate) -> Hypothesis | None:
    other = fit_or_none(best.case, (*best.found[:-1], c), best.own, best.values, FIT_STEPS)
    return other and compact(other)
