"""A search beside relays whose modes the recordings tell, and back to relays that switch by what they watch.

What is missing makes a simulated relay fall out of step, and then nothing can be believed. So a search stands on the
modes that were read (recorded_modes), and only what it comes to has to keep its relays in step by itself: that is what
is written, and what simulated runs are told by.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.gauss_newton import STEPS
from network.analysis.calibration.growing_horizon import LEAP, InStep, begin_in_step, has_relays, know_left_over
from network.analysis.calibration.null import Null
from network.analysis.calibration.recorded_modes import forget_modes, read_modes
from network.analysis.diagnosis.hypotheses.case import Case
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import (
    fit_findings,
    fit_hypothesis,
    parameters_of,
    reweight,
    settle_hypothesis,
    theta_of,
)
from network.analysis.diagnosis.settings import SETTINGS
from network.analysis.diagnosis.time_budget import TimeBudget
from network.engine.response.parameters import values_at

WRITTEN = 2
"""Times the share of the null after which the machine as written is not fitted further (budget)."""
BRIEF = 5
"""Steps beside relays that switch by themselves where there is no time (budget)."""


def keep_in_step(case: Case, calibrated: Null) -> Case:
    """The case of a machine with relays about the constants of the runs with which these keep step."""
    if not has_relays(case.machine):
        return case
    return replace(case, began=tuple(d.point for d in calibrated.fit.at.problem.data))


def fit_written(calibrated: Hypothesis) -> Hypothesis:
    """The machine as written, fitted from its calibrated numbers: beside the modes of its relays, where all recordings
    tell these and it comes no farther from them so than with relays that are simulated; else as far as it comes
    in its time, for what is missing may bend numbers ever on."""
    case, values = calibrated.case, calibrated.values
    recordings = read_modes(case.machine, case.recordings)
    if recordings[0].modes:
        followed = _fit_beside_modes(replace(case, recordings=recordings, began=()), values)
        if followed.chi <= LEAP * max(calibrated.chi, 1.0):
            return followed
    most = WRITTEN * SETTINGS.calibrated
    return fit_hypothesis(case, case.machine, start=values, until=lambda at: case.budget.is_past(most))


def _fit_beside_modes(case: Case, values: Mapping[str, float]) -> Hypothesis:
    """The better of the fits from these numbers and from those of the file, for relays out of step bend the others."""
    fits = (fit_hypothesis(case, case.machine, start=start) for start in (values, None))
    return max(fits, key=lambda h: h.evidence)


def begin_near(h: Hypothesis) -> InStep:
    """The numbers of a hypothesis whose relays are in step, and its constants of the runs, as a beginning, with what it
    leaves over any share of them."""
    own, there = h.fit.problem.parameters, InStep(h.fit.theta, move_points(h.fit))
    known = know_left_over(h.machine, own, h.case.recordings, h.case.start, there)
    return InStep(theta_of(parameters_of(h.machine, h.own), h.values), there.points, known)


def face_relays(h: Hypothesis, is_brief: bool = False) -> Hypothesis:
    """A hypothesis whose relays switch by what they watch, at numbers that keep them in step; itself where they do.
    is_brief: not led back into step where a few steps do not do that."""
    if not h.case.recordings[0].modes:
        return h

    def is_late() -> bool:
        return is_brief or h.case.budget.is_past(1.0)

    recordings = forget_modes(h.case.recordings)
    case = replace(h.case, recordings=recordings, began=move_points(h.fit), budget=TimeBudget())
    near = fit_findings(case, h.root, h.found, h.values, steps=BRIEF if is_brief else STEPS)
    direct = settle_hypothesis(near or reweight(case, h), is_late)
    if direct.chi <= LEAP * max(h.chi, 1.0) or is_brief:
        return direct
    parameters = parameters_of(h.machine, h.own)
    begin = begin_in_step(h.machine, parameters, case.lay_out(h.machine), case.start, is_late, about=begin_near(h))
    if begin is None:
        return direct
    about, values = replace(case, began=begin.points), values_at(parameters, begin.theta)
    led = fit_findings(about, h.root, h.found, values)
    return direct if led is None else max(direct, settle_hypothesis(led, is_late), key=lambda fit: fit.evidence)
