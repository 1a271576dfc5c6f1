"""Machines that switch, are not linear, or are driven anew every second, beside split solve_ivp in one run.

`python -m bench.bent_rows`, or with the others by `make bench`. Errors are against solve_ivp at 1e-10.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from bench.bent_cases import bent_machine, relay_machine, run_bent, run_relay
from bench.cases import RPM, chain_machine, speed_steps
from bench.peers import expm_reference, run_split
from bench.solver_rows import own_seconds, print_rows, shown
from rich.table import Table

from network.engine.simulation import simulate
from network.machine.machine import Machine
from network.recordings.inputs import Schedule, hold

Peer = Callable[[Machine, Schedule, str], np.ndarray]
EXACT, ALMOST = 1e-10, 1e-9


def sensed(machine: Machine, schedule: Schedule, method: str, rtol: float | None = None) -> np.ndarray:
    """Temperatures of the first five nodes (samples, 5)."""
    run = simulate(machine, schedule, parts=False, method=method, rtol=rtol)
    return np.stack([run.sensors[f"T{i}"] for i in range(5)], axis=1)


def rows_of(
    table: Table, case: str, machine: Machine, schedule: Schedule, ways: dict[str, float | None], peer: Peer,
    methods: tuple[str, ...], truth: np.ndarray, repeats: int = 5,
) -> None:  # fmt: skip
    """Ours by some methods with their tolerances, then the peers; the ratio is to the first of ours."""
    first = 0.0
    for method, rtol in ways.items():
        took = own_seconds(lambda m=method, r=rtol: sensed(machine, schedule, m, r), repeats)
        first = first or took
        run = simulate(machine, schedule, parts=False, method=method, rtol=rtol)
        off = np.abs(sensed(machine, schedule, method, rtol) - truth).max()
        tolerance = "" if rtol is None else f" at {rtol:.0e}"
        told = f"{len(run.switches)} switchings" if run.switches else ""
        table.add_row(case, f"lptn ({run.method}{tolerance})", shown(took), f"{off:.0e} K", told)
    for method in methods:
        off = np.abs(peer(machine, schedule, method)[:, :5] - truth).max()
        took = own_seconds(lambda m=method: peer(machine, schedule, m), 1)
        table.add_row("", f"split solve_ivp {method}", shown(took), f"{off:.0e} K", f"{took / first:.1f} × ours")


def relay_rows(table: Table) -> None:
    schedule = speed_steps()
    for nodes in (5, 50):
        machine = relay_machine(nodes)
        truth = run_relay(machine, schedule, "LSODA", EXACT)
        ways = {"auto": None, "rosenbrock": None}
        rows_of(table, f"relay, {nodes} nodes", machine, schedule, ways, run_relay, ("LSODA", "RK45"), truth)


def bent_rows(table: Table) -> None:
    schedule = speed_steps()
    for nodes in (5, 50):
        machine = bent_machine(nodes, mesh=False)
        truth = run_bent(machine, schedule, "LSODA", EXACT)
        ways = {"auto": None, "rosenbrock": 1e-6}
        rows_of(table, f"radiating tree, {nodes} nodes", machine, schedule, ways, run_bent, ("LSODA", "BDF"), truth)
    machine = bent_machine(500, mesh=True)
    truth = sensed(machine, schedule, "rosenbrock", ALMOST)
    ways = {"rosenbrock": None}
    rows_of(table, "radiating mesh, 500 nodes", machine, schedule, ways, run_bent, ("BDF",), truth, 3)


def second_rows(table: Table) -> None:
    """A speed that changes every second."""
    machine, plain = chain_machine(50), speed_steps()
    speeds = np.random.default_rng(1).choice([0, 3000, 6000, 9000], len(plain.t) - 1) * RPM
    speed = hold("speed", "rpm", plain.t[:-1], speeds)
    schedule = replace(plain, signals=plain.signals | {"speed": speed})
    truth = expm_reference(machine, schedule)[:, :5]
    rows_of(table, "50 nodes, 28 800 steps", machine, schedule, {"auto": None}, run_split, ("LSODA",), truth)


def main() -> None:
    title = "8 h, 28 801 samples, not linear or switching; simulate() on one core, own time of the process"
    print_rows(title, relay_rows, bent_rows, second_rows)


if __name__ == "__main__":
    main()
