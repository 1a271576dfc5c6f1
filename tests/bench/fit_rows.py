"""Speed of fits: 12 numbers on four runs of 8 h with 20 parts, many fits in a row, and finer machines.

`python -m bench.fit_rows`, or with the others by `make bench`. Seconds are of one core.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from bench.fit_cases import fit_case, free_numbers, laid_out, recorded, schedules
from rich.console import Console
from rich.table import Table

from network.analysis.calibration.gauss_newton import Linearised, linearise, make_problem, minimise
from network.engine.response.parameters import at_values, centres
from network.engine.response.series import compile_means

MANY, TIMED = 500, 25


def seconds(action: Callable[[], object], repeats: int = 5) -> float:
    """The least of some tries, of this process's own time."""
    action()
    tries = []
    for _ in range(repeats):
        began = time.process_time()
        action()
        tries.append(time.process_time() - began)
    return min(tries)


def shown(value: float) -> str:
    return f"{value:.2f} s" if value > 2 else f"{value * 1e3:.0f} ms"


def off(at: Linearised, truth: dict[str, float]) -> str:
    """Rms deviation from the truth in standard errors."""
    true = np.log([truth[p.path] for p in at.problem.parameters])
    return f"{np.sqrt(np.mean(((at.theta - true) / np.sqrt(np.diag(at.covariance)[: at.free])) ** 2)):.2f}"


def fit_rows(table: Table) -> None:
    for output, limit in ((10.0, "100 ms, 50 ms with numba"), (60.0, "15 ms with numba")):
        machine, free, recordings, truth = fit_case(output=output)
        problem = make_problem(machine, free, laid_out(machine, recordings))
        at = minimise(problem)
        name = f"12 numbers, 4 runs of 8 h at {output:.0f} s, 20 parts"
        table.add_row(name, shown(seconds(lambda p=problem: minimise(p), 3)), limit, off(at, dict(truth)))
        at_start = centres(free)
        step = seconds(lambda p=problem, x=at_start: linearise(p, x))
        table.add_row("… of it one run and all slopes", shown(step), "", "")
    many_row(table)


def many_row(table: Table) -> None:
    """The same machine recorded anew many times, each fitted from the priors."""
    machine, free, _, truth = fit_case(output=10.0)
    true, total = at_values(machine, dict(truth)), 0.0
    for seed in range(TIMED):
        recordings = [recorded(true, s, 1000 + 4 * seed + i) for i, s in enumerate(schedules(4, 10.0))]
        problem = make_problem(machine, free, laid_out(machine, recordings))
        began = time.process_time()
        minimise(problem)
        total += time.process_time() - began
    table.add_row(f"{MANY} such fits ({TIMED} timed)", shown(total * MANY / TIMED), "30 s", "")


def fine_rows(table: Table) -> None:
    for nodes in (50, 150):
        machine, _, recordings, _ = fit_case(nodes=nodes, runs=3)
        problem = make_problem(machine, free_numbers(machine, 12), laid_out(machine, recordings))
        took = seconds(lambda p=problem: linearise(p, centres(p.parameters)), 2)
        table.add_row(f"one run and all slopes, 3 runs of 8 h, {nodes} parts", shown(took), "", "")


def bent_row(table: Table) -> None:
    """A fit's step where every third part radiates, about numbers that were found for another machine."""
    machine, free, recordings, _ = fit_case(output=60.0, runs=6)
    glow = {f"glow{i}": {"kind": "radiation", "between": [f"n{i}", "ambient"], "emissivity_area": "0.5 m^2"}
            for i in range(0, 20, 3)}  # fmt: skip
    bent = machine.patched({"links": glow})
    problem = make_problem(bent, free, laid_out(bent, recordings))
    at, draw = centres(free), np.random.default_rng(0)

    def step() -> object:
        return linearise(problem, at + 0.02 * draw.standard_normal(len(at)))

    table.add_row(
        "one run and all slopes, 6 runs of 8 h at 60 s, 20 parts of which 7 radiate", shown(seconds(step)), "", ""
    )


def main() -> None:
    kind = "with numba" if compile_means() is not None else "without numba"
    table = Table(title=f"fits in one process, one core, {kind}")
    for heading in ("what", "time", "to reach", "rms error in standard errors"):
        table.add_column(heading, justify="right")
    for rows in (fit_rows, fine_rows, bent_row):
        rows(table)
    Console(width=140).print(table)


if __name__ == "__main__":
    main()
