"""A hypothesis on the runs that it tells worst: what is only to be compared need not be fitted to all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from network.analysis.diagnosis.hypothesis import Hypothesis, reweight

FEW = 2
"""Runs on which every trial begins, those told worst."""


def list_worst_runs(h: Hypothesis) -> list[int]:
    """A few of the runs, those that it tells worst, in their order; all where they are few."""
    first, left = 0, []
    for whiten in h.fit.problem.whiteners:
        rows = sum(len(root) for root in whiten.roots)
        left.append(float(np.mean(h.fit.left[first : first + rows] ** 2)))
        first += rows
    return sorted(np.argsort(left)[-FEW:].tolist())


def on_few_runs(h: Hypothesis) -> Hypothesis:
    """A hypothesis on the runs that it tells worst, where there are many."""
    if len(h.case.recordings) <= FEW:
        return h
    case = h.case.of(list_worst_runs(h))
    return reweight(case, replace(h, case=case))
