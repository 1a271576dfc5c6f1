"""The noise a residual may have without accusing anybody: white, coloured, constant, and heat that lumping misplaces.

Σ = white + coloured + lumping slack. Coloured: each sensor's own OU process, variance s², correlation e^(−|t − t'|/τ).
Slack: an unknown OU heat at every part, q_i = q C_i/ΣC P with correlation time ℓ, carried to the channels by the
network's own answer to it. Source: Kennedy & O'Hagan, J. R. Stat. Soc. B 63 (2001) 425, with the discrepancy put where
the heat balance is wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from network.calibration.course import Push
from network.calibration.evidence import Measured
from network.calibration.ou import sampled_ou
from network.calibration.predictor import Prediction
from network.declare import Array, Indices

SLACK_STEP = 600.0
"""s: distance of the knots of the slack's heat."""
MOST_SLACK_KNOTS = 60
REMEMBERED = 64
"""Roots of coloured covariances."""


@dataclass(frozen=True)
class Noise:
    """coloured: channel → (1σ in SI, correlation time [s]); slack: 1σ of each part's heat [W]; ell: its correlation
    time [s]."""

    coloured: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    slack: Mapping[str, float] = field(default_factory=dict)
    ell: float = 4000.0


@dataclass(frozen=True)
class Whitener:
    """L⁻¹ with L Lᵀ = Σ over the cells that hold samples. roots: of the blocks of Σ one after the other, each L, or 1σ
    where a block is diagonal."""

    known: Array
    roots: tuple[Array, ...]

    @cached_property
    def blocks(self) -> tuple[tuple[slice, Array], ...]:
        """Each root with its rows."""
        ends = np.cumsum([0, *(len(root) for root in self.roots)]).tolist()
        return tuple((slice(a, b), root) for a, b, root in zip(ends[:-1], ends[1:], self.roots, strict=True))

    @property
    def count(self) -> int:
        """Cells that hold samples."""
        return sum(len(root) for root in self.roots)

    @property
    def log_determinant(self) -> float:
        """log |Σ|."""
        return 2 * sum(float(np.log(root if root.ndim == 1 else np.diag(root)).sum()) for root in self.roots)

    def __call__(self, values: Array) -> Array:
        """L⁻¹ applied to values over all cells (…, cells): (…, known cells)."""
        return self.again(values if self._all_known else values[..., self.known])

    @cached_property
    def _all_known(self) -> bool:
        return bool(np.all(self.known)) and self.known.dtype == bool

    def again(self, own: Array) -> Array:
        """L⁻¹ applied to values over the cells that hold samples (…, known cells)."""
        out = np.empty(own.shape)
        for rows, root in self.blocks:
            out[..., rows] = own[..., rows] / root if root.ndim == 1 else _solved(root, own[..., rows])
        return out

    def undone(self, values: Array) -> Array:
        """L applied to whitened values (…, known cells)."""
        out = np.empty(values.shape)
        for rows, root in self.blocks:
            out[..., rows] = values[..., rows] * root if root.ndim == 1 else values[..., rows] @ root.T
        return out


def _solved(root: Array, values: Array) -> Array:
    flat = values.reshape(-1, values.shape[-1])
    return np.asarray(solve_triangular(root, flat.T, lower=True, check_finite=False).T.reshape(values.shape))


def whitener(data: Measured, noise: Noise, slack: Array | None = None) -> Whitener:
    """The whitening of one run; `slack`: its covariance by misplaced heat, from `slack_covariance`."""
    known = data.known
    if slack is None:
        return Whitener(known, tuple(_root_of(data, noise, i) for i in range(len(data.run.channels))))
    covariance = np.diag(data.variance[known]) + (coloured(data, noise) + slack)[np.ix_(known, known)]
    return Whitener(known, (cholesky(covariance, lower=True),))


def _root_of(data: Measured, noise: Noise, i: int) -> Array:
    """The root of one channel's covariance."""
    cells, name = data.run.knots.cells, data.run.channels[i]
    own = slice(i * cells, (i + 1) * cells)
    variance, (s, tau) = data.variance[own][data.known[own]], noise.coloured.get(name, (0.0, 1.0))
    if not s:
        return np.asarray(np.sqrt(variance))
    t, cell = _samples(data, name)
    known = data.known[own]
    return _coloured_root(s, tau, t.tobytes(), cell.tobytes(), known.tobytes(), variance.tobytes())


