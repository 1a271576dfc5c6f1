"""The linear case by diffrax and by PathSim, restarted at every jump; None where not installed.

diffrax gives the samples by its own interpolation, its compiling is not counted. PathSim delivers its steps, which a
cubic through states and rates carries to the samples; to sample by its events would make a step of every second.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from bench.peers import matrices

from network.machine.machine import Machine
from network.recordings.inputs import Schedule

TOLERANCE = 1e-6


def run_tsit5(machine: Machine, schedule: Schedule) -> np.ndarray | None:
    return _run_diffrax(machine, schedule, "Tsit5")


def run_kvaerno5(machine: Machine, schedule: Schedule) -> np.ndarray | None:
    return _run_diffrax(machine, schedule, "Kvaerno5")


def _run_diffrax(machine: Machine, schedule: Schedule, method: str) -> np.ndarray | None:
    """Outputs (samples, 7)."""
    try:
        import jax
    except ImportError:
        return None
    jax.config.update("jax_enable_x64", True)
    A, forcing, edges, rows, offset = matrices(machine, schedule)
    solve = _compile(method, len(A), len(edges), len(schedule.t))
    x = solve(A, forcing, edges, schedule.t, np.full(len(A), machine.reference))
    return np.asarray(x) @ rows.T + offset


@lru_cache
def _compile(method: str, nodes: int, edges: int, samples: int) -> Callable[..., Any]:
    import diffrax
    import jax
    import jax.numpy as jnp

    def rate(t: Any, x: Any, given: Any) -> Any:
        A, forcing, at = given
        return A @ x + forcing[jnp.clip(jnp.searchsorted(at, t, side="right") - 1, 0, len(forcing) - 1)]

    def solve(A: Any, forcing: Any, at: Any, t: Any, x: Any) -> Any:
        control = diffrax.ClipStepSizeController(
            diffrax.PIDController(rtol=TOLERANCE, atol=TOLERANCE), jump_ts=at[1:-1]
        )
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(rate), getattr(diffrax, method)(), at[0], at[-1], 1.0, x, (A, forcing, at),
            saveat=diffrax.SaveAt(ts=t), stepsize_controller=control, max_steps=100_000)  # fmt: skip
        return found.ys

    return jax.jit(solve)  # type: ignore[no-any-return]


def run_pathsim(machine: Machine, schedule: Schedule) -> np.ndarray | None:
    """Outputs (samples, 7)."""
    try:
        from pathsim import Connection, Simulation
        from pathsim.blocks import ODE, Scope
        from pathsim.solvers import RKDP54
    except ImportError:
        return None
    from scipy.interpolate import CubicHermiteSpline

    A, forcing, edges, rows, offset = matrices(machine, schedule)
    x, y = np.full(len(A), machine.reference), np.empty((len(schedule.t), len(rows)))
    for k, f in enumerate(forcing):
        block, scope = ODE(lambda x, u, t, f=f: A @ x + f, x, lambda x, u, t: A), Scope()
        wires = [Connection(block[i], scope[i]) for i in range(len(A))]
        run = Simulation([block, scope], wires, dt=1.0, Solver=RKDP54, log=False,
                         tolerance_lte_rel=TOLERANCE, tolerance_lte_abs=TOLERANCE)  # fmt: skip
        run.run(edges[k + 1] - edges[k])
        tau, states = scope.read()
        course = CubicHermiteSpline(tau, states.T @ rows.T, (states.T @ A.T + f) @ rows.T, axis=0)
        mine = (schedule.t >= edges[k]) & (schedule.t <= edges[k + 1])
        y[mine], x = course(schedule.t[mine] - edges[k]) + offset, block.engine.state.copy()
    return y
