"""Heat that nothing in a machine explains, or another temperature of its surroundings, straight between knots, and what
channels answer to it."""

from __future__ import annotations

import numpy as np

from network.analysis.calibration.measured_means import Measured
from network.catalogue.declaration.declare import Array
from network.engine.balance import heat_into
from network.engine.response.linear_run import Push
from network.engine.response.prediction import Prediction

MOST_KNOTS = 60
"""Of a run."""
STEP = 0.01
"""K by which surroundings are moved for a slope."""


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


def temperature_answers(prediction: Prediction, node: str, knots: Array) -> Array:
    """The same to 1 K of a node of given temperature: the heat that flows from it per kelvin, at each instant."""
    flow = _flow_per_kelvin(prediction, node)
    K, lumps = len(flow) // 2, np.flatnonzero(flow.any(axis=0))
    begin, end = flow[:K, lumps], flow[K:, lumps]
    hats_at = zip(*(h.T[:, :, None] for h in hats(prediction, knots)), strict=True)
    return prediction.respond_to([Push(lumps, a * begin, b * end) for a, b in hats_at])


def _flow_per_kelvin(prediction: Prediction, node: str) -> Array:
    """∂(heat into the lumps)/∂T of a held node along a run [W/K], at both ends of its intervals (2 K, N)."""
    course = prediction.course
    plan, T = course.problem.plan, course.T_ends.copy()
    network, modes = plan.network, np.concatenate([plan.modes] * 2) if plan.modes is not None else np.zeros((len(T), 0))
    before = heat_into(network, T, course.inputs, modes)
    T[:, network.parts[node]] += STEP
    flow = (heat_into(network, T, course.inputs, modes) - before) / STEP
    return np.where(np.isinf(network.capacity), 0.0, flow)


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
