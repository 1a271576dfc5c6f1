"""Candidates begun: those that screenings choose, fitted a few steps on a few runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from network.analysis.calibration.estimate import Estimate
from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.compact_fit import compact, fit_with
from network.analysis.diagnosis.hypotheses.few_runs import on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import linearise_narrowed
from network.analysis.diagnosis.lumps.coarse_surrogate import SMALL
from network.analysis.diagnosis.screening.screen import SHOWS, Score, score_candidates
from network.analysis.diagnosis.steps.placement import move_stretch
from network.analysis.diagnosis.steps.ranking import best_of
from network.analysis.diagnosis.steps.shortlist import LONGER, SHORTLIST, list_others, shortlist
from network.analysis.diagnosis.steps.thermometer_fit import ByThermometers, score_by_thermometers
from network.analysis.diagnosis.steps.trial_fits import Tell, TrialFits, fit_all
from network.catalogue.declaration.sections import TCP
from network.engine.response.parameters import centres, values_at

LARGE = 120
"""Lumps from which candidates are screened about the fit only."""
BRIEF, BRIEFER = 4, 2
"""Steps of every candidate on a few runs, from the numbers of the file and from those at hand, where it is near."""
FOREMOST = 2
"""Candidates of each screening that are fitted before the others: the time may be up before these are."""
AT_ONCE = 6
"""Candidates that are fitted before it is asked again whether it is late (budget)."""


def linearise_at_priors(fit: Linearised | Estimate) -> Linearised | None:
    """The problem about the priors' centres, with priors narrowed by the misfit there; None where it breaks down."""
    return linearise_narrowed(fit.problem, centres(fit.problem.parameters))


def _about_file(current: Hypothesis, candidates: Sequence[Candidate], jobs: int) -> list[Score]:
    """The screening about the file's own numbers, where candidates are proposed; none where that would take long or
    breaks down."""
    about = linearise_at_priors(current.linearised) if current.machine.lumps < LARGE else None
    if about is None:
        return []
    return score_candidates(about, candidates, values_at(about.problem.parameters, about.theta), jobs)


def _start_trial(
    about: Hypothesis, about_file: Mapping[tuple[str, ...], Score], aside: ByThermometers | None, trial: Score
) -> Hypothesis | None:  # fmt: skip
    """A trial fitted a few steps from the numbers of the file, its own from the screening about these, if it shows
    there (what moves the tool centre point: from those that thermometers alone tell), and from those at hand, where it
    was screened: the better, moved along bars, for where it was screened may not be where it belongs at the numbers it
    takes."""
    moves = trial.candidate.section == TCP
    shown, values = (aside.scores, aside.values) if aside and moves else (about_file, about.own_values)
    there = shown.get(trial.candidate.key)
    first = there if there is not None and there.gain > SHOWS else trial
    of_file = fit_with(about.case, about, first.candidate, {**values, **first.best}, BRIEF)
    at_hand = fit_with(about.case, about, trial.candidate, about.values | trial.best, BRIEFER)
    begun = best_of(of_file, at_hand)
    return begun and compact(move_stretch(begun))


def start_trials(
    current: Hypothesis, candidates: Sequence[Candidate], scores: Sequence[Score], jobs: int, tell: Tell = None,
    is_near: bool = False, is_late: Callable[[], bool] = lambda: False,
) -> Iterator[TrialFits]:  # fmt: skip
    """The likely ones of what is proposed beside a hypothesis, each with its own fit; as soon as it is late, what is
    there of them so far, too, the foremost first. scores: of the screening about it; is_near: whether the fit is near,
    so that what shows about it is all that shows."""
    about_file = [] if is_near else _about_file(current, candidates, jobs)
    is_quick = not (is_near or is_late()) and current.machine.lumps < LARGE
    aside = score_by_thermometers(current, candidates, jobs) if is_quick else None
    most = LONGER if current.machine.lumps <= SMALL else SHORTLIST
    trials = shortlist(scores, about_file, most, [*aside.scores.values()] if aside else ())
    about = on_few_runs(current)
    begin = partial(_start_trial, about, {s.candidate.key: s for s in about_file}, aside)
    begun = TrialFits(current, about, (), begin, list_others(scores, trials))
    others = list_others(trials, shortlist(scores, about_file, FOREMOST))
    parts = [of[k : k + AT_ONCE] for of in (list_others(trials, others), others) for k in range(0, len(of), AT_ONCE)]
    yield from _fit_in_turn(begun, parts, jobs, tell, is_late)


def _fit_in_turn(
    begun: TrialFits, parts: Sequence[Sequence[Score]], jobs: int, tell: Tell, is_late: Callable[[], bool]
) -> Iterator[TrialFits]:
    """All of some trials; where it is late, those of each part as soon as they are fitted."""
    for k, part in enumerate(parts, 1):
        told = None if tell is None else partial(_tell_part, tell, k - 1, len(parts))
        begun = replace(begun, fits=(*begun.fits, *fit_all(begun.begin, part, jobs, told)))
        if k < len(parts) and is_late():
            yield begun
    yield begun


def _tell_part(tell: Callable[[float], None], done: int, count: int, share: float) -> None:
    tell((done + share) / count)
