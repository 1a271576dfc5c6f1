"""Runs a machine through a scenario or along a recording: checks, network, start, plan, trajectory."""

from __future__ import annotations

import time
from dataclasses import replace
from math import ceil

import numpy as np

from network.engine.assembly import build
from network.engine.observe import observe
from network.engine.piecewise import join_runs
from network.engine.runaway import check_sane
from network.engine.solvers.carry_out import Progress, solve_schedule
from network.engine.start import start_temperatures
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.quantities.units import unit
from network.platform.refusal import Complaints, Spot, likely, refuse
from network.platform.threads import on_one_thread
from network.recordings.call_arguments import expect_run
from network.recordings.inputs import Schedule, Start
from network.recordings.possible_input import check_possible
from network.recordings.recording import Recording
from network.recordings.recording_checks import check_readings
from network.recordings.runs import runs_of
from network.recordings.scenario import Scenario
from network.recordings.yaml_values import collecting

BY_STEPS = ("rosenbrock", "solve_ivp")
"""Methods that find everything that is told as they go."""
MOST_VALUES = 32_000_000
"""Of 8 B, that a run tells; it takes six times as much while it is made, drawn and written."""


@on_one_thread
def simulate(
    machine: Machine, source: Scenario | Recording | Schedule, *, method: str = "auto", start: Start | None = None,
    parts: bool = True, noise_seed: int | None = None, rtol: float | None = None, progress: Progress | None = None,
) -> Trajectory:  # fmt: skip
    """Runs a machine through a scenario, or along the inputs of a recording.

    method: auto, modal, switched, rosenbrock, expm, solve_ivp:LSODA|BDF|Radau|RK45; start: overrides the file's; parts:
    mean temperature and heat of every part too; noise_seed: adds every sensor's noise; rtol: of rosenbrock and
    solve_ivp; progress: told the simulated time. Raises Refused for missing inputs or numbers, Failed where the
    integration breaks down.
    """
    expect_run(machine, source, start)
    check_known(machine)
    if isinstance(source, Recording) and source.cuts:
        each = [
            simulate(machine, piece, method=method, start=start, parts=parts, rtol=rtol, progress=progress,
                     noise_seed=None if noise_seed is None else noise_seed + k)
            for k, piece in enumerate(runs_of(machine, source))
        ]  # fmt: skip
        return join_runs(source, each)
    schedule = schedule_for(machine, source, start)
    network = build(machine)
    check_length(machine, schedule, parts, lazy=network.is_affine() and not method.startswith(BY_STEPS))
    recording = source if isinstance(source, Recording) else None
    T0 = start_temperatures(network, schedule, recording)
    with np.errstate(over="ignore", invalid="ignore"):
        began = time.perf_counter()
        outcome = solve_schedule(network, schedule, T0, method, parts, rtol, progress)
        seconds = time.perf_counter() - began
        check_sane(network, outcome)
    return observe(network, schedule, outcome, seconds, noise_seed)


def check_length(machine: Machine, schedule: Schedule, parts: bool = True, lazy: bool = False) -> None:
    """Raises Refused where what is told over time does not fit into the memory; lazy: the courses of parts are worked
    out as they are asked for, which a picture does for their temperatures."""
    columns = len(machine.inputs) + len(machine.sensors) + len(machine.tcp) + len(machine.states)
    if parts:
        columns += len(machine.nodes)
    if parts and not lazy:
        columns += len(machine.nodes) + len(machine.expansions) + machine.lumps
    samples = len(schedule.t)
    if not samples * columns <= MOST_VALUES:
        wrong = f"{samples} samples of {columns} courses are {samples * columns / 1e6:.0f} million values"
        every = ceil(samples * columns / MOST_VALUES)
        right = f"at most {MOST_VALUES // 1_000_000} million are computed: give one sample in {every}"
        raise refuse(Spot(schedule.file), wrong, right)


def check_known(machine: Machine) -> None:
    """Raises Refused for every number that is still `unknown`."""
    complaints = Complaints()
    for path, entry in machine.entries():
        for key, number in entry.uncertain().items():
            if number.prior == "unknown":
                right = f"calibrate it on a recording, or give --set '{path}.{key}=…'"
                complaints.refuse(entry.spot_of(key), f"{path}: {key} is unknown", right)
    complaints.raise_if_any()


def schedule_for(machine: Machine, source: Scenario | Recording | Schedule, start: Start | None = None) -> Schedule:
    """The schedule with every input the machine reads, checked for its unit. Raises Refused."""
    if isinstance(source, Recording):
        schedule = source.schedule(machine.inputs, machine.switches)
    else:
        schedule = source.schedule if isinstance(source, Scenario) else source
    complaints = Complaints()
    needed = machine.inputs if isinstance(source, Recording) else machine.drives
    for name, wanted in needed.items():
        signal = schedule.signals.get(name)
        if signal is None:
            of = f" in {wanted}" if wanted else ""
            right = f"add `{name}: …`{of} to its inputs ({likely(name, schedule.signals)})"
            complaints.refuse(Spot(schedule.file), f"the machine needs the input `{name}`, which is not there", right)
        elif wanted and signal.dimension != unit(wanted).dimension:
            wrong = f"the input `{name}` is in {signal.unit}, and the machine reads it in {wanted}"
            complaints.refuse(Spot(schedule.file), wrong, f"give it in a unit like {wanted}")
        elif wanted == "degC" and not isinstance(source, Recording):
            with collecting(complaints, Spot(schedule.file), f"the input `{name}`"):
                check_possible(signal)
    if isinstance(source, Recording):
        check_readings(machine, source, complaints)
    complaints.raise_if_any()
    return replace(schedule, start=start) if start is not None else schedule
