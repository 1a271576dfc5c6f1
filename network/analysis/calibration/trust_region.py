"""A step towards the least of a quadratic, within a radius and bounds.

The step solves (P + λ U⁻²) δ = g, P the precision, g = −½ of the gradient, U the units of the numbers, with the least λ
for which |U⁻¹ δ| stays within the radius; where a bound is in the way, it is the best within the bounds at that λ.
Source: Moré, The Levenberg–Marquardt algorithm, Lecture Notes in Mathematics 630 (1978) 105; unverified.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import brentq, lsq_linear

from network.catalogue.declaration.declare import Array

LEAST_DAMPING = 1e-7
"""λ at least."""
LOOSE = 1e-2
"""ln λ to which the radius is kept."""


def bounded_step(precision: Array, gradient: Array, units: Array, radius: float, bounds: tuple[Array, Array]) -> Array:
    """The step (numbers); bounds: the least and the most that every number may move."""
    values, vectors = np.linalg.eigh(precision * np.outer(units, units))
    values, toward = np.maximum(values, 0.0), vectors.T @ (units * gradient)
    damping = _damp(values, toward, radius)
    step = np.asarray(units * (vectors @ (toward / (values + damping))))
    down, up = bounds
    if ((step >= down) & (step <= up)).all():
        return step
    root = cholesky(precision + damping * np.diag(units**-2.0), lower=True)
    toward = solve_triangular(root, gradient, lower=True)
    return np.asarray(np.clip(lsq_linear(root.T, toward, (down, up), "bvls").x, down, up))


def length_of(step: Array, units: Array) -> float:
    """|U⁻¹ δ|."""
    return float(np.linalg.norm(step / units))


def _damp(values: Array, toward: Array, radius: float) -> float:
    """The λ with |toward / (values + λ)| = radius; the least where the step is shorter without."""

    def excess(log: float) -> float:
        return float(np.log(np.linalg.norm(toward / (values + np.exp(log))) / radius))

    least = np.log(LEAST_DAMPING)
    if np.isinf(radius) or not toward.any() or excess(least) <= 0:
        return LEAST_DAMPING
    return float(np.exp(brentq(excess, least, np.log(np.linalg.norm(toward) / radius), xtol=LOOSE)))
