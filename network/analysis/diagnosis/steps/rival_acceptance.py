"""Which of the rivals of a step is kept: what comes near the best, tells unseen runs, and gains more than chance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.compact_fit import compact
from network.analysis.diagnosis.hypotheses.fresh_fit import fit_afresh
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import reweight
from network.analysis.diagnosis.hypotheses.initial_state_restarts import restart_from_starts
from network.analysis.diagnosis.lumps.coarse_surrogate import fit_on_finer_lumps, fit_on_finer_lumps_afresh
from network.analysis.diagnosis.lumps.lump_convergence import refine_until_converged
from network.analysis.diagnosis.screening.timed_search import settle_instants
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.steps.placement import near, place_best
from network.analysis.diagnosis.steps.ranking import best_of, distinct, leave_out, weigh_on_lumps
from network.analysis.diagnosis.steps.unseen_runs import tell_all_unseen
from network.machine.machine import Machine
from network.platform.parallel import run_all

INTERIM_STEPS = 2
"""Steps of what is told if there is no time for more, on finer lumps or on all runs."""
CARRIED = 3
"""Rivals that are fitted again on the finer lumps, or asked what they tell of runs that they have not seen."""


def take_first(
    current: Hypothesis, before: Hypothesis, ranked: Sequence[Hypothesis], threshold: float
) -> Hypothesis | None:
    """The best of some explanations as it is, on the lumps of what is there; None where it gains no more than
    chance."""
    if not ranked or not is_gain(before, ranked[0], threshold):
        return None
    best = ranked[0]
    if before is current:
        return reweight(best.case, best)
    return fit_on_finer_lumps(replace(current.case, lacking=()), best, current.root, INTERIM_STEPS)


def list_contenders(
    current: Hypothesis, before: Hypothesis, ranked: Sequence[Hypothesis], lead: Hypothesis | None, jobs: int
) -> Sequence[Hypothesis]:
    """Those of the rivals that may be kept: the best, and what comes near it if all were fitted on coarser lumps; lead:
    what shows most on finer ones, where it is not among these."""
    able = _skip_misleading(before, ranked, jobs)
    if before is current:
        return able[:1]
    close = near(before, able, CARRIED)
    return close if lead is None else [*close, *leave_out(close, [lead])]


def _skip_misleading(before: Hypothesis, ranked: Sequence[Hypothesis], jobs: int) -> Sequence[Hypothesis]:
    """Rivals from the first on that explains at least half as much of runs that it has not seen as the best of those
    that may be kept, where much is left: what only bends itself to the runs is no reason to leave out the next. As they
    are where none of the best tells these better than without it."""
    if not ranked or ranked[0].chi <= SETTINGS.adequate:
        return ranked
    rivals = [h for h in distinct(ranked) if is_worth(before, h)][:CARRIED]
    if not rivals:
        return ranked
    least, *left = (told.chi**2 for told in tell_all_unseen([before, rivals[0]], jobs, with_rest=False))
    if left[0] > SETTINGS.half * least:  # else the first goes on, whatever the next ones explain
        left += [told.chi**2 for told in tell_all_unseen(rivals[1:], jobs, with_rest=False)]
    most = least - SETTINGS.half * max(0.0, least - min(left))
    told = next((h for h, misfit in zip(rivals, left, strict=False) if misfit <= most), rivals[0])
    return ranked[[*ranked].index(told) :]


def accept_best(
    current: Hypothesis, before: Hypothesis, ranked: Sequence[Hypothesis], tried: Sequence[Hypothesis],
    threshold: float, jobs: int,
) -> tuple[Hypothesis | None, list[Hypothesis]]:  # fmt: skip
    """The best of some rivals on as many lumps as it takes, None where it gains no more than chance; and all of them,
    weighed."""
    fitted = _fit_contenders(current, before, tried, jobs)
    weighed, best = weigh_on_lumps(ranked, tried, fitted), best_of(*fitted)
    best = best and reweight(best.case, best)
    if best is None or not is_gain(current, best, threshold):
        return None, weighed
    best = restart_from_starts(settle_instants(fit_afresh(best)), jobs)
    return refine_until_converged(best.case, best, jobs), weighed


def _fit_contenders(
    current: Hypothesis, before: Hypothesis, rivals: Sequence[Hypothesis], jobs: int
) -> Sequence[Hypothesis | None]:
    """Rivals on the lumps of what is there; None for one that does not fit there."""
    if before is current or not rivals:
        return rivals
    case = replace(current.case, lacking=())
    return run_all(partial(_fit_on_lumps, case, current.root, rivals[0]), rivals, jobs)


def _fit_on_lumps(case: Case, root: Machine, first: Hypothesis, h: Hypothesis) -> Hypothesis | None:
    told = (fit_on_finer_lumps_afresh if h.found[-1].key == first.found[-1].key else fit_on_finer_lumps)(case, h, root)
    return told and compact(place_best(told))


def is_gain(before: Hypothesis, after: Hypothesis, threshold: float) -> bool:
    """More evidence than chance gives, and a misfit that is worth a name, or sensors that are not far off any more."""
    return after.evidence - before.evidence > threshold and is_worth(before, after)


def is_worth(before: Hypothesis, after: Hypothesis) -> bool:
    """Whether a hypothesis takes away as much as a name is worth, or lets sensors come back that were far off."""
    is_relief = before.offset_pull > SETTINGS.strained and after.offset_pull < SETTINGS.errors
    return is_relief or after.chi < before.chi * (1 - SETTINGS.worth)
