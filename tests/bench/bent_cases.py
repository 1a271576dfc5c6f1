"""Machines of the benchmark that are not linear, or switch, and the same by solve_ivp at its best.

The peers get bare arrays and the analytic Jacobian, and are restarted at every step of the speed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from bench.cases import chain_machine
from bench.peers import matrices
from scipy.integrate import solve_ivp

from network import Machine
from network.engine.assembly import build
from network.recordings.inputs import Schedule

TOLERANCE = 1e-6
ZERO, SIGMA, AREA = 273.15, 5.670374419e-8, 0.4
SET, HALF, POWER = 25.0, 1.0, 600.0


def bent_machine(nodes: int, mesh: bool) -> Machine:
    """A chain whose every third node radiates to the room; a tree, or with cross links."""
    linear = chain_machine(nodes)
    crossed = {} if mesh else {f"x{i}": None for i in range(0, nodes - 3, 4)}
    glow = {f"glow{i}": {"kind": "radiation", "between": [f"n{i}", "ambient"], "emissivity_area": f"{AREA} m^2"}
            for i in range(0, nodes, 3)}  # fmt: skip
    return linear.patched({"links": crossed | glow})


def relay_machine(nodes: int) -> Machine:
    """A chain whose second node is kept by a cooler that goes on and off."""
    cooler = {"kind": "thermostat_cooling", "into": {"n1": 1}, "watches": "n1", "set": f"{SET} degC",
              "hysteresis": f"{HALF} K", "power": f"{POWER} W", "delay": "0 s"}  # fmt: skip
    return chain_machine(nodes).patched({"sources": {"cooler": cooler}})


def run_bent(machine: Machine, schedule: Schedule, method: str, tolerance: float = TOLERANCE) -> np.ndarray:
    """Temperatures of the first five nodes (samples, 5)."""
    A, forcing, edges, _, _ = matrices(straight(machine, "links", "glow"), schedule)
    network, glowing = build(machine), np.arange(0, len(A), 3)
    gain, room = AREA * SIGMA / network.capacity[network.free][glowing], schedule.signals["ambient"].at(edges[:1])[0]

    def rate(t: float, T: np.ndarray, f: np.ndarray) -> np.ndarray:
        out = A @ T + f
        out[glowing] -= gain * ((T[glowing] + ZERO) ** 4 - (room + ZERO) ** 4)
        return np.asarray(out)

    def slope(t: float, T: np.ndarray, f: np.ndarray) -> np.ndarray:
        J = A.copy()
        J[glowing, glowing] -= 4 * gain * (T[glowing] + ZERO) ** 3
        return J

    return _split(rate, slope, forcing, edges, schedule.t, np.full(len(A), machine.reference), method, tolerance)


def straight(machine: Machine, section: str, begins: str) -> Machine:
    """The machine without some of its entries."""
    names = [name for name in getattr(machine, section) if name.startswith(begins)]
    return machine.patched({section: dict.fromkeys(names)})


def _split(
    rate: Callable[..., np.ndarray], slope: Callable[..., np.ndarray], forcing: np.ndarray, edges: np.ndarray,
    t: np.ndarray, x: np.ndarray, method: str, tolerance: float,
) -> np.ndarray:  # fmt: skip
    y = np.empty((len(t), 5))
    jac = {} if method == "RK45" else {"jac": slope}
    for k, f in enumerate(forcing):
        first, last = samples_of(t, edges, k)
        asked = np.unique(np.clip(np.append(t[first:last], edges[k + 1]), edges[k], edges[k + 1]))
        found = solve_ivp(rate, (edges[k], edges[k + 1]), x, method, asked, rtol=tolerance, atol=tolerance,
                          args=(f,), **jac)  # fmt: skip
        y[first:last], x = found.y.T[: last - first, :5], found.y[:, -1]
    return y


def samples_of(t: np.ndarray, edges: np.ndarray, k: int) -> tuple[int, int]:
    """First and last (excluded) of the samples in interval k."""
    last = len(t) if k == len(edges) - 2 else int(np.searchsorted(t, edges[k + 1]))
    return int(np.searchsorted(t, edges[k])), last


def run_relay(machine: Machine, schedule: Schedule, method: str, tolerance: float = TOLERANCE) -> np.ndarray:
    """Temperatures of the first five nodes (samples, 5), restarted at every switching, which is an event."""
    A, forcing, edges, _, _ = matrices(straight(machine, "sources", "cooler"), schedule)
    network = build(machine)
    cold, on, t = np.zeros(len(A)), False, schedule.t
    cold[1] = -POWER / network.capacity[network.free][1]
    x, y = np.full(len(A), machine.reference), np.empty((len(t), 5))
    for k, f in enumerate(forcing):
        (first, last), now = samples_of(t, edges, k), float(edges[k])
        while now < edges[k + 1]:
            sought = _crossing(SET - HALF if on else SET + HALF, -1.0 if on else 1.0)
            asked = np.unique(np.append(t[first:last][t[first:last] >= now], edges[k + 1]))
            found = solve_ivp(lambda s, T, f: A @ T + f, (now, edges[k + 1]), x, method, asked, events=sought,
                              rtol=tolerance, atol=tolerance, args=(f + on * cold,),
                              **({} if method == "RK45" else {"jac": (lambda s, T, f: A)}))  # fmt: skip
            count = min(last - first, len(found.t))
            if count:
                y[first : first + count], first = found.y.T[:count, :5], first + count
            stopped = found.status == 1
            now = float(found.t_events[0][0]) if stopped else float(edges[k + 1])
            x, on = (found.y_events[0][0], not on) if stopped else (found.y[:, -1], on)
    return y


def _crossing(level: float, direction: float) -> Any:
    def event(t: float, T: np.ndarray, f: np.ndarray) -> float:
        return float(T[1] - level)

    event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return event
