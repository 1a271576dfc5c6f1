"""Everything that could be missing from a hypothesis, and how each would show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.candidates.candidates import candidates, has_numbers
from network.analysis.diagnosis.hypotheses.few_runs import SEARCHED, on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.latent_heat.locate import locate
from network.analysis.diagnosis.latent_heat.located_heat import UnknownHeat
from network.analysis.diagnosis.lumps.coarse_surrogate import build_surrogate
from network.analysis.diagnosis.lumps.lump_shapes import shapes_of_lumping
from network.analysis.diagnosis.screening.crossed_splits import UnseenTest, halve
from network.analysis.diagnosis.screening.screen import Score, score_candidates, screen
from network.analysis.diagnosis.screening.timed_search import search_timed
from network.analysis.diagnosis.settings import SETTINGS


@dataclass(frozen=True, eq=False)
class Screening:
    """What is proposed beside a hypothesis, and how each would show: about what stands in for it on coarser lumps
    (before). whole: itself on the runs that it tells worst, where that is another; unseen: whether what half of the
    recordings picks out of it shows in the other half."""

    before: Hypothesis
    proposed: tuple[Candidate, ...] = ()
    scores: tuple[Score, ...] = ()
    whole: Hypothesis | None = None
    unseen: UnseenTest | None = None

    @cached_property
    def located(self) -> tuple[UnknownHeat, ...]:
        """Where unknown heat would explain most."""
        return locate(self.before.linearised, self.before.machine)

    def with_scores(self, scores: Sequence[Score]) -> Screening:
        """The same with other scores; what is located is not located again."""
        other = replace(self, scores=tuple(scores))
        other.__dict__["located"] = self.located
        return other


def screen_candidates(current: Hypothesis, seed: int, jobs: int) -> Screening:
    """Everything that could be missing from a hypothesis, screened."""
    current = on_few_runs(current, SEARCHED)
    before = build_surrogate(current)
    proposed = _propose(before)
    look = screen if leaves_something(current) else score_candidates  # nothing is to be placed along bars
    splits = halve(before.linearised, shapes_of_lumping(before, current, jobs))
    scores = look(before.linearised, proposed, before.values, jobs, splits)
    seen = Screening(before, proposed, tuple(scores), current, splits.test() if splits else None)
    if before.chi < SETTINGS.noise:
        return seen
    timed = {s.candidate.key: s for s in search_timed(before, proposed, seen.located, seed, jobs)}
    better = [max(s, timed.get(s.candidate.key, s), key=lambda each: each.gain) for s in scores]
    return seen.with_scores(sorted(better, key=lambda s: -s.gain))


def scores_as_much(current: Hypothesis, per_reading: float, seed: int, jobs: int) -> bool:
    """Whether a candidate scores so much [nats] for each reading where none is placed along bars: a look that takes
    much less than a screening."""
    before = build_surrogate(on_few_runs(current, SEARCHED))
    proposed, least = _propose(before), per_reading * len(before.fit.left)
    if any(s.gain >= least for s in score_candidates(before.linearised, proposed, before.values, jobs)):
        return True
    located = locate(before.linearised, before.machine)
    return any(s.gain >= least for s in search_timed(before, proposed, located, seed, jobs))


def _propose(before: Hypothesis) -> tuple[Candidate, ...]:
    found = candidates(before.machine, before.case.drivers, runs=before.case.runs)
    return tuple(c for c in found if has_numbers(c.machine, before.own))


def leaves_something(h: Hypothesis) -> bool:
    """Whether more than noise is left, or only sensors that are far off keep it from that."""
    return h.chi > (SETTINGS.further if h.found else SETTINGS.noise) or h.offset_pull > SETTINGS.strained
