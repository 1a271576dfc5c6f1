"""Backward: what was found is judged again beside the others, each is taken out once, and runs are left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np

from network.analysis.diagnosis.candidates.candidate import Candidate
from network.analysis.diagnosis.hypotheses.case_noise import estimate_noise
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis, SameFit
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, reweight
from network.analysis.diagnosis.latent_heat.latent_rest import Rest, find_rest, share_of_rest
from network.analysis.diagnosis.lumps.coarse_surrogate import build_surrogate
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.ranking import best_of
from network.analysis.diagnosis.steps.rival_acceptance import is_worth
from network.analysis.diagnosis.steps.selection import Selection
from network.analysis.diagnosis.steps.strength import errors_from_nothing
from network.analysis.diagnosis.steps.unseen_runs import Unseen, tell_all_unseen, tell_unseen
from network.platform.parallel import run_all

STEPS = 8
"""Of a fit with other findings."""


def check_selection(null: Hypothesis, now: Selection, jobs: int) -> Selection:
    """What was chosen, tested again: without what is superfluous beside the others under the noise that is left in the
    end, and without what does not help to tell runs that were left out; the null where nothing of it holds, or all of
    it explains next to nothing of these. Findings that hold only together are not taken apart for what heat of any
    course could do in the stead of one of them."""
    if not now.best.found:
        return replace(now, best=null, is_checked=True)
    told = _keep_what_holds(null, now, jobs)
    if not told.best.found and len(now.best.found) > 1:
        together = _keep_what_holds(null, now, jobs, is_apart=False)
        return together if together.best.found else told
    return told


def _keep_what_holds(null: Hypothesis, now: Selection, jobs: int, is_apart: bool = True) -> Selection:
    """The same; is_apart: whether each of several has to add something beside heat of any course."""
    current, gains = _eliminate_at_end(now, jobs, is_apart)
    if not current.found:
        return Selection(_bare_or_null(null, current), threshold=now.threshold, is_checked=True)
    before = reweight(current.case, null)
    current, gains, explained = _keep_what_predicts(before, current, gains, jobs)
    if explained < 1 - SETTINGS.covered:
        return Selection(before, threshold=now.threshold, is_checked=True)
    added, share = _weigh_rest(before, current)
    return replace(
        now, best=current, gains=gains, is_checked=True, explained=explained, added=added, share_of_rest=share
    )


def _weigh_rest(before: Hypothesis, current: Hypothesis) -> tuple[float, float]:
    """What all findings add beside heat of any course [nats], and by what share they lower its variance."""
    alone, beside = find_rest(before), find_rest(current)
    return beside.evidence - alone.evidence, share_of_rest(alone, beside)


def _keep_what_predicts(
    before: Hypothesis, current: Hypothesis, gains: tuple[float, ...], jobs: int
) -> tuple[Hypothesis, tuple[float, ...], float]:
    """The findings without which runs that were left out are less likely, heat of any course beside them or not, the
    gain of each, and the share of the misfit before that they take away there."""
    ends = (before, current) if current.found else (before,)
    first = tell_all_unseen([build_surrogate(h) for h in ends], jobs)
    start, now = first[0], first[-1]
    while current.found:
        less = [_without(before, current, out) for out in current.found]
        able = iter(tell_all_unseen([build_surrogate(h) for h in less if h is not None and h.found], jobs))
        told = [Unseen.broken() if h is None else next(able) if h.found else start for h in less]
        gains_without = [_gain_without(current, out, unseen, now, jobs)
                         for out, unseen in zip(current.found, told, strict=True)]  # fmt: skip
        k = int(np.argmax(gains_without))
        if (other := less[k]) is None or gains_without[k] < 0:
            break
        current, now, gains = other, told[k], (*gains[:k], *gains[k + 1 :])
    return current, gains, share_explained(start.chi, now.chi)


def _gain_without(current: Hypothesis, out: Candidate, without: Unseen, whole: Unseen, jobs: int) -> float:
    """By how much more likely runs that were left out are without a finding (out) than with all [nats]. A relay falls
    out of step in them, however true it is: beside it, too, there may be as much heat as there is without it."""
    gain = without.gain_over(whole)
    if gain < 0 or not out.switches or not np.isfinite(gain) or not any(without.heats):
        return gain
    return without.gain_over(tell_unseen(build_surrogate(current), jobs, heats=without.heats))


def _without(before: Hypothesis, current: Hypothesis, out: Candidate) -> Hypothesis | None:
    return _leave_out(SameFit(current), out.key) if len(current.found) > 1 else before


def _leave_out_briefly(current: Hypothesis, out: Candidate) -> Hypothesis | None:
    found = _leave_out(SameFit(current), out.key)
    return found and compact(found)


@lru_cache(maxsize=4)
def _leave_out(same: SameFit, out: tuple[str, ...]) -> Hypothesis | None:
    """A hypothesis without one of its findings, which is asked for by each test of them."""
    current = same.of
    rest = [c for c in current.found if c.key != out]
    return fit_findings(current.case, current.root, rest, current.values, steps=STEPS)


def share_explained(before: float, after: float) -> float:
    """Of the excess χ² − 1 of a misfit, what is gone."""
    return float(np.clip((before**2 - after**2) / max(before**2 - 1, 1e-9), 0.0, 1.0))


def _refit_with(current: Hypothesis, other: tuple[Sequence[Candidate], Mapping[str, float]]) -> Hypothesis | None:
    """Other findings from some numbers in the stead of those of a hypothesis."""
    found = fit_findings(current.case, current.root, *other, steps=STEPS)
    return found and compact(found)


def _eliminate_at_end(now: Selection, jobs: int, is_apart: bool) -> tuple[Hypothesis, tuple[float, ...]]:
    """The findings that still add what chance does not, under the noise that they leave in the end, on the final lumps
    and beside each other, and how much."""
    current = now.best
    while True:
        count = len(current.found)
        about = reweight(estimate_noise(current.case, current), current)
        current, gains = _eliminate(about, now, jobs, is_apart)
        if len(current.found) in (0, count):
            return current, gains


def _bare_or_null(null: Hypothesis, bare: Hypothesis) -> Hypothesis:
    """The null, or its machine on the finer lumps that were come to with findings, where these mend it alone."""
    before = reweight(bare.case, null)
    return bare if bare.evidence > before.evidence + SETTINGS.structure else before


def _eliminate(current: Hypothesis, now: Selection, jobs: int, is_apart: bool) -> tuple[Hypothesis, tuple[float, ...]]:
    """Without the findings that add less than the threshold beside the others, may as well not be there, are not worth
    a name any more, or are one of several and, if each has to (is_apart), add nothing beside heat of any course or do
    not show where they were not chosen; and the evidence that each of the rest adds."""
    gains: list[float] = []
    while current.found:
        less = run_all(partial(_leave_out_briefly, current), current.found, jobs)
        rest = find_rest(current) if is_apart and len(current.found) > 1 else None
        tried = [
            (c, h, rest is not None and _is_of_one_half(now, c) and not _completes(h, now.best))
            for c, h in zip(current.found, less, strict=True)
        ]
        gains = [-np.inf if out else np.inf if h is None else _gain_over(current, h, rest, c) for c, h, out in tried]
        k = _find_weakest(current, less, gains)
        other = less[k]
        if other is None or gains[k] >= now.threshold:
            break
        current = finish_fit(other)
    return current, tuple(gains) if current.found else ()


def _find_weakest(current: Hypothesis, less: Sequence[Hypothesis | None], gains: Sequence[float]) -> int:
    """What adds least; of several that add nothing, what leaves the least evidence behind that goes with it."""
    lost = [np.inf if h is None else current.evidence - h.evidence for h in less]
    return min(range(len(gains)), key=lambda k: (gains[k], lost[k]))


def _is_of_one_half(now: Selection, c: Candidate) -> bool:
    """Whether recordings that a finding was not chosen on speak against its step, or, where it was looked for beside
    another, do not choose it, too."""
    test = now.unseen_of(c)
    if test is None:
        return False
    return test.speaks_against if now.step_of(c) == 0 else not test.shows_again


def _completes(less: Hypothesis | None, whole: Hypothesis) -> bool:
    """Whether without a finding so much is left that no linear score about the rest can be believed, and with it
    nothing under the noise of the steps."""
    return less is not None and less.chi > SETTINGS.doubtful and whole.chi <= SETTINGS.noise


def _gain_over(current: Hypothesis, less: Hypothesis, rest: Rest | None, out: Candidate) -> float:
    """Evidence that a finding (out) adds to a hypothesis without it; none where it may as well not be there, is not
    worth a name any more, or where heat of any course (rest: beside all that was found) tells what is left as well
    without it."""
    gain = current.evidence - less.evidence
    if errors_from_nothing(gain, current.chi) < SETTINGS.errors or not is_worth(less, current):
        return -np.inf
    imitates = rest is not None and is_imitation(rest, less, out.is_steady)
    return -np.inf if imitates else gain


def is_imitation(whole: Rest, less: Hypothesis, is_steady: bool = False) -> bool:
    """Whether a finding (with it: whole, without: less) adds nothing beside heat of any course; a steady heat is one of
    these courses, so that it adds nothing where another of them tells more."""
    return whole.evidence - find_rest(less).evidence < (0.0 if is_steady else SETTINGS.alike)


def refit_best(
    current: Hypothesis, others: Sequence[tuple[Sequence[Candidate], Mapping[str, float]]], jobs: int
) -> Hypothesis:
    """The best of other findings, each from some numbers, in the stead of those of a hypothesis, fitted to the
    end; that itself where none explains more."""
    told = run_all(partial(_refit_with, current), others, jobs)
    better = best_of(current, *told) or current
    return current if better is current else finish_fit(better)


def finish_fit(h: Hypothesis) -> Hypothesis:
    return fit_findings(h.case, h.root, h.found, h.values) or h
