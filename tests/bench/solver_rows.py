"""Speed of the solvers beside peers in one run, with the error beside each time, and two pictures.

`python -m bench.solver_rows [--pictures FOLDER]`, or with the others by `make bench`. Seconds are of this process's
own time, medians of five; only their ratios are to be trusted on a machine that others use too. Peers that are not
installed are left out.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from bench.cases import bars_machine, chain_machine, speed_steps
from bench.other_peers import run_kvaerno5, run_pathsim, run_tsit5
from bench.peers import expm_reference, run_split
from bench.sundials import run_cvode, run_cvodes
from rich.console import Console
from rich.table import Table

from network.analysis.sweep.batched_runs import batch_of, run_one
from network.analysis.sweep.level_runs import Job
from network.analysis.sweep.sample_runs import SampleJob
from network.analysis.sweep.sampling import choose_drawn, latin_hypercube
from network.engine.assembly import build
from network.engine.channels import readouts
from network.engine.simulation import simulate
from network.engine.solvers.carry_out import solve_schedule
from network.engine.solvers.method_choice import make_plan
from network.engine.start import start_temperatures
from network.machine.machine import Machine
from network.platform.threads import on_one_thread
from network.recordings.inputs import Schedule

REPEATS = 5
DRAWN = ("links.l0.conductance=10..60 W/K", "links.skin3.conductance=1..5 W/K",
         "sources.bearing.torque=400..600 N mm", "nodes.n2.heat_capacity=5..30 kJ/K")  # fmt: skip


def own_seconds(action: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median of this process's own time."""
    action()
    times = []
    for _ in range(repeats):
        began = time.process_time()
        action()
        times.append(time.process_time() - began)
    return statistics.median(times)


