"""Another kind where along a bar the best explanation sits: at the place where it was proposed it may have stood far
behind, and rivals are moved along bars only where they come near."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate, candidate
from network.analysis.diagnosis.hypotheses.compact_fit import compact, expand
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.screening.screen import Score, score_candidates
from network.analysis.diagnosis.steps.backward_elimination import refit_best
from network.analysis.diagnosis.steps.placement import NEAR, move_bars
from network.analysis.diagnosis.steps.ranking import lead_rivals

TRIED = 2
"""Kinds that are fitted in the stead of the best, those that show most there."""


def exchange_kind(current: Hypothesis, kept: Hypothesis, proposed: Sequence[Candidate], jobs: int) -> Hypothesis:
    """What is kept beside a hypothesis (current), or the one of another kind that explains more at the same stretches
    of the same bars. proposed: what could be missing."""
    likely = _list_likely(current, [*_list_there(kept.found[-1], proposed, current)], kept.found[-1].key, jobs)
    tried = [((*kept.found[:-1], s.candidate), {**kept.values, **s.best}) for s in likely]
    return refit_best(kept, tried, jobs)


def put_in_place(told: Hypothesis | None, kept: Hypothesis | None, ranked: list[Hypothesis]) -> list[Hypothesis]:
    """Rivals as they are, or led by the kind that took the place of what was kept, which is before that by what it
    explains more on its lumps."""
    if told is None or kept is None or told is kept:
        return ranked
    first = next((h for h in ranked if h.found[-1].key == kept.found[-1].key), kept)
    return lead_rivals(compact(told), first.weighed + told.evidence - kept.evidence, ranked)


def _list_there(best: Candidate, proposed: Sequence[Candidate], current: Hypothesis) -> Iterator[Candidate]:
    """The best and others in its parts, over the machine of a hypothesis, at its stretches; none where it has no
    stretch, for so they were all proposed, and none of what is searched for without a score."""
    if best.is_searched_apart or all(bar.share == 1 for bar in best.seats):
        return
    able = [c for c in proposed if not (c.is_searched_apart or c.is_structural)]
    for c in (best, *(c for c in able if c.parts == best.parts and c.key != best.key)):
        there = candidate(current.machine, c.kind, c.patch)
        moved = there and _move_to_seats(there, best)
        if moved is not None:
            yield moved


def _move_to_seats(c: Candidate, best: Candidate) -> Candidate | None:
    """A candidate at the stretches of another one in the same parts; None where it does not fit there."""
    there = {bar.node: bar for bar in best.seats}
    to = [there.get(bar.node, bar) for bar in c.seats]
    return move_bars(c, c.seats, [(bar.start, bar.stop) for bar in to])


def _list_likely(current: Hypothesis, there: Sequence[Candidate], best: tuple[str, ...], jobs: int) -> list[Score]:
    """Those that show not much less than the best of them, by its key, does there."""
    if len(there) < 2:
        return []
    about = expand(current)
    scores = score_candidates(about.linearised, there, about.values, jobs)
    least = max((NEAR * s.gain for s in scores if s.candidate.key == best), default=np.inf)
    return [s for s in scores if s.candidate.key != best and s.gain >= least][:TRIED]
