"""A search beside relays whose modes the recordings tell, and back to relays that switch by what they watch.

What is missing makes a simulated relay fall out of step, and then nothing can be believed. So a search stands on the
modes that were read (recorded_modes), and only what it comes to has to keep its relays in step by itself: that is what
is written, and what simulated runs are told by.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.growing_horizon import LEAP, begin_in_step, has_relays
from network.analysis.calibration.null import Null
from network.analysis.calibration.recorded_modes import forget_modes, read_modes
from network.analysis.diagnosis.hypothesis import (
    Case,
    Hypothesis,
    fit_findings,
    fit_hypothesis,
    parameters_of,
    reweight,
    settle_hypothesis,
    state,
)
from network.analysis.diagnosis.time_budget import TimeBudget
from network.engine.response.parameters import values_at


def follow_modes(case: Case, calibrated: Null) -> Case:
    """The case with the modes of the machine's relays, where all recordings tell these and the machine comes no farther
    from them than with relays that are simulated; else about the constants of the runs with which these keep step."""
    if not has_relays(case.machine):
        return case
    alone = replace(case, began=tuple(d.point for d in calibrated.fit.at.problem.data))
    followed = replace(case, recordings=read_modes(case.machine, case.recordings))
    if not followed.recordings[0].modes:
        return alone
    left = state(alone, case.machine, calibrated.values).chi
    return followed if fit_written(followed, calibrated).chi <= LEAP * max(left, 1.0) else alone


def fit_written(case: Case, calibrated: Null) -> Hypothesis:
    """The machine as written, fitted from its calibrated numbers; where modes are followed, from those of the file,
    too, for relays out of step bend the others."""
    fits = [fit_hypothesis(case, case.machine, start=calibrated.values)]
    if case.recordings[0].modes:
        fits.append(fit_hypothesis(case, case.machine))
    return max(fits, key=lambda h: h.evidence)


def face_relays(h: Hypothesis) -> Hypothesis:
    """A hypothesis whose relays switch by what they watch, at numbers that keep them in step; itself where they do."""
    if not h.case.recordings[0].modes:
        return h
    is_late = partial(h.case.budget.is_past, 1.0)
    recordings = tuple(forget_modes(h.case.recordings))
    case = replace(h.case, recordings=recordings, began=move_points(h.fit), budget=TimeBudget())
    direct = fit_findings(case, h.root, h.found, h.values) or reweight(case, h)
    if direct.chi <= LEAP * max(h.chi, 1.0):
        return direct
    parameters = parameters_of(h.machine, h.own)
    begin = begin_in_step(h.machine, parameters, case.lay_out(h.machine), case.start, is_late)
    if begin is None:
        return direct
    about, values = replace(case, began=begin.points), values_at(parameters, begin.theta)
    led = fit_findings(about, h.root, h.found, values)
    return direct if led is None else max(direct, settle_hypothesis(led), key=lambda fit: fit.evidence)
