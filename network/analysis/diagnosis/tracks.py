"""From which lumps the steps go: from the best of them, then from those of the machine as written.

Lumps bend to what is missing as numbers do: where a slow sensor or a mass that nobody told is all that is missing,
finer ones explain much of it, and hide it. So where they leave much and there is time for it, it is first seen whether
one thing explains everything on those that were written: then the steps go from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from network.analysis.diagnosis.candidates.candidates import candidates
from network.analysis.diagnosis.hypotheses.falling_short import share_shown
from network.analysis.diagnosis.hypotheses.few_runs import SEARCHED, on_few_runs
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.lumps.coarse_surrogate import SMALL
from network.analysis.diagnosis.lumps.lump_refinement import MANY
from network.analysis.diagnosis.screening.screen import score_candidates
from network.analysis.diagnosis.screening.screening import Screening, leaves_something, screen_candidates
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import best_first
from network.analysis.diagnosis.steps.refit import start_trials
from network.analysis.diagnosis.steps.trial_fits import LEAST
from network.platform.parallel import run_all


class Track(NamedTuple):
    """What the steps go from, and what could be missing there; nothing where that was not looked at."""

    begin: Hypothesis
    screened: Screening


def list_begins(levels: Sequence[Hypothesis], best: Hypothesis) -> list[Hypothesis]:
    """The best refinement, and the machine as written where that is another and not far behind."""
    written = levels[0]
    is_alone = best is written or best.chi < SETTINGS.noise or written.chi > SETTINGS.hopeless * best.chi
    return [best] if is_alone else [best, written]


def list_tracks(
    null: Hypothesis, written: Hypothesis, begins: Sequence[Hypothesis], seed: int, jobs: int
) -> Iterator[Track]:
    """Those of what steps may go from, each screened when it is asked for: that of the null, then the others; before
    it that of the machine as written where one thing explains everything there."""
    is_first = _may_hide(null, written) and _is_explained(on_few_runs(written, SEARCHED), jobs)
    if is_first:
        yield _screen(written, seed, jobs)
    yield _screen(null, seed, jobs)
    yield from (_screen(h, seed, jobs) for h in begins if not (is_first or h is null))


def _screen(h: Hypothesis, seed: int, jobs: int) -> Track:
    is_told = not leaves_something(h) and h.machine.lumps > MANY and h.case.budget.is_prepared()
    return Track(h, Screening(h) if is_told else screen_candidates(h, seed, jobs))


def _may_hide(null: Hypothesis, written: Hypothesis) -> bool:
    """Whether finer lumps than those of a machine of few leave much, however far behind these are, and there is time to
    look at these first."""
    is_other = null.machine.lumps > written.machine.lumps and not null.case.budget.is_prepared()
    return is_other and null.chi > SETTINGS.adequate and written.machine.lumps <= SMALL


def _is_explained(h: Hypothesis, jobs: int) -> bool:
    """Whether one candidate leaves nothing; only those are fitted that show half of that where they are proposed, and
    to the end those of the best that soon leave hardly anything."""
    scores = score_candidates(h.linearised, candidates(h.machine, h.case.drivers, runs=h.case.runs), h.values, jobs)
    likely = [s for s in scores if share_shown(h, s.gain) >= SETTINGS.half]
    if not likely:
        return False
    (trials,) = start_trials(h, [s.candidate for s in likely], likely, jobs)
    begun = best_first(*trials.fits)[:LEAST]
    further = run_all(trials.fit_further, begun, jobs)
    near = [trial for trial, h in zip(begun, further, strict=True) if h is not None and h.chi <= SETTINGS.adequate]
    return any(h.chi <= SETTINGS.noise for h in replace(trials, fits=tuple(near)).rank(jobs))
