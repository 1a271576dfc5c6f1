"""`make bench`: speed and error side by side, in one run, on one BLAS thread. Prints a table."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from bench.cases import chain_machine, speed_steps
from bench.coverage import main as tell_coverage
from bench.fit_peers import main as tell_peers
from bench.fit_rows import main as tell_fits
from bench.peers import expm_reference, split_solve_ivp
from bench.recordings_table import main as tell_recordings
from bench.rigs.__main__ import main as tell_rigs
from rich.console import Console
from rich.table import Table

from network.engine.assembly import build
from network.engine.simulation import simulate
from network.engine.solvers.carry_out import solve_schedule
from network.engine.start import start_temperatures

ROOT = Path(__file__).parents[2]
REPEATS = 15


def median_seconds(action: Callable[[], object], repeats: int = REPEATS) -> float:
    action()
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        action()
        times.append(time.perf_counter() - began)
    return statistics.median(times)


def linear_rows(table: Table) -> None:
    for nodes in (5, 50):
        machine, schedule = chain_machine(nodes), speed_steps()
        network = build(machine)
        T0 = start_temperatures(network, schedule)
        ours = median_seconds(lambda n=network, s=schedule, T=T0: solve_schedule(n, s, T, parts=False))
        whole = median_seconds(lambda m=machine, s=schedule: simulate(m, s, parts=False))
        run = simulate(machine, schedule, parts=False)
        y = np.stack([*run.sensors.values()], axis=1)
        best, name, peer_error = min(
            (split_solve_ivp(machine, schedule, method, y) for method in ("LSODA", "BDF", "RK45", "Radau")),
        )
        error = float(np.abs(y[:, :5] - expm_reference(machine, schedule)[:, :5]).max())
        table.add_row(
            f"linear, {nodes} nodes", f"{ours * 1e3:.2f} ms", f"{error:.1e} K", f"{name} {best * 1e3:.0f} ms",
            f"{peer_error:.0e} K", f"{best / ours:.0f}×", f"{best / whole:.0f}× ({whole * 1e3:.1f} ms)",
        )  # fmt: skip


def process_rows(table: Table) -> None:
    machine = str(ROOT / "machines" / "gantry_spindle.yaml")
    scenario = str(ROOT / "scenarios" / "day_of_work.yaml")
    lptn = [sys.executable, "-m", "network.cli"]
    with tempfile.TemporaryDirectory() as folder:
        for words, limit in (
            (["check", machine], "1 s"),
            (["simulate", machine, scenario, "--no-plots", "-o", folder], "1.5 s"),
            (["demo", "-o", folder], "60 s"),
        ):
            seconds = median_seconds(lambda w=words: subprocess.run([*lptn, *w], check=True, capture_output=True), 3)
            table.add_row(f"lptn {words[0]}, whole process", f"{seconds:.2f} s", "", f"limit {limit}", "", "", "")


def main() -> None:
    table = Table(title="8 h, 60 unequal speed steps, 28 801 samples, 7 outputs; medians")
    for heading in (
        "case",
        "lptn",
        "error to expm",
        "best split solve_ivp, 1e-6",
        "its error",
        "faster",
        "with set-up",
    ):
        table.add_column(heading, justify="right")
    linear_rows(table)
    process_rows(table)
    Console(width=140).print(table)
    for tell in (tell_fits, tell_peers, tell_coverage, tell_recordings):
        tell()
    tell_rigs(["--resume", str(ROOT / "out" / "rigs")])


if __name__ == "__main__":
    main()
