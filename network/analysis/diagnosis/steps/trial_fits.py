"""Fits of candidates beside what is there, by successive halving: some steps for all, further ones for the best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.compact_fit import compact, fit_with
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import (
    CONTINUATION,
    fit_hypothesis,
    lead_into_step,
    settle_hypothesis,
)
from network.analysis.diagnosis.screening.screen import SHOWS, Score
from network.analysis.diagnosis.screening.timed_search import BRIEFLY, settle_instants
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import best_first, best_of
from network.analysis.diagnosis.steps.rival_acceptance import INTERIM_STEPS
from network.analysis.diagnosis.steps.shortlist import WIDER, limit_kinds, list_others
from network.platform.parallel import run_all

AROUND = 6
"""Candidates that sit where the best of them does, and were not on the list, that are fitted besides, and paths that
touch the best one: a strong path does what the linear score gives a weak one beside it."""
KEPT, CONTINUED = 6, 0.3
"""How many of them go on with all runs at most, and what share of the best gain they need."""
LATE = 0.5
"""Share of the time of the search after which what explains most is told as soon as it is fitted, and nothing is led
back into step (budget)."""
FIRST_STEPS, FINALISTS, FINISHED = 7, 3, 0.7
"""Steps of these, how many of them are then fitted to the end at most, and the share of the best gain for that."""
CLEAR, LEAST = 200.0, 2
"""Nats of a gain from which shares of it count, and how many fits go on in any case."""

Tell = Callable[[float], None] | None


def _continue_trial(current: Hypothesis, begun: Hypothesis) -> Hypothesis | None:
    """A trial fitted further on all runs and, where that stays behind what is there, from the current numbers; about
    the starts that it finds, where relays hang on them."""
    case, c = current.case, begun.found[-1]
    best = fit_with(case, current, c, begun.values, FIRST_STEPS)
    if best is None or best.evidence < current.evidence:
        best = best_of(best, fit_with(case, current, c, current.values | c.usual, FIRST_STEPS))
    return best and compact(settle_instants(_settle(best), BRIEFLY))


@dataclass(frozen=True, eq=False)
class TrialFits:
    """Candidates without a relay, fitted a few steps beside what is there. about: that on the runs on which they were;
    begin: does that, from a score; rest: scores of those that were not, the best first; led: evidence of the best of
    those that were fitted so before them, where only what comes near it goes on."""

    current: Hypothesis
    about: Hypothesis
    fits: tuple[Hypothesis, ...]
    begin: Callable[[Score], Hypothesis | None]
    rest: tuple[Score, ...]
    led: float = -np.inf

    @property
    def little(self) -> float:
        """Misfit χ up to which an explanation leaves little."""
        return max(float(np.sqrt(1 + SETTINGS.poor * max(0.0, self.current.chi**2 - 1))), SETTINGS.adequate)

    def is_poor(self, ranked: Sequence[Hypothesis]) -> bool:
        """Whether none of some explanations leaves little, or where nothing is found yet only with sensors far off: by
        more than what is left, which counts as noise, lets them be."""
        most = np.inf if self.current.found else SETTINGS.strained
        return min((h.chi for h in ranked if h.offset_pull < most * max(1.0, h.chi)), default=np.inf) > self.little

    def wider(self, jobs: int) -> TrialFits:
        """The best of those that were not fitted yet."""
        more = limit_kinds(self.rest, *WIDER)
        return replace(self, fits=tuple(fit_all(self.begin, more, jobs)), rest=list_others(self.rest, more))

    def around(self, ranked: Sequence[Hypothesis], jobs: int) -> TrialFits:
        """Others that sit where the best of explanations does instead, where that leaves anything: the right place
        under a wrong name is a near miss; and the best path of the likely ones from one of its ends to other parts:
        far from the fit a strong one may even seem to make it worse."""
        best, (likely, _) = ranked[0], part_likely(self.current, ranked, KEPT, CONTINUED)
        paths = [h.found[-1] for h in likely if h.found[-1].section == "links" and len(h.found[-1].places) > 1]
        shown = [s for s in self.rest if s.gain > SHOWS and best.chi > SETTINGS.noise]
        here = [s for s in shown if s.candidate.parts == best.found[-1].parts][:AROUND]
        beside = list_others([s for s in self.rest if paths and _is_beside(s.candidate, paths[0])], here)
        fits = tuple(fit_all(self.begin, [*here, *map(_begin_clear, beside[:AROUND])], jobs))
        return replace(self, fits=fits, led=max((h.evidence for h in self.fits), default=-np.inf))

    @property
    def foremost(self) -> Hypothesis | None:
        """The best of what is begun."""
        return best_of(*self.fits)

    def fit_further(self, begun: Hypothesis) -> Hypothesis | None:
        """What is begun, fitted further to the runs of what is there; None where it runs away."""
        return _continue_trial(self.current, begun)

    def fit_in_passing(self, begun: Hypothesis) -> list[Hypothesis]:
        """What is begun, fitted in a few steps to the runs of what is there; none where it runs away."""
        told = fit_with(self.current.case, self.current, begun.found[-1], begun.values, INTERIM_STEPS)
        return [] if told is None else [compact(told)]

    def rank(self, jobs: int) -> list[Hypothesis]:
        """The best of them fitted further and to the end, the best evidence first: successive halving, on all runs."""
        likely, _ = part_likely(self.about, self.fits, KEPT, CONTINUED, self.led)
        further = [h for h in run_all(partial(_continue_trial, self.current), likely, jobs) if h is not None]
        likely, rest = part_likely(self.current, further, FINALISTS, FINISHED)
        return best_first(*run_all(_finish_fit, likely, jobs), *rest)


def _begin_clear(s: Score) -> Score:
    """A path at its usual strength or what is scored beyond it."""
    return replace(s, amplitude=max(s.amplitude, 1.0))


def _is_beside(c: Candidate, path: Candidate) -> bool:
    """Whether a candidate is what a path is, from one of its ends to another node."""
    return c.kind is path.kind and len(c.places) > 1 and len({*c.places} & {*path.places}) == 1


def fit_all(
    begin: Callable[[Score], Hypothesis | None], trials: Sequence[Score], jobs: int, tell: Tell = None
) -> list[Hypothesis]:  # fmt: skip
    return [h for h in run_all(begin, trials, jobs, tell) if h is not None]


def part_likely(
    current: Hypothesis, fits: Sequence[Hypothesis], most: int, share: float, led: float = -np.inf
) -> tuple[list[Hypothesis], list[Hypothesis]]:  # fmt: skip
    """Fits to go on with, and those of which it is enough to know how far behind they are: behind the best of them, or
    what led before them."""
    ranked = best_first(*fits)
    needed = share * max(0.0, *(best - current.evidence for best in (led, *(h.evidence for h in ranked[:1]))))
    near = sum(h.evidence - current.evidence >= needed for h in ranked)
    least = LEAST if led == -np.inf else 0
    count = min(most, max(near, least)) if needed > CLEAR else most
    return ranked[:count], ranked[count:]


def _settle(h: Hypothesis) -> Hypothesis:
    """About the starts that it finds, in a few steps."""
    return settle_hypothesis(h, h.case.budget.is_searched, FIRST_STEPS)


def _finish_fit(h: Hypothesis) -> Hypothesis:
    """Fitted to the end; where relays fell out of step and there is time also from the numbers of the file beside its
    own, over ever more of the runs: those at hand are bent to what it explains, and no slope leads back from there."""
    if h.chi <= SETTINGS.noise:
        return h
    direct = _settle(fit_hypothesis(h.case, h.machine, h.found, h.own, h.values))
    slips = direct.fit.problem.model.switches and direct.chi > SETTINGS.noise
    is_late = h.case.budget.is_past(LATE * SETTINGS.searched)
    led = lead_into_step(h.case, direct, h.own_values, CONTINUATION) if slips and not is_late else None
    return compact(direct if led is None else max(direct, _settle(led), key=lambda fit: fit.evidence))
