"""Beginnings for machines with relays: set points, hysteresis and powers that cycle as the recordings do.

A run that switches a cycle off fits worse the closer it comes, so least squares has a minimum for every cycle slipped.
How often each temperature and each rate of change occurs does not know the phase: sorted readings and sorted changes
are compared on a grid of the relays' numbers, then by a simplex. Least squares takes over from there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np
from scipy.optimize import minimize

from network.analysis.calibration.gauss_newton import Problem
from network.analysis.calibration.measured_means import Measured
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.response.parameters import Parameter
from network.engine.response.prediction import Prediction
from network.platform.refusal import Failed

POINTS, REACH = 120, 1.5
"""Points of the grid at most, and how many prior σ it reaches."""
KEPT, TRIALS, BINS = 3, 50, 300
"""Grid points that a simplex starts from, its trials, and instants that are compared."""


def relay_numbers(problem: Problem) -> list[int]:
    """Which numbers are a relay's own."""
    sources = problem.model.machine.sources
    relays = {EntryPath("sources", "", name) for name, entry in sources.items() if isinstance(entry, Relay)}
    return [j for j, p in enumerate(problem.parameters) if p.entry in relays]


def is_loose(problem: Problem) -> bool:
    """Whether a relay's own number is so uncertain that it cycles otherwise altogether: a temperature by more than its
    hysteresis, anything else by more than a factor of two."""
    sources = problem.model.machine.sources
    some = [problem.parameters[j] for j in relay_numbers(problem)]
    widths = [float(sources[p.entry.name].__dict__.get("hysteresis") or 0.0) if p.field.unit == "degC" else np.log(2.0)
              for p in some]  # fmt: skip
    return any(p.is_unknown or p.spread > width for p, width in zip(some, widths, strict=True))


def cycling(problem: Problem, begin: Array, is_late: Callable[[], bool] = lambda: False) -> list[Array]:
    """Beginnings whose relays cycle like the recordings, the other numbers as at `begin`; none without relays. is_late:
    whether what was found on the grid has to do."""
    mine = relay_numbers(problem)
    if not mine:
        return []
    measured = [sort_readings(data) for data in problem.data]

    def cost(own: Array) -> float:
        theta = begin.copy()
        theta[mine] = own
        return mismatch(problem, theta, measured)

    points = np.array(list(product(*(along(problem.parameters[j], len(mine)) for j in mine))))[:POINTS]
    costs = np.array([cost(own) for own in points])
    best = [k for k in np.argsort(costs)[:KEPT] if np.isfinite(costs[k])]
    return [_settle_cycle(problem, begin, mine, points[k], cost) for k in best if not is_late()]


def _settle_cycle(problem: Problem, begin: Array, mine: list[int], guess: Array, cost: object) -> Array:
    """A grid point, moved by a simplex to where it cycles best."""
    some = [problem.parameters[j] for j in mine]
    simplex = np.vstack([guess, guess + np.diag([0.2 * p.spread for p in some])])
    options = {"maxfev": TRIALS, "initial_simplex": simplex}
    found = minimize(cost, guess, method="Nelder-Mead", options=options, bounds=[(p.low, p.high) for p in some])
    theta = begin.copy()
    theta[mine] = found.x
    return theta


def along(p: Parameter, together: int) -> Array:
    """Values of one number on the grid, inside its bounds."""
    count = max(2, min(7, int(POINTS ** (1 / together))))
    share = (np.arange(count) + 0.5) / count * 2 - 1
    return np.clip(p.centre + share * (p.spread if p.is_unknown else REACH * p.spread), p.low, p.high)


def instants(data: Measured) -> Array:
    """Ends of bins of equal length over a run [s]."""
    t = data.run.knots.t
    return np.linspace(t[0], t[-1], BINS + 1)


def sort_readings(data: Measured) -> Array:
    """Of every channel: sorted means over bins, then sorted changes from bin to bin, in units of its noise."""
    ends, rows = instants(data), []
    for name, channel in data.channels.items():
        t, y = data.run.knots.samples[channel.used], channel.values[channel.used]
        which = np.clip(np.searchsorted(ends, t, side="right") - 1, 0, BINS - 1)
        counts = np.bincount(which, minlength=BINS)
        middle = np.interp((ends[1:] + ends[:-1]) / 2, t, y)
        means = np.where(counts > 0, np.bincount(which, y, BINS) / np.maximum(counts, 1), middle)
        rows.append(_sort_over_time(means) / data.sigma[name])
    return np.array(rows)


def _sort_over_time(values: Array) -> Array:
    return np.concatenate([np.sort(values), np.sort(np.diff(values))])


def mismatch(problem: Problem, theta: Array, measured: list[Array]) -> float:
    """Squared distance of sorted readings and changes from the measured ones; infinite where a run breaks down."""
    try:
        predictions = problem.model.predict(theta)
    except Failed:
        return float("inf")
    total = 0.0
    for data, prediction, own in zip(problem.data, predictions, measured, strict=True):
        for i, values in enumerate(model_cycle(data, prediction)):
            total += float(np.sum((_sort_over_time(values) / data.sigma[data.run.channels[i]] - own[i]) ** 2))
    return total if np.isfinite(total) else float("inf")


def model_cycle(data: Measured, prediction: Prediction) -> Iterator[Array]:
    """Channels in the middle of the bins."""
    ends = instants(data)
    edges = prediction.course.problem.plan.edges
    K = len(edges) - 1
    t = (ends[1:] + ends[:-1]) / 2
    k = np.clip(np.searchsorted(edges, t) - 1, 0, K - 1)
    w = (t - edges[k]) / (edges[k + 1] - edges[k])
    for row in prediction.values:
        yield (1 - w) * row[k] + w * row[K + k]
