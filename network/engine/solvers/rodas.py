"""One step of RODAS, a Rosenbrock method of order 4(3).

Stiffly accurate and made for mass matrices that may be singular, so massless junctions are solved along with the rest.
Source: Hairer & Wanner, Solving Ordinary Differential Equations II, section VI.4, method RODAS; coefficients of its
published code.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.solvers.slope_layout import Layout

GAMMA = 0.25
# rows of a: arguments of stages 2 to 5; rows of c: what earlier stages add to stages 2 to 6, times mass over step
STAGES = tuple(map(np.array, (
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950),
)))  # fmt: skip
COUPLING = tuple(map(np.array, (
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
    (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054),
)))  # fmt: skip
TIMES = (0.0, 0.386, 0.21, 0.63, 1.0, 1.0)
DRIFT = (0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0)
DENSE = np.array([
    [10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823, 1.025137723295662, 0.0],
    [-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386, -6.594389125716872, 0.0],
])  # fmt: skip
Bend = tuple[Array, Array]
"""The two vectors that a step's dense output needs beside the states at its ends."""


def step(
    f: Callable[[float, Array], Array], mass: Array, layout: Layout, t: float, x: Array, h: float, rate: Array,
    slopes: Array, drift: Array | None,
) -> tuple[Array, Bend, Array]:  # fmt: skip
    """mass x' = f(t, x) from t over h: the state, the vectors of the dense output, and the error estimate. rate,
    slopes, drift: f, ∂f/∂x as laid out, and ∂f/∂t at (t, x); no drift: f does not depend on t."""
    solve = layout.factorise(mass / (h * GAMMA), slopes)
    U, per_step, argument = np.empty((6, len(x))), mass / h, x
    U[0] = solve(rate if drift is None else rate + h * DRIFT[0] * drift)
    for stage in range(1, 6):
        argument = argument + U[4] if stage == 5 else x + STAGES[stage - 1] @ U[:stage]
        right = f(t + TIMES[stage] * h, argument)
        if drift is not None and DRIFT[stage]:
            right = right + h * DRIFT[stage] * drift
        U[stage] = solve(right + per_step * (COUPLING[stage - 1] @ U[:stage]))
    first, second = DENSE @ U
    return argument + U[5], (first, second), U[5]


def size_error(error: Array, x0: Array, x1: Array, tolerance: float) -> float:
    """Rms of an error over what a relative tolerance allows of states at the ends of a step."""
    allowed = tolerance * (1 + np.maximum(np.abs(x0), np.abs(x1)))
    return float(np.sqrt(np.mean((error / allowed) ** 2)))


def between(s: Array, x0: Array, x1: Array, bend: Bend) -> Array:
    """States at shares s of steps, third order (M, n): from those at both ends, all broadcast to (M, n)."""
    return np.asarray((1 - s) * x0 + s * (x1 + (1 - s) * (bend[0] + s * bend[1])))
