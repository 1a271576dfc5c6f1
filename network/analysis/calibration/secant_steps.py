"""Steps of a fit, and further ones whose slopes by θ are not found anew but carried along by what each step has shown.

With s a step and e what the run changed by beside s S, the slopes S become S + U⁻²s eᵀ / (sᵀ U⁻² s), U the units of the
numbers: the least change of them that tells this step. Source: Broyden, Mathematics of Computation 19 (1965) 577, as
used in multi-response fits by Nocedal & Wright, Numerical Optimization, 2nd ed., ch. 11.1; unverified.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.arrow_matrix import Part
from network.analysis.calibration.linearised import Linearised, residual_of
from network.analysis.calibration.slopes import Slopes
from network.analysis.calibration.trust_region import bounded_step
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter
from network.platform.refusal import Failed

FAITHFUL = (0.7, 1.4)
"""Shares of the expected gain between which slopes tell so well what a step does that they are carried along."""


@dataclass(frozen=True, eq=False)
class Step:
    """change: of θ; expected: by how much J is to fall; descent: what it would by its slope alone, halved."""

    change: Array
    expected: float
    descent: float


def propose_step(at: Linearised, radius: float, low: Array, high: Array) -> Step:
    """The step to the least of J as it is linearised, within a region and bounds; instants stay."""
    precision, gradient = at.reduced
    gradient = gradient * [not p.field.is_instant for p in at.problem.parameters]
    units, room = units_of(at.problem.parameters), (low - at.theta, high - at.theta)
    change = bounded_step(precision, gradient, units, radius, room)
    return Step(change, float(2 * change @ gradient - change @ precision @ change), float(change @ gradient))


def take_step(at: Linearised, step: Step, low: Array, high: Array) -> Linearised | None:
    """The problem after a step with the slopes from here; None where a run breaks down."""
    theta = np.clip(at.theta + step.change, low, high)
    try:
        predictions = at.problem.model.predict(theta)
    except Failed:
        return None
    residual = residual_of(at.problem, predictions)
    return at.beside(theta, residual, predictions) if np.isfinite(residual).all() else None


def is_faithful(before: Linearised, ratio: float) -> bool:
    """Whether slopes that were found there may be carried along a step that had a share of the gain that was expected
    of it; no slopes are twice, and none where relays switch."""
    low, high = FAITHFUL
    return low < ratio < high and before.made_at is None and not before.problem.model.switches


def carry_slopes(at: Linearised, before: Linearised) -> Linearised:
    """The same with slopes by θ that tell the way from where they were."""
    moved = (at.theta - before.theta) / units_of(at.problem.parameters) ** 2
    square, old, parts, first = float(moved @ (at.theta - before.theta)), at.rows.slopes, [], 0
    if square <= 0.0:
        return at
    change = before.residual - at.residual
    for part in old.parts:
        rows = slice(first, first + part.by_theta.shape[1])
        beside = change[rows] - (at.theta - before.theta) @ part.by_theta
        parts.append(Part(part.by_theta + np.outer(moved / square, beside), part.eta))
        first = rows.stop
    slopes = Slopes(tuple(parts), old.free, old.shared, old.count)
    return replace(at, rows=replace(at.rows, slopes=slopes))


def units_of(parameters: Sequence[Parameter]) -> Array:
    """In which distances in θ are told: a logarithm, or a prior 1σ."""
    return np.array([1.0 if p.is_log else p.spread for p in parameters])
