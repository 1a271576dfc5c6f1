"""Another one in the stead of the first finding, once later ones stand beside it."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings
from network.analysis.diagnosis.screening.screen import SHOWS, score_candidates
from network.analysis.diagnosis.steps.backward_elimination import STEPS, refit_best
from network.analysis.diagnosis.steps.ranking import lead_rivals
from network.analysis.diagnosis.steps.selection import Selection

RERANKED, REACH = 3, 3.0
"""Rivals of the first finding that are tried in its stead, as many others that sit where it does, and how many times
what the later findings gained they may be behind it."""


def rerank_first(now: Selection, jobs: int) -> Selection:
    """What was found with another one of the first step's rivals in place of the first finding, or something else that
    sits where that does, where it is better beside the others: what came first may have stood in for two."""
    current, (first, *_) = now.best, now.steps
    later = sum(ranked[0].evidence - h.evidence for h, ranked in zip(now.befores[1:], now.steps[1:], strict=True))
    rivals = [h for h in first[1 : RERANKED + 1] if first[0].evidence - h.evidence < REACH * later]
    others = [((h.found[-1], *current.found[1:]), h.values | current.values) for h in rivals]
    tried = {h.found[-1].key for h in (first[0], *rivals)}
    others += [((c, *current.found[1:]), values) for c, values in _list_there(current, tried, jobs)]
    better = refit_best(current, others, jobs)
    return now if better is current else _exchange_first(now, better)


def _exchange_first(now: Selection, better: Hypothesis) -> Selection:
    """A selection with another first finding, which leads its step by what it gains beside the later ones."""
    (first, *later), current = now.steps, now.best
    alone = fit_findings(current.case, current.root, better.found[:1], better.values, steps=STEPS)
    if alone is None:
        return replace(now, best=better)
    weighed = first[0].weighed + better.evidence - current.evidence
    return replace(now, best=better, steps=(tuple(lead_rivals(compact(alone), weighed, first)), *later))


def _list_there(
    current: Hypothesis, tried: Collection[tuple[str, ...]], jobs: int
) -> Iterator[tuple[Candidate, dict[str, float]]]:
    """What else shows most in the parts of the first finding beside the later ones alone, and the numbers there."""
    (first, *later), case = current.found, current.case
    less = fit_findings(case, current.root, later, current.values, steps=STEPS) if later and first.parts else None
    if less is not None:
        proposed = candidates(less.machine, case.drivers, runs=case.runs)
        there = [c for c in proposed if c.parts == first.parts and c.key not in tried and not c.switches]
        for score in score_candidates(less.linearised, there, less.values, jobs)[:RERANKED]:
            if score.gain > SHOWS:
                yield score.candidate, {**less.values, **score.best}
