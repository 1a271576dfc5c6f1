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

from bench.bent_rows import main as tell_bent
from bench.coverage import main as tell_coverage
from bench.fit_peers import main as tell_peers
from bench.fit_rows import main as tell_fits
from bench.recordings_table import main as tell_recordings
from bench.rigs.__main__ import main as tell_rigs
from bench.solver_rows import main as tell_solvers
from rich.console import Console
from rich.table import Table

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
            table.add_row(f"lptn {words[0]}", f"{seconds:.2f} s", limit)


def main() -> None:
    tell_solvers(["--pictures", str(ROOT / "out" / "bench")])
    table = Table(title="whole processes, by the clock; medians of three")
    for heading in ("what", "lptn", "to reach"):
        table.add_column(heading, justify="right")
    process_rows(table)
    Console(width=140).print(table)
    for tell in (tell_bent, tell_fits, tell_peers, tell_coverage, tell_recordings):
        tell()
    tell_rigs(["--resume", str(ROOT / "out" / "rigs")])


if __name__ == "__main__":
    main()
