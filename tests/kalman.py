"""The likelihood of a run sample by sample: a Kalman filter on what is measured beside the model.

An answer from outside to what a fit minimises. States are the deviation of lumps and lags from the run, the
coloured noise of every channel, and constants: offsets of channels, what a zeroed channel read at its start. White
noise comes in with the samples.
Each innovation v with variance S counts −½ (log 2π|S| + vᵀ S⁻¹ v). Sources: van Loan, IEEE Trans. Autom. Control 23
(1978) 395 (exact discretisation); Anderson & Moore, Optimal Filtering (1979), ch. 3 and 5.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, cholesky, expm, solve_triangular

from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.noise import Noise
from network.catalogue.declaration.declare import Array, Indices, Mask
from network.engine.response.intervals import first_from
from network.engine.response.nuisance_pushes import start_pushes
from network.engine.response.prediction import Prediction


@dataclass(frozen=True, eq=False)
class StateSpace:
    """dz = A z dt + noise of intensity Q, seen as H z at the samples; one A, H for each regime; P0 at the start."""

    A: tuple[Array, ...]
    H: tuple[Array, ...]
    Q: Array
    P0: Array


@dataclass(frozen=True, eq=False)
class Filtered:
    """innovations: whitened by channel and sample (NaN where nothing was read)."""

    log_likelihood: float
    innovations: Array


def discretised(A: Array, Q: Array, h: float) -> tuple[Array, Array]:
    """Φ and Q_d of a step: exp([[−A, Q], [0, Aᵀ]] h) on a part of it that is not stiff, then doubled."""
    n = len(A)
    halvings = max(0, int(np.ceil(np.log2(max(np.abs(A).sum(axis=1).max() * h, 1e-30)))))
    E = expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * (h / 2**halvings))
    phi = E[n:, n:].T
    noise = phi @ E[:n, n:]
    for _ in range(halvings):
        noise = phi @ noise @ phi.T + noise
        phi = phi @ phi
    return phi, (noise + noise.T) / 2


def state_space(
    prediction: Prediction, data: Measured, noise: Noise, offsets: Mapping[str, float]
) -> StateSpace:  # fmt: skip
    """What may move beside a run. offsets: 1σ of the constant error of channels [SI]. Channels that are not the same
    linear function of the readings at all times raise ValueError."""
    course, slopes = prediction.course, prediction.slopes
    if slopes is None or not slopes.is_constant:
        raise ValueError("the filter serves channels that are linear in the readings only")
    output_map, names = course.output_map.through(slopes.matrix), data.run.channels
    n = course.problem.order
    colour = [(i, *noise.coloured[c]) for i, c in enumerate(names) if noise.coloured.get(c, (0.0, 1.0))[0]]
    own = np.eye(len(names))
    rates, sizes = np.array([1 / tau for _, _, tau in colour]), np.array([s for _, s, _ in colour])
    constants = np.hstack([own[:, [names.index(c) for c in offsets]], -own[:, slopes.zeroed]])
    A, H = [], []
    for r, regime in enumerate(course.problem.regimes):
        A.append(block_diag(regime.A, -np.diag(rates), np.zeros((constants.shape[1],) * 2)))
        H.append(np.hstack([output_map.over[r], own[:, [i for i, *_ in colour]], constants]))
    Q = block_diag(np.zeros((n, n)), np.diag(2 * sizes**2 * rates), np.zeros((constants.shape[1],) * 2))
    first = int(course.problem.regime_of[0])
    return StateSpace(tuple(A), tuple(H), Q, _start(prediction, data, sizes, list(offsets.values()), H[first]))


def _start(prediction: Prediction, data: Measured, sizes: Array, offsets: list[float], H: Array) -> Array:
    """Covariance at the start: parts by their priors, OU states at rest, zeroed channels as the start has them."""
    n = prediction.course.problem.order
    jumps = np.array([p.kicks[0][1] for p in start_pushes(prediction.course, [s.name for s in data.starts])])
    spreads = np.array([s.spread for s in data.starts])
    x = (jumps.T * spreads**2) @ jumps if len(spreads) else np.zeros((n, n))
    free = block_diag(x, np.diag(np.concatenate([sizes**2, np.square(offsets)])))
    assert prediction.slopes is not None
    zeroed = np.zeros((int(prediction.slopes.zeroed.sum()), len(free)))
    inside = n + len(sizes) - sum(1 for _ in range(H.shape[1] - len(free) - len(zeroed)))
    zeroed[:, :inside] = H[prediction.slopes.zeroed, :inside]
    both = np.vstack([np.eye(len(free)), zeroed])
    return np.asarray(both @ free @ both.T)


def filtered(space: StateSpace, t: Array, regime_of: Indices, residual: Array, sigma: Array) -> Filtered:
    """Filters residuals (channels, samples), NaN where nothing was read. regime_of: regime before each sample."""
    walk, out, total = _Walk(space, sigma), np.full(residual.shape, np.nan), 0.0
    seen, h = np.isfinite(residual), np.diff(t, prepend=t[0])
    for k in range(len(t)):
        own = seen[:, k]
        white, root = walk.step(int(regime_of[k]), round(float(h[k]), 9), own, residual[own, k])
        out[own, k] = white
        total -= 0.5 * float(white @ white + len(white) * np.log(2 * np.pi)) + float(np.log(np.diag(root)).sum())
    return Filtered(total, out)


class _Walk:
    """The filter from sample to sample."""

    def __init__(self, space: StateSpace, sigma: Array) -> None:
        self.space, self.variance = space, sigma**2
        self.z, self.P = np.zeros(len(space.P0)), space.P0
        self.steps: dict[tuple[int, float], tuple[Array, Array]] = {}

    def step(self, r: int, h: float, own: Mask, read: Array) -> tuple[Array, Array]:
        """Goes on by h and takes in what was read: the whitened innovation, and the root of its variance."""
        if (r, h) not in self.steps:
            self.steps[r, h] = discretised(self.space.A[r], self.space.Q, h)
        phi, added = self.steps[r, h]
        H, P = self.space.H[r][own], phi @ self.P @ phi.T + added
        root = cholesky(H @ P @ H.T + np.diag(self.variance[own]), lower=True, check_finite=False)
        gain = solve_triangular(root, H @ P, lower=True, check_finite=False)
        self.P, ahead = P - gain.T @ gain, phi @ self.z
        white = np.asarray(solve_triangular(root, read - H @ ahead, lower=True, check_finite=False))
        self.z = ahead + white @ gain
        return white, root


def filter_run(
    prediction: Prediction, data: Measured, residual: Array, noise: Noise, offsets: Mapping[str, float]
) -> Filtered:
    """The filter along one run; residual: measured less modelled at the run's samples (channels, samples)."""
    space, problem = state_space(prediction, data, noise, offsets), prediction.course.problem
    t = data.run.knots.samples
    before = np.clip(first_from(problem.plan.edges, t) - 1, 0, len(problem.regime_of) - 1)
    sigma = np.array([data.sigma[n] for n in data.run.channels])
    return filtered(space, t, problem.regime_of[before], residual, sigma)
