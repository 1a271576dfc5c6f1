"""The starts that both sets of runs find, where something switches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from network.analysis.calibration.growing_horizon import CLOSE, ROUNDS, has_relays
from network.analysis.calibration.measured_means import RunPoint
from network.analysis.calibration.problem import Problem
from network.analysis.change.paired_fit import PairedFit, fit_sets
from network.analysis.change.run_information import WeighedRun


def settle_sets(at: PairedFit) -> PairedFit:
    """The fit about the starts that it finds, as often as that lowers J: what switches hangs on where a part began, and
    not along a straight line. The same of a machine without relays."""
    if not has_relays(at.sets.machine):
        return at
    for _ in range(ROUNDS):
        one, other = (problem.about([*_points(problem, runs)])
                      for problem, runs in zip(at.sets.problems, at.runs, strict=True))  # fmt: skip
        new = fit_sets(replace(at.sets, problems=(one, other)), at.split, at)
        if not new.cost < at.cost - CLOSE:
            return at
        at = new
    return at


def _points(problem: Problem, runs: Sequence[WeighedRun]) -> Iterator[RunPoint]:
    """Every run about the temperatures of its parts at the start as a fit finds them."""
    for d, run in zip(problem.data, runs, strict=True):
        prior = np.array([n.mean for n in d.starts])
        yield RunPoint(d.move_start(prior + run.moved[: len(d.starts)]))
