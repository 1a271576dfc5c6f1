"""Is it one machine? Whether each run by itself wants the numbers that the other runs want.

Of run r alone a number is θ_r ± σ_r, of the others together their mean weighed by 1/σ²; the difference in its own
standard errors is beyond z only once in LEVEL for a whole machine where all runs are of one (Bonferroni over runs and
numbers). Every σ counts with the misfit and how long it lasts. Where relays switch, a run by itself begins in
step, at the start that all runs together found for it: out of step it would want other numbers for want of cycles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.special import ndtri

from network.analysis.calibration.expansion_point import move_points
from network.analysis.calibration.gauss_newton import make_problem, minimise
from network.analysis.calibration.growing_horizon import has_relays, settle_starts
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.misfit import lasting_misfit
from network.analysis.calibration.null import Null
from network.analysis.calibration.uncertainty import covariance
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter
from network.platform.parallel import run_all
from network.platform.refusal import Failed

LEVEL = 0.01
STEPS = 12


@dataclass(frozen=True)
class Disagreement:
    """A number that runs want differently. theta, std: by run's file (logarithms, or the number itself); sigma: the
    largest difference of one from the others, in its standard errors."""

    parameter: Parameter
    theta: Mapping[str, float]
    std: Mapping[str, float]
    sigma: float

    def summary(self) -> dict[str, Any]:
        p = self.parameter
        values = [{"file": file, "value": p.to_unit(p.value(x)), "std": p.std_to_unit(p.std(x, self.std[file]))}
                  for file, x in self.theta.items()]  # fmt: skip
        return {"path": p.path, "unit": p.field.unit, "values": values, "sigma": self.sigma}


def find_disagreements(null: Null, jobs: int = 1) -> tuple[Disagreement, ...]:
    """Numbers of a null that its runs want differently, the gravest first; none with a single run. jobs: processes."""
    problem = null.fit.at.problem
    data = (problem.about(move_points(null.fit.at)) if has_relays(null.original) else problem).data
    if len(data) < 2 or not null.parameters:
        return ()
    fits = zip(data, run_all(partial(_fit_alone, null), data, jobs), strict=True)
    alone = [(d.recording.file, *found) for d, found in fits if found is not None]
    if len(alone) < 2:
        return ()
    theta, std = (np.array([a[i] for a in alone]) for i in (1, 2))
    z = np.array([_apart(theta, std, r) for r in range(len(alone))])
    most = float(-ndtri(LEVEL / 2 / z.size))
    told = [_disagreement(null.parameters[j], [a[0] for a in alone], theta[:, j], std[:, j], float(z[:, j].max()))
            for j in np.flatnonzero(z.max(axis=0) > most)]  # fmt: skip
    return tuple(sorted(told, key=lambda d: -d.sigma))


def _disagreement(p: Parameter, files: Sequence[str], theta: Array, std: Array, sigma: float) -> Disagreement:
    pairs = [dict(zip(files, values.tolist(), strict=True)) for values in (theta, std)]
    return Disagreement(p, pairs[0], pairs[1], sigma)


def _fit_alone(null: Null, data: Measured) -> tuple[Array, Array] | None:
    """θ and its 1σ by one run alone; None where it runs away."""
    problem = make_problem(null.original, null.parameters, [data], null.fit.noise)
    try:
        at = settle_starts(minimise(problem, null.fit.at.theta, STEPS), STEPS)
    except Failed:
        return None
    return at.theta, np.sqrt(np.diag(covariance(at, lasting_misfit(at))))[: at.free]


def _apart(theta: Array, std: Array, r: int) -> Array:
    """How far a run's numbers are from those of the others, in standard errors of the difference."""
    weights = np.delete(std, r, axis=0) ** -2.0
    total = weights.sum(axis=0)
    mean = (weights * np.delete(theta, r, axis=0)).sum(axis=0) / total
    return np.asarray(np.abs(theta[r] - mean) / np.sqrt(std[r] ** 2 + 1 / total))