def shown(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds > 1 else f"{seconds * 1e3:.1f} ms"


@dataclass(frozen=True)
class Peer:
    """A way to solve the same case: samples × outputs, of which the first five are temperatures."""

    name: str
    run: Callable[[Machine, Schedule], np.ndarray | None]


def peers(nodes: int) -> Iterator[Peer]:
    for method in ("LSODA", "BDF") if nodes < 500 else ("BDF",):
        yield Peer(f"split solve_ivp {method}", lambda m, s, method=method: run_split(m, s, method))
    yield Peer("scikit-sundae CVODE", run_cvode)
    yield Peer("casadi CVODES", run_cvodes)
    if nodes <= 50:
        yield from (Peer("diffrax Tsit5", run_tsit5), Peer("diffrax Kvaerno5", run_kvaerno5))
        yield Peer("PathSim RKDP54", run_pathsim)


def limit(machine: Machine, schedule: Schedule) -> float:
    """One product of the size of the outputs over the modes, and writing them: what no exact solver can be below."""
    order, width = min(len(build(machine).free), 100), 7
    draw = np.random.default_rng(0)
    rows, columns = draw.normal(size=(width * -(-len(schedule.t) // 128), order)), draw.normal(size=(order, 128))
    return own_seconds(on_one_thread(lambda: np.array(rows @ columns)))


def linear_rows(table: Table) -> None:
    """Outputs alone; with peers as far as their matrices go."""
    schedule = speed_steps()
    for nodes in (5, 50, 500):
        machine, network = chain_machine(nodes), build(chain_machine(nodes))
        T0 = start_temperatures(network, schedule)
        y = truth(machine, schedule)
        ours = own_seconds(on_one_thread(lambda n=network, T=T0: read_all(n, schedule, T)))
        mine = np.stack([*simulate(machine, schedule, parts=False).sensors.values()], axis=1)
        error = float(np.abs(mine - y)[:, :5].max())
        ratio = f"{ours / limit(machine, schedule):.1f} × the limit"
        told = make_plan(network, schedule, T0).method
        table.add_row(f"linear, {nodes} nodes, outputs alone", f"lptn ({told})", shown(ours), f"{error:.0e} K", ratio)
        for peer in peers(nodes):
            found = peer.run(machine, schedule)
            if found is not None:
                took = own_seconds(lambda p=peer, m=machine: p.run(m, schedule), 1)
                off = float(np.abs(found - y)[:, :5].max())
                table.add_row("", peer.name, shown(took), f"{off:.0e} K", f"{took / ours:.0f} × ours")


def truth(machine: Machine, schedule: Schedule) -> np.ndarray:
    """Outputs by matrix exponentials; of many nodes, for which these take minutes, in all modes."""
    if len(machine.nodes) < 100:
        return expm_reference(machine, schedule)
    return np.stack([*simulate(machine, schedule, parts=False, method="modal").sensors.values()], axis=1)


def read_all(network: object, schedule: Schedule, T0: np.ndarray) -> np.ndarray:
    return solve_schedule(network, schedule, T0, parts=False).courses.all()  # type: ignore[arg-type]


def whole_rows(table: Table) -> None:
    """`simulate` with all parts, as far as they are asked for; large ones beside all modes."""
    schedule = speed_steps()
    for nodes in (5, 50, 500):
        machine = chain_machine(nodes)
        took = own_seconds(lambda m=machine: simulate(m, schedule), 3)
        all_of = own_seconds(lambda m=machine: [*simulate(m, schedule).parts.values()], 3)
        table.add_row(f"simulate(), {nodes} nodes", "lptn", shown(took), "", f"{shown(all_of)} with all courses read")
    for lumps, modes in ((500, True), (2000, True), (4950, False)):
        machine = bars_machine(lumps)
        small = simulate(machine, schedule)
        took = own_seconds(lambda m=machine: simulate(m, schedule), 3)
        told = f"{small.error:.0e} K told"
        if modes:
            exact = simulate(machine, schedule, method="modal")
            slow = own_seconds(lambda m=machine: simulate(m, schedule, method="modal"), 1)
            off = max(float(np.abs(small.sensors[n] - exact.sensors[n]).max()) for n in small.sensors)
            told = f"{off:.0e} K, {told}"
            table.add_row(f"bars of {lumps} lumps", "lptn (modal)", shown(slow), "exact", f"{slow / took:.1f} × krylov")
        table.add_row(f"bars of {lumps} lumps", f"lptn ({small.method})", shown(took), told, "")


ALONE = """
import resource, time
from bench.cases import bars_machine, speed_steps
from network import simulate
machine, began = bars_machine({lumps}, {bars}), time.process_time()
run = simulate(machine, speed_steps())
print(time.process_time() - began, run.error, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)
"""


def largest_row(table: Table, lumps: int = 99_950, bars: int = 50) -> None:
    """In a process of its own, for the memory that it takes in all."""
    told = subprocess.run([sys.executable, "-c", ALONE.format(lumps=lumps, bars=bars)], capture_output=True, check=True)
    took, error, memory = map(float, told.stdout.split())
    table.add_row(f"bars of {lumps} lumps", "lptn", shown(took), f"{error:.0e} K told", f"{memory:.1f} GB in all")


def sample_rows(table: Table) -> None:
    machine, schedule, count = chain_machine(20), speed_steps(output=10.0), 2000
    drawn = choose_drawn(machine, DRAWN)
    shared = SampleJob(Job(machine, schedule), drawn)  # type: ignore[arg-type]
    batch = batch_of(shared)
    assert batch is not None
    points = np.stack([d.at(latin_hypercube(count, 1, i)[:, 0]) for i, d in enumerate(drawn)], axis=1)
    together = own_seconds(lambda: batch.run(points), 3) / count
    alone = own_seconds(lambda: [run_one(shared, point) for point in points[:20]], 1) / 20
    off = np.abs(batch.run(points[:20]) - np.stack([run_one(shared, p) for p in points[:20]])).max() * 1e6
    what = "sweep, 20 nodes, 8 h at 10 s"
    table.add_row(what, "lptn, side by side", f"{together * 1e6:.0f} µs a run", f"{off:.0e} µm",
                  f"{1 / together:.0f} runs a second and core")  # fmt: skip
    table.add_row("", "lptn, one by one", f"{alone * 1e6:.0f} µs a run", "", f"{alone / together:.0f} × as long")


def draw_pictures(folder: Path) -> list[Path]:
    """Time against nodes, and against the length of the schedule."""
    from matplotlib.figure import Figure

    folder.mkdir(parents=True, exist_ok=True)
    sizes, hours = (5, 20, 50, 100, 200, 500, 1000, 2000), (1, 4, 8, 24, 72, 240)
    schedule, chain = speed_steps(), chain_machine(50)
    by_size = {"auto": sizes, "modal": sizes[:7], "solve_ivp BDF": sizes[:5]}
    by_length = {"auto": hours, "solve_ivp BDF": hours[:4]}
    curves = {method: [_one(method, chain_machine(n), schedule) for n in at] for method, at in by_size.items()}
    steps = {h: speed_steps(int(7.5 * h), h) for h in hours}
    longer = {method: [_one(method, chain, steps[h]) for h in at] for method, at in by_length.items()}
    made = []
    for name, label, at, times in (("nodes", "nodes", by_size, curves), ("length", "hours", by_length, longer)):
        figure = Figure(figsize=(6.4, 3.6), layout="constrained")
        axes = figure.add_subplot()
        for method, seconds in times.items():
            axes.loglog(at[method], np.array(seconds) * 1e3, "o-", label=method)
        axes.set_xlabel(label)
        axes.set_ylabel("ms")
        axes.legend(frameon=False)
        axes.grid(alpha=0.3)
        made.append(folder / f"time_against_{name}.png")
        figure.savefig(made[-1], dpi=120)
    return made


def _one(method: str, machine: Machine, schedule: Schedule) -> float:
    if method == "solve_ivp BDF":
        return own_seconds(lambda: run_split(machine, schedule, "BDF"), 1)
    network = build(machine)
    T0 = start_temperatures(network, schedule)
    outputs = readouts(network, parts=False)
    return own_seconds(on_one_thread(
        lambda: solve_schedule(network, schedule, T0, method, outputs=outputs).courses.all()), 3)  # fmt: skip


def print_rows(title: str, *groups: Callable[[Table], None]) -> None:
    """A table of all that some groups of rows measure."""
    table = Table(title=title)
    for heading in ("case", "by", "time", "error", "beside it"):
        table.add_column(heading, justify="left" if heading in ("case", "by") else "right")
    for rows in groups:
        rows(table)
    Console(width=140).print(table)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--pictures", type=Path)
    folder = parser.parse_args(arguments).pictures
    title = "8 h, 60 unequal speed steps, 28 801 samples; one core, own time of the process, medians"
    print_rows(title, linear_rows, whole_rows, largest_row, sample_rows)
    if folder is not None:
        print("Drawn:", *draw_pictures(folder))


if __name__ == "__main__":
    main()
