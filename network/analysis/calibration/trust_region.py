"""A step towards the least of a quadratic, within a radius and bounds.

The step solves (P + λ U⁻²) δ = g, P the precision, g = −½ of the gradient, U the units of the numbers, or is the best
within the bounds at that λ, with the least λ for which |U⁻¹ δ| stays within the radius: what pulls at a number that
stands at its bound shortens no step of the others. With 0 within the bounds |U⁻¹ δ| is at most |U g| / λ.
Source: Moré, The Levenberg–Marquardt algorithm, Lecture Notes in Mathematics 630 (1978) 105; unverified.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.optimize import brentq, lsq_linear

from network.catalogue.declaration.declare import Array

LEAST_DAMPING = 1e-7
"""λ at least."""
NO_STEP = 1e-300
"""A length whose logarithm is a number."""
LOOSE, LOOSE_BOUNDED = 1e-2, 0.1
"""ln λ to which the radius is kept, and beside bounds."""


def bounded_step(precision: Array, gradient: Array, units: Array, radius: float, bounds: tuple[Array, Array]) -> Array:
    """The step (numbers); bounds: the least and the most that every number may move."""
    values, vectors = np.linalg.eigh(precision * np.outer(units, units))
    values, toward = np.maximum(values, 0.0), vectors.T @ (units * gradient)
    step = np.asarray(units * (vectors @ _step_within(lambda log: toward / (values + np.exp(log)), toward, radius)))
    down, up = bounds
    if ((step >= down) & (step <= up)).all():
        return step
    room = down / units, up / units

    @cache
    def bound(log: float) -> Array:
        root = np.sqrt(values + np.exp(log))
        found = lsq_linear(root[:, None] * vectors.T, toward / root, room, "bvls").x
        return np.asarray(np.clip(found, *room))

    return np.asarray(np.clip(units * _step_within(bound, toward, radius, LOOSE_BOUNDED), down, up))


def length_of(step: Array, units: Array) -> float:
    """|U⁻¹ δ|."""
    return float(np.linalg.norm(step / units))


def _step_within(at: Callable[[float], Array], toward: Array, radius: float, loose: float = LOOSE) -> Array:
    """The step at the least ln λ at which it is no longer than the radius."""

    def excess(log: float) -> float:
        return float(np.log(max(float(np.linalg.norm(at(log))), NO_STEP) / radius))

    least = float(np.log(LEAST_DAMPING))
    if np.isinf(radius) or not toward.any() or excess(least) <= 0:
        return at(least)
    return at(float(brentq(excess, least, np.log(np.linalg.norm(toward) / radius), xtol=loose)))
