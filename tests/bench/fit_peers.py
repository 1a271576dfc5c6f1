"""Fits beside those of other tools on the same data: scipy and lmfit on solve_ivp, darkgreybox on a real building.

`python -m bench.fit_peers`, or with the others by `make bench`; lmfit and darkgreybox come with the extra `bench`.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.util import find_spec

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from bench.cases import HOURS
from bench.fit_cases import fit_case, laid_out, recorded, schedules
from bench.peers import run_split
from bench.recordings_table import RECORDINGS, ROOT, load, size
from rich.console import Console
from rich.table import Table
from scipy.optimize import least_squares

from network import Machine, calibrate
from network.analysis.calibration.gauss_newton import make_problem, minimise
from network.engine.response.parameters import Parameter, at_values, centres, values_at
from network.recordings.inputs import Schedule, constant
from network.recordings.recording import Recording

OUTPUT, NUMBERS, PARTS = 60.0, 6, 5


def small_case() -> tuple[Machine, tuple[Parameter, ...], Recording, Mapping[str, float], Schedule]:
    """Few parts, one run, a room that stands still: what the others need minutes for otherwise."""
    machine, free, _, truth = fit_case(nodes=PARTS, free=NUMBERS, runs=1, output=OUTPUT)
    schedule = schedules(1, OUTPUT, HOURS)[0]
    signals = dict(schedule.signals) | {"ambient": constant("ambient", "degC", 21.5)}
    schedule = Schedule(schedule.name, schedule.file, schedule.t, signals)
    return machine, free, recorded(at_values(machine, dict(truth)), schedule, 7), truth, schedule


def residual_of(machine: Machine, free: tuple[Parameter, ...], recording: Recording, schedule: Schedule) -> Callable:
    """What the others minimise: residuals and priors at θ, by solve_ivp (LSODA, 1e-6) from jump to jump."""
    sensors = list(machine.sensors)
    measured = np.stack([recording.columns[n].values for n in sensors], axis=1)
    sigma = np.array([machine.sensors[n].sigma for n in sensors])

    def residual(theta: np.ndarray) -> np.ndarray:
        y = run_split(at_values(machine, values_at(free, theta)), schedule, "LSODA")
        prior = (theta - centres(free)) / [p.spread for p in free]
        return np.concatenate([((measured - y) / sigma).ravel(), prior])

    return residual


def simulated_rows(table: Table) -> None:
    machine, free, recording, truth, schedule = small_case()
    true = np.log([truth[p.path] for p in free])

    def told(name: str, fit: Callable[[], np.ndarray]) -> None:
        began = time.perf_counter()
        theta = fit()
        error = 100 * float(np.sqrt(np.mean((theta - true) ** 2)))
        table.add_row(name, f"{time.perf_counter() - began:.3g} s", f"{error:.2f} % of the numbers")

    residual = residual_of(machine, free, recording, schedule)
    told("lptn, with starts, jumps and offsets uncertain", lambda: by_lptn(machine, free, recording, False))
    told("lptn, all but the numbers known", lambda: by_lptn(machine, free, recording, True))
    told("scipy least_squares on solve_ivp", lambda: least_squares(residual, centres(free), x_scale=0.3).x)
    if find_spec("lmfit"):
        told("lmfit (leastsq) on solve_ivp", lambda: by_lmfit(residual, free))
    else:
        table.add_row("lmfit", "not installed", "pip install '.[bench]'")


def by_lptn(machine: Machine, free: tuple[Parameter, ...], recording: Recording, rest_known: bool) -> np.ndarray:
    problem = make_problem(machine, free, laid_out(machine, [recording]))
    if rest_known:
        problem = replace(problem, offsets=(), data=tuple(replace(d, starts=(), edges=()) for d in problem.data))
    return minimise(problem).theta


def by_lmfit(residual: Callable, free: tuple[Parameter, ...]) -> np.ndarray:
    import lmfit

    start = lmfit.Parameters()
    for i, p in enumerate(free):
        start.add(f"p{i}", value=p.centre)
    found = lmfit.minimize(lambda q: residual(np.array(list(q.valuesdict().values()))), start, method="leastsq")
    return np.array(list(found.params.valuesdict().values()))


def building_rows(table: Table) -> None:
    if not RECORDINGS.is_dir():
        table.add_row("heated building", "the recordings in ../shared/recordings are not here", "")
        return
    train, holdout = load("building_train"), load("building_holdout")
    machine, began = Machine.load(ROOT / "machines" / "heated_building.yaml"), time.perf_counter()
    found = calibrate(machine, [train], [holdout])
    took = time.perf_counter() - began
    error = size(found.after_holdout.recordings[-1].channels["T_indoor"])
    table.add_row("lptn calibrate, room and return pipe", f"{took:.3g} s", f"{error:.2f} K held out")
    if not find_spec("darkgreybox"):
        table.add_row("darkgreybox", "not installed", "pip install '.[bench]'")
        return
    for method in ("nelder", "leastsq"):
        began = time.perf_counter()
        try:
            told = f"{by_darkgreybox(train, holdout, method):.2f} K held out"
        except ValueError:
            told = "breaks down: its steps of 1 h run away"
        took = time.perf_counter() - began
        table.add_row(f"darkgreybox TiTeTh ({method}), room", f"{took:.3g} s", told)


def by_darkgreybox(train: Recording, holdout: Recording, method: str) -> float:
    """Rms error of the room on the held-out days [K], from the same numbers to begin with (kW, kWh/K)."""
    from darkgreybox.models import TiTeTh

    free = {"Ci": 30 / 3.6, "Ce": 800 / 3.6, "Ch": 2 / 3.6, "Rie": 0.1, "Rea": 1.0, "Rih": 1 / 1.3}
    params = {name: {"value": value, "min": value / 30, "max": value * 30} for name, value in free.items()}
    begins = {"Ti0": float(train.columns["T_indoor"].values[0]), "Te0": 17.5, "Th0": 18.1}
    params |= {name: {"value": value, "vary": False} for name, value in begins.items()}
    model = TiTeTh(params=params, rec_duration=1).fit(inputs(train), train.columns["T_indoor"].values, method)
    room = holdout.columns["T_indoor"].values
    run = model.predict(inputs(holdout), {"Ti0": float(room[0]), "Te0": 20.0, "Th0": 20.5})
    return float(np.sqrt(np.mean((run.Z - room) ** 2)))


def inputs(recording: Recording) -> dict[str, np.ndarray]:
    return {"Ta": recording.columns["outdoor"].values, "Ph": recording.columns["P_heating"].values / 1e3}


def main() -> None:
    case = f"{NUMBERS} numbers, {PARTS} parts, 8 h at {OUTPUT:.0f} s"
    table = Table(title=f"fits side by side: {case}; a building in winter")
    for heading in ("tool", "time", "error"):
        table.add_column(heading, justify="right")
    simulated_rows(table)
    building_rows(table)
    Console(width=140).print(table)


if __name__ == "__main__":
    main()
