"""The linear case by SUNDIALS: by scikit-sundae and by casadi, from jump to jump; None where not installed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from bench.peers import matrices

from network.machine.machine import Machine
from network.recordings.inputs import Schedule

TOLERANCE = 1e-6


def spans(edges: np.ndarray, t: np.ndarray) -> list[tuple[int, int, np.ndarray]]:
    """Samples of every interval: first, last (excluded), and the instants from its begin to its end."""
    found = []
    for k in range(len(edges) - 1):
        first = int(np.searchsorted(t, edges[k]))
        last = len(t) if k == len(edges) - 2 else int(np.searchsorted(t, edges[k + 1]))
        found.append((first, last, np.unique(np.concatenate([edges[k : k + 2], t[first:last]]))))
    return found


def run_cvode(machine: Machine, schedule: Schedule) -> np.ndarray | None:
    """Outputs (samples, 7) by scikit-sundae."""
    try:
        from sksundae.cvode import CVODE
    except ImportError:
        return None
    A, forcing, edges, rows, offset = matrices(machine, schedule)
    x, y = np.full(len(A), machine.reference), np.empty((len(schedule.t), len(A)))
    for (first, last, at), f in zip(spans(edges, schedule.t), forcing, strict=True):
        rate, slope = _equations(A, f)
        found = CVODE(rate, rtol=TOLERANCE, atol=TOLERANCE, linsolver="dense", jacfn=slope).solve(at, x)
        begin = int(np.searchsorted(at, schedule.t[first])) if last > first else 0
        y[first:last], x = found.y[begin : begin + last - first], found.y[-1]
    return y @ rows.T + offset


def _equations(A: np.ndarray, f: np.ndarray) -> tuple[Callable[..., None], Callable[..., None]]:
    def rate(t: float, T: np.ndarray, dT: np.ndarray) -> None:
        dT[:] = A @ T + f

    def slope(t: float, T: np.ndarray, dT: np.ndarray, J: np.ndarray) -> None:
        J[:, :] = A

    return rate, slope


def run_cvodes(machine: Machine, schedule: Schedule) -> np.ndarray | None:
    """Outputs (samples, 7) by casadi; setting up is counted, as it is for the others."""
    try:
        import casadi
    except ImportError:
        return None
    A, forcing, edges, rows, offset = matrices(machine, schedule)
    T, f = casadi.MX.sym("T", len(A)), casadi.MX.sym("f", len(A))
    ode = {"x": T, "p": f, "ode": casadi.mtimes(casadi.sparsify(casadi.DM(A)), T) + f}
    x, y = np.full(len(A), machine.reference), np.empty((len(schedule.t), len(A)))
    options = {"reltol": TOLERANCE, "abstol": TOLERANCE}
    for (first, last, at), forced in zip(spans(edges, schedule.t), forcing, strict=True):
        solver = casadi.integrator("F", "cvodes", ode, float(at[0]), at.tolist(), options)
        found = np.array(solver(x0=x, p=forced)["xf"]).T
        begin = int(np.searchsorted(at, schedule.t[first])) if last > first else 0
        y[first:last], x = found[begin : begin + last - first], found[-1]
    return y @ rows.T + offset