@lru_cache(maxsize=REMEMBERED)
def _coloured_root(s: float, tau: float, t: bytes, cell: bytes, known: bytes, variance: bytes) -> Array:
    """The same from what it depends on, which many fits of one case share."""
    of = np.frombuffer(known, bool)
    shape = sampled_ou(np.frombuffer(t), np.frombuffer(cell, int), len(of), tau)
    return np.asarray(cholesky(np.diag(np.frombuffer(variance)) + s * s * shape[np.ix_(of, of)], lower=True))


def coloured(data: Measured, noise: Noise) -> Array:
    """Covariance of the cells' means by coloured sensor noise."""
    cells = data.run.knots.cells
    matrix = np.zeros((len(data.means), len(data.means)))
    for i, name in enumerate(data.run.channels):
        s, tau = noise.coloured.get(name, (0.0, 1.0))
        if s:
            own = slice(i * cells, (i + 1) * cells)
            matrix[own, own] = s * s * of_channel(data, name, tau)
    return matrix


def of_channel(data: Measured, name: str, tau: float) -> Array:
    """Correlation of the cells' means of one channel under OU noise."""
    return sampled_ou(*_samples(data, name), data.run.knots.cells, tau)


def _samples(data: Measured, name: str) -> tuple[Array, Indices]:
    """Instants of the samples of a channel, and their cells."""
    knots, present = data.run.knots, data.run.present[name]
    return knots.samples[present], knots.cell_of[present]


def cell_widths(data: Measured) -> Array:
    """Length of every cell [s]."""
    ends = data.run.knots.t[data.run.knots.cell_ends]
    return np.diff(np.concatenate([data.run.knots.t[:1], ends]))


def averaged_ou(t: Array, width: Array, tau: float) -> Array:
    """Correlation of means over intervals of some widths about t of an OU process with correlation time τ.

    Exact for intervals that do not overlap: ∫∫ e^(−|s − s'|/τ) ds ds'/(w w').
    """
    x = width / tau
    safe = np.maximum(x, 1e-9)
    factor = np.sinh(np.minimum(safe / 2, 300.0)) / (safe / 2)
    gap = np.abs(t[:, None] - t[None, :]) / tau
    near = (x[:, None] + x[None, :]) / 2
    inner = np.exp(-np.maximum(gap - near, 0.0)) * np.exp(-near)
    matrix = factor[:, None] * factor[None, :] * inner
    np.fill_diagonal(matrix, 2 * (safe - 1 + np.exp(-safe)) / safe**2)
    return np.asarray(np.minimum(matrix, 1.0))


def slack_knots(data: Measured, step: float = SLACK_STEP) -> Array:
    """Instants at which the slack's heat is free; straight in between."""
    t = data.run.knots.t
    count = min(max(3, round(float(t[-1] - t[0]) / step) + 1), MOST_SLACK_KNOTS)
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
    return prediction.answered(pushes)


def part_spread(prediction: Prediction, part: str) -> Array:
    """One watt, evenly over the lumps of a part."""
    network = prediction.course.problem.plan.network
    spread = np.zeros(network.size)
    own = network.parts[part]
    spread[own] = 1 / (own.stop - own.start)
    return spread


def ou(knots: Array, ell: float) -> Array:
    return np.exp(-np.abs(knots[:, None] - knots[None, :]) / ell)


def slack_covariance(prediction: Prediction, data: Measured, noise: Noise, step: float = SLACK_STEP) -> Array:
    """Covariance of the cells' means by slack heat at every part, straight between instants `step` [s] apart."""
    knots = slack_knots(data, step)
    K = ou(knots, noise.ell)
    matrix = np.zeros((len(data.means), len(data.means)))
    for part, q in noise.slack.items():
        if q:
            G = heat_answers(prediction, part_spread(prediction, part), knots)
            matrix += G.T @ (q * q * K @ G)
    return matrix
