"""A step towards the least of a quadratic, within a radius and bounds.

The step solves (P + λ U⁻²) δ = g, P the precision, g = −½ of the gradient, U the units of the numbers, with the least λ
for which |U⁻¹ δ| stays within the radius; where a bound is in the way, it is the best within the bounds at the least λ
for which that does: what pulls at a number that stands at its bound shortens no step of the others.
Source: Moré, The Levenberg–Marquardt algorithm, Lecture Notes in Mathematics 630 (1978) 105; unverified.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import brentq, lsq_linear

from network.catalogue.declaration.declare import Array

LEAST_DAMPING = 1e-7
"""λ at least."""
LOOSE, LOOSE_BOUNDED = 1e-2, 0.1
"""ln λ to which the radius is kept, and beside bounds."""


def bounded_step(precision: Array, gradient: Array, units: Array, radius: float, bounds: tuple[Array, Array]) -> Array:
    """The step (numbers); bounds: the least and the most that every number may move."""
    values, vectors = np.linalg.eigh(precision * np.outer(units, units))
    values, toward = np.maximum(values, 0.0), vectors.T @ (units * gradient)
    damping = _damp(values, toward, radius)
    step = np.asarray(units * (vectors @ (toward / (values + damping))))
    down, up = bounds
    if ((step >= down) & (step <= up)).all():
        return step
    return _bound(precision, gradient, units, radius, bounds, float(np.log(damping)))


def _bound(
    precision: Array, gradient: Array, units: Array, radius: float, bounds: tuple[Array, Array], most: float
) -> Array:  # fmt: skip
    """The best step within the bounds with the least ln λ, up to the most, at which it stays within the radius."""

    def at(log: float) -> Array:
        root = cholesky(precision + np.exp(log) * np.diag(units**-2.0), lower=True)
        toward = solve_triangular(root, gradient, lower=True)
        return np.asarray(np.clip(lsq_linear(root.T, toward, bounds, "bvls").x, *bounds))

    def excess(log: float) -> float:
        return float(np.log(max(length_of(at(log), units), 1e-300) / radius))

    least = float(np.log(LEAST_DAMPING))
    if most <= least or excess(most) >= 0:
        return at(most)
    if excess(least) <= 0:
        return at(least)
    return at(brentq(excess, least, most, xtol=LOOSE_BOUNDED))


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
