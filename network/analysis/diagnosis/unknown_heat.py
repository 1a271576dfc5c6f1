"""Heat that nothing in a machine explains, straight between knots, and what channels answer to it."""

from __future__ import annotations

import numpy as np

from network.analysis.calibration.measured_means import Measured
from network.catalogue.declaration.declare import Array
from network.engine.response.linear_run import Push
from network.engine.response.prediction import Prediction

MOST_KNOTS = 60
"""Of a run."""


def heat_knots(data: Measured, step: float, most: int = MOST_KNOTS) -> Array:
    """Instants at which the heat is free, some `step` [s] apart, at most so many; straight in between."""
    t = data.run.knots.t
    count = min(max(3, round(float(t[-1] - t[0]) / step) + 1), most)
    return np.linspace(t[0], t[-1], count)


def hats(prediction: Prediction, knots: Array) -> tuple[Array, Array]:
    """Hat functions on the knots, at both ends of the intervals of a run: (K, hats) each."""
    edges = prediction.course.problem.plan.edges
    values = np.stack([np.interp(edges, knots, row) for row in np.eye(len(knots))], axis=1)
    return values[:-1], values[1:]


def heat_answers(prediction: Prediction, spread: Array, knots: Array) -> Array:
    """Cell means' answers to 1 W into lumps by `spread` (N), as a hat about each knot: (hats, cells)."""
    h0, h1 = hats(prediction, knots)
    lumps = np.flatnonzero(spread)
    into = spread[None, lumps]
    pushes = [Push(lumps, a[:, None], b[:, None], (), into) for a, b in zip(h0.T, h1.T, strict=True)]
    return prediction.respond_to(pushes)


def part_spread(prediction: Prediction, part: str) -> Array:
    """One watt, evenly over the lumps of a part."""
    network = prediction.course.problem.plan.network
    spread = np.zeros(network.size)
    own = network.parts[part]
    spread[own] = 1 / (own.stop - own.start)
    return spread


def ou(knots: Array, ell: float) -> Array:
    """Correlation of heat at knots with correlation time ℓ [s]."""
    return np.exp(-np.abs(knots[:, None] - knots[None, :]) / ell)
