"""Fits of the benchmark: a machine with uncertain numbers, and recordings that a truth of its own drew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from bench.cases import chain_machine, speed_steps

from network import Machine
from network.analysis.calibration.measured_means import Measured, weigh_recording
from network.catalogue.declaration.entry_path import NumberPath
from network.engine.response.parameters import Parameter, at_values, parameter
from network.engine.simulation import simulate
from network.platform.quantities.units import Number
from network.recordings.columns import Column
from network.recordings.inputs import Schedule, linear
from network.recordings.recording import Recording

SPREAD = 0.3


def free_numbers(machine: Machine, count: int) -> tuple[Parameter, ...]:
    """The losses, then conductances of every kind, as if they stood there with ± 30 %."""
    paths = ["sources.bearing.torque", "sources.motor.copper", "sources.motor.iron"]
    paths += [f"links.{name}.conductance" for name in ("l0", "skin0", "l1", "x0", "skin2", "l2", "l3", "skin4", "l4")]

    def number(path: NumberPath) -> Number:
        return Number(float(machine.by_path[path.entry].__dict__[path.key]), "relative", SPREAD)

    numbers = (NumberPath.parse(path, machine.paths) for path in paths[:count])
    return tuple(parameter(machine, path, number(path)) for path in numbers if path is not None)


def drawn(free: tuple[Parameter, ...], seed: int = 0) -> dict[str, float]:
    """True values, from the priors."""
    draw = np.random.default_rng(seed)
    return {p.path: p.value(p.centre + p.spread * float(draw.standard_normal())) for p in free}


def recorded(machine: Machine, schedule: Schedule, seed: int) -> Recording:
    """What sensors would have read, with their noise."""
    run = simulate(machine, schedule, parts=False)
    draw, t = np.random.default_rng(seed), schedule.t
    noisy = {n: v + machine.sensors[n].sigma * draw.standard_normal(len(t)) for n, v in run.sensors.items()}
    columns = {n: Column(n, machine.sensors[n].unit, v) for n, v in noisy.items()}
    inputs = {n: Column(n, s.unit, s.at(t)) for n, s in schedule.signals.items()}
    return Recording(schedule.name, "bench", t, columns | inputs)


def schedules(runs: int, output: float, hours: float = 8, steps: int = 60) -> list[Schedule]:
    """Unequal speed steps at the samples, and a room that warms and cools."""
    made = []
    for i in range(runs):
        plain = speed_steps(steps, hours, output, seed=i + 1)
        speed = plain.signals["speed"]
        at = np.round(speed.t / output) * output
        kept = np.append(np.diff(at) > 0, True)
        t = np.arange(0.0, hours * 3600 + 1, 600.0)
        room = linear("ambient", "degC", t, 21.5 + np.sin(2 * np.pi * t / 86400 + i))
        held = replace(speed, t=at[kept], start=speed.start[kept], end=speed.start[kept])
        made.append(replace(plain, signals=plain.signals | {"speed": replace(held, end=held.start), "ambient": room}))
    return made


def fit_case(
    nodes: int = 20, free: int = 12, runs: int = 4, output: float = 10.0, seed: int = 0
) -> tuple[Machine, tuple[Parameter, ...], list[Recording], Mapping[str, float]]:
    """A machine, its free numbers, recordings, and the true values."""
    machine = chain_machine(nodes)
    numbers = free_numbers(machine, free)
    truth = drawn(numbers, seed)
    true = at_values(machine, truth)
    recordings = [recorded(true, s, 100 * seed + i) for i, s in enumerate(schedules(runs, output))]
    return machine, numbers, recordings, truth


def laid_out(machine: Machine, recordings: list[Recording]) -> list[Measured]:
    return [weigh_recording(machine, r) for r in recordings]
