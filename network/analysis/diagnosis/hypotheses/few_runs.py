"""A hypothesis on the runs that it tells worst: what is only to be compared need not be fitted to all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from network.analysis.calibration.gauss_newton import STEPS
from network.analysis.diagnosis.hypotheses.hypothesis import Hypothesis
from network.analysis.diagnosis.hypotheses.hypothesis_fit import fit_findings, reweight, settle_hypothesis
from network.analysis.diagnosis.time_budget import TimeBudget

FEW, SEARCHED = 2, 3
"""Runs on which every trial begins, and on which the steps of a search are taken, those told worst: the others test
what was chosen."""
FINISHED = 8
"""Steps of what is told because the time is up (budget)."""


def list_worst_runs(h: Hypothesis, count: int = FEW) -> list[int]:
    """A few of the runs, those that it tells worst, in their order; all where they are few."""
    first, left = 0, []
    for whiten in h.fit.problem.whiteners:
        rows = sum(len(root) for root in whiten.roots)
        left.append(float(np.mean(h.fit.left[first : first + rows] ** 2)))
        first += rows
    return sorted(np.argsort(left)[-count:].tolist())


def on_few_runs(h: Hypothesis, count: int = FEW) -> Hypothesis:
    """A hypothesis on the runs that it tells worst, where there are many."""
    return h if len(h.case.recordings) <= count else on_runs(h, list_worst_runs(h, count))


def on_runs(h: Hypothesis, runs: Sequence[int]) -> Hypothesis:
    """A hypothesis on some of its runs, numbers as they are."""
    case = h.case.of(runs)
    return reweight(case, replace(h, case=case))


def on_all_runs(whole: Hypothesis, few: Hypothesis, steps: int = STEPS) -> Hypothesis:
    """What was found on few runs, fitted to all of those of another hypothesis; that one where it does not hold there.
    Relays are led over the runs that they have not seen, about the starts that are found."""
    if not few.found:
        return whole
    if len(few.case.recordings) == len(whole.case.recordings):
        return few
    about = replace(whole.case, noise=few.case.noise, sigma=few.case.sigma)
    found = fit_findings(about, few.root, few.found, few.values, not few.switches, steps)
    if found is None:
        return whole
    return settle_hypothesis(found, whole.case.budget.is_searched) if steps == STEPS else found


def finish_in_passing(h: Hypothesis) -> Hypothesis:
    """What was fitted to all runs in passing, a few steps further, where that explains more: in what is left of the
    whole time when that of the search is up, but for what is needed to tell it."""
    if not h.found:
        return h
    larger = h.machine.lumps / h.case.machine.lumps
    case, budget = replace(h.case, budget=TimeBudget()), h.case.budget
    if budget.is_ended(larger):
        return h
    told = fit_findings(case, h.root, h.found, h.values, steps=FINISHED, until=lambda at: budget.is_ended(larger))
    return h if told is None or told.evidence < h.evidence else replace(told, case=h.case)
