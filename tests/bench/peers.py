"""What lptn is measured against: solve_ivp at its best (split at every step, bare matrices), matrix exponentials."""

from __future__ import annotations

import statistics
import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from network.engine.assembly import build
from network.engine.balance import affine_heat, affine_matrix
from network.machine.machine import Machine
from network.recordings.inputs import Schedule

Matrices = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def matrices(machine: Machine, schedule: Schedule) -> Matrices:
    """A, forcing of each interval, edges, output rows and offsets: the problem without lptn's solvers."""
    network = build(machine)
    edges = np.append(np.unique(np.concatenate([s.t for s in schedule.signals.values()])), schedule.t[-1])
    u = {name: signal.at(edges[:-1])[:, None] for name, signal in schedule.signals.items()} | {"time": edges[:-1, None]}
    K = affine_matrix(network, {name: value[0, 0] for name, value in u.items()}, np.zeros(0))
    free, bound = network.free, network.bound
    C = network.capacity[free]
    heat = affine_heat(network, u, np.zeros(0), len(edges) - 1)
    forcing = (heat[:, free] + u["ambient"] * K[np.ix_(free, bound)].sum(axis=1)) / C
    rows, offset = np.zeros((7, len(free))), np.zeros(7)
    rows[np.arange(5), np.arange(5)] = 1
    for line, axis in ((5, "y"), (6, "z")):
        entry = machine.tcp[axis]["grows"]
        gain = float(entry.expansion * entry.length)
        rows[line, network.parts[entry.of.node].start], offset[line] = gain, -gain * machine.reference
    return K[np.ix_(free, free)] / C[:, None], forcing, edges, rows, offset


def split_solve_ivp(machine: Machine, schedule: Schedule, method: str, truth: np.ndarray) -> tuple[float, str, float]:
    """Median seconds of three runs, the method, its largest temperature error [K]."""
    A, forcing, edges, rows, offset = matrices(machine, schedule)
    times = []
    for _ in range(3):
        began = time.perf_counter()
        y = _run(A, forcing, edges, schedule.t, machine.reference, method) @ rows.T + offset
        times.append(time.perf_counter() - began)
    return statistics.median(times), method, float(np.abs(y - truth)[:, :5].max())


def run_split(machine: Machine, schedule: Schedule, method: str) -> np.ndarray:
    """Outputs (samples, 7) by solve_ivp from jump to jump."""
    A, forcing, edges, rows, offset = matrices(machine, schedule)
    return _run(A, forcing, edges, schedule.t, machine.reference, method) @ rows.T + offset


def _run(A: np.ndarray, forcing: np.ndarray, edges: np.ndarray, t: np.ndarray, T0: float, method: str) -> np.ndarray:
    x, y = np.full(len(A), T0), np.empty((len(t), len(A)))
    jac = {} if method == "RK45" else {"jac": (lambda s, z: A) if method == "LSODA" else A}
    for k, f in enumerate(forcing):
        first, last = np.searchsorted(t, edges[k]), np.searchsorted(t, edges[k + 1])
        last = len(t) if k == len(forcing) - 1 else last
        span = (edges[k], edges[k + 1])
        asked = np.append(t[first:last], span[1])
        asked = np.unique(np.clip(asked, *span))
        found = solve_ivp(
            lambda s, z, f=f: A @ z + f, span, x, method=method, t_eval=asked, rtol=1e-6, atol=1e-6, **jac
        )
        y[first:last] = found.y.T[: last - first]
        x = found.y[:, -1]
    return y


def expm_reference(machine: Machine, schedule: Schedule) -> np.ndarray:
    """Outputs by one matrix exponential for each step length, from sample to sample."""
    A, forcing, edges, rows, offset = matrices(machine, schedule)
    n, t = len(A), schedule.t
    known: dict[float, np.ndarray] = {}

    def step(x: np.ndarray, f: np.ndarray, h: float) -> np.ndarray:
        key = round(h, 12)
        if key not in known:
            known[key] = expm(np.block([[A * h, np.eye(n)], [np.zeros((n, 2 * n))]]))[:n]
        return known[key][:, :n] @ x + h * (known[key][:, n:] @ f)

    x, y, now = np.full(n, machine.reference), np.empty((len(t), n)), float(t[0])
    for k, f in enumerate(forcing):
        first, last = np.searchsorted(t, edges[k]), np.searchsorted(t, edges[k + 1])
        for i in range(first, len(t) if k == len(forcing) - 1 else last):
            x, now = step(x, f, t[i] - now) if t[i] > now else x, max(now, float(t[i]))
            y[i] = x
        if edges[k + 1] > now:
            x, now = step(x, f, edges[k + 1] - now), float(edges[k + 1])
    return y @ rows.T + offset
