"""Fewer states: balanced, and what is left out keeps its equilibrium, so that a machine at rest is told rightly.

Gramians of what the drives reach and the outputs see give the states by how much of the outputs they carry (Moore,
IEEE Trans. Automatic Control 26 (1981) 17); the others follow at once (singular perturbation, Liu & Anderson, Int. J.
Control 50 (1989) 1379). A network that loses no heat is taken to lose it in a hundred days.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from network.catalogue.declaration.declare import Array

SLOWEST = 100 * 86400.0
"""s: time constant of the loss that makes a network stable for its gramians."""
NOTHING = 1e-10
"""Hankel singular values below this share of the largest are rounding."""


@dataclass(frozen=True)
class Reduction:
    """A (r, r), C (m, r); of a drive b of all states: `drive` @ b of these, and `direct` @ b of the outputs at once;
    of rises z of all lumps: `project` @ z."""

    A: Array
    C: Array
    drive: Array
    direct: Array
    project: Array

    @property
    def states(self) -> int:
        return len(self.A)


def balance(A: Array, B: Array, C: Array) -> tuple[Array, Array]:
    """(to, back): balanced states z = to @ x, x = back @ z, by what they carry, as many as are more than rounding. B:
    drives, C: outputs, both scaled to what counts as one."""
    shifted = A - np.eye(len(A)) / SLOWEST
    reach, seen = (_factor(solve_continuous_lyapunov(a, -q)) for a, q in ((shifted, B @ B.T), (shifted.T, C.T @ C)))
    U, values, Vt = np.linalg.svd(seen.T @ reach)
    kept = values > NOTHING * values[0]
    root = np.sqrt(values[kept])
    return (U[:, kept] / root).T @ seen.T, reach @ (Vt[kept].T / root)


def _factor(gramian: Array) -> Array:
    """L with L Lᵀ = gramian."""
    values, vectors = np.linalg.eigh((gramian + gramian.T) / 2)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def cut(A: Array, C: Array, to: Array, back: Array, states: int) -> Reduction:
    """The first balanced states; the others in equilibrium with them."""
    full, outputs, r = to @ A @ back, C @ back, min(states, len(to))
    A11, A12, A21, A22 = full[:r, :r], full[:r, r:], full[r:, :r], full[r:, r:]
    if not len(A22):
        return Reduction(full, outputs, to, np.zeros((len(C), len(A))), to)
    follow, fast = np.linalg.solve(A22, A21), np.linalg.solve(A22, to[r:])
    near, far = outputs[:, :r], outputs[:, r:]
    return Reduction(A11 - A12 @ follow, near - far @ follow, to[:r] - A12 @ fast, -far @ fast, to[:r])
