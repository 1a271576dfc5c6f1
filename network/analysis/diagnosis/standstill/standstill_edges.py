"""When a stop begins and ends, to less than a step of the scan: by the slopes of the readings by its instants.

About a fit to recordings that are set right an edge that comes a second later kicks the states by the rates that it
changes. All edges are moved at once by Gauss–Newton, M r along their answers, all numbers refitted beside them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from network.analysis.calibration.gauss_newton import Linearised
from network.analysis.diagnosis.intermittent.change_points import Windows
from network.analysis.diagnosis.standstill.absent_heat import MOST
from network.analysis.diagnosis.standstill.lasting_fit import LastingFit
from network.catalogue.declaration.declare import Array
from network.engine.response.nuisance_pushes import edge_pushes
from network.engine.response.prediction import Prediction

ROUNDS, FARTHEST = 4, 120.0
"""Times that edges are moved (budget), and how far [s] from where they were found, which is their prior 1σ, where no
step of the scan is longer."""
STILL = 1.0
"""s that an edge moves by where it is found."""


@dataclass(frozen=True, eq=False)
class Edges:
    """Stops with their edges moved; begins: 1σ of when each of them begins [s]; lasts:
    of how long it lasts, which its edges together tell better than each [s]; moved: by how much, at most [s]."""

    stops: tuple[Windows, ...]
    begins: tuple[float, ...]
    lasts: tuple[float, ...]
    moved: float


def refine_edges(about: Callable[[tuple[Windows, ...]], Linearised], stops: tuple[Windows, ...]) -> Edges:
    """about: the fit linearised on recordings with some stops."""
    first = edges = np.array([edge for own in stops for window in own for edge in window])
    among = np.zeros((len(edges), len(edges)))
    for _ in range(ROUNDS):
        at = about(_as_stops(edges, stops))
        reach = list_reaches(at.predictions, stops)
        step, among = _find_step(at, _as_stops(edges, stops), reach)
        moved = np.clip(edges + step, first - reach, first + reach)
        if (np.diff(moved.reshape(-1, 2)) <= 0).any():
            break
        is_still, edges = np.abs(moved - edges).max() < STILL, moved
        if is_still:
            break
    far = float(np.abs(edges - first).max())
    begins, ends = among.diagonal().reshape(-1, 2).T
    lasts = np.maximum(begins + ends - 2 * among.diagonal(1)[::2], 0.0)
    return Edges(_as_stops(edges, stops), tuple(np.sqrt(begins).tolist()), tuple(np.sqrt(lasts).tolist()), far)


def list_reaches(predictions: Sequence[Prediction], stops: tuple[Windows, ...]) -> Array:
    """How far each edge may move [s]: a step of the scan of its run."""
    steps = (max(FARTHEST, float(np.ptp(p.run.knots.t)) / MOST) for p in predictions)
    return np.array([step for step, windows in zip(steps, stops, strict=True) for _ in np.ravel(windows)])


def _find_step(at: Linearised, stops: tuple[Windows, ...], reach: Array) -> tuple[Array, Array]:
    """How much later every edge is by the readings [s], and the covariance."""
    fit, pulls, weights = LastingFit(at), list[Array](), list[Array]()
    for run, windows in enumerate(stops):
        if windows:
            p = at.predictions[run]
            t = np.clip(np.ravel(windows), p.run.knots.t[1], p.run.knots.t[-2])
            g, among = fit.weigh(run, p.respond_to(edge_pushes(p.course, t)))
            pulls.append(g)
            weights.append(among)
    own = block_diag(*weights)
    own = own + np.diag(reach**-2.0)
    return np.linalg.solve(own, np.concatenate(pulls)), np.linalg.inv(own)


def _as_stops(edges: Array, like: tuple[Windows, ...]) -> tuple[Windows, ...]:
    """Edges as windows of the same runs."""
    pairs = iter(edges.reshape(-1, 2).tolist())
    return tuple(tuple((begin, end) for begin, end in (next(pairs) for _ in own)) for own in like)
