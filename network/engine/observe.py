"""What a solver gave, made into what a user sees: contributions, displacement, channels, heat of the parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

import numpy as np

from network.catalogue.declaration.declare import Array, Effect
from network.catalogue.declaration.fields import Place
from network.catalogue.mechanisms.mechanism import Inputs
from network.catalogue.sensors.base import SensorEffect
from network.catalogue.sensors.sensor import Sensor
from network.engine.energy import sum_stored_heat
from network.engine.network import Network
from network.engine.runaway import extremes
from network.engine.solvers import modal
from network.engine.solvers.carry_out import Outcome
from network.engine.solvers.courses import LazyCourses
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.recordings.extrapolation import list_extrapolated
from network.recordings.inputs import Schedule
from network.recordings.possible_input import find_impossible

PLAUSIBLE = (-60.0, 400.0)
"""°C: a part that ends outside is computed, and warned about."""
POSSIBLE = (-200.0, 1400.0)
"""°C: the same for any instant; from liquid nitrogen to the wire of a heating element (FeCrAl)."""


def observe(
    network: Network, schedule: Schedule, outcome: Outcome, seconds: float, noise_seed: int | None
) -> Trajectory:
    """The trajectory of a solved run; `noise_seed` adds every sensor's noise."""
    machine, plan = network.machine, outcome.plan
    u = plan.inputs_at_samples()
    for name, signal in schedule.signals.items():
        u[name][-1] = signal.at(plan.t[-1:])[0]  # at a jump the value after it, also at the end
    early = [row for key, (row, _) in outcome.readouts.where.items() if key[0] != "part"]
    own = range(len(outcome.readouts.rows), outcome.readouts.width)
    outcome.courses.rows(np.unique([*early, *own]).astype(int))
    rows = outcome.readouts.split_by_key(outcome.courses)
    contributions = dict(_contributions(network, rows, u, outcome))
    tcp = {
        axis: sum((contributions[axis, name] for name in entries), np.zeros(len(plan.t)))
        for axis, entries in machine.tcp.items()
    }
    states = [outcome.courses[row] for row in own]
    sensors = {
        name: channel(name, sensor, rows, tcp, dict(zip(outcome.readouts.state_of, states, strict=True)), u)
        for name, sensor in machine.sensors.items()
        if sensor.axis is None or sensor.axis in tcp
    }
    if noise_seed is not None:
        sensors = _noisy(machine, sensors, noise_seed)
    parts = LazyCourses({key[1]: partial(rows.__getitem__, key) for key in rows if key[0] == "part"})
    return Trajectory(
        machine, schedule, network, plan.t, {n: u[n] for n in schedule.signals if n in machine.inputs}, sensors, tcp,
        contributions, parts, _part_heat(network, parts, outcome), outcome.T_start, outcome.T_end, outcome.account,
        outcome.switches, plan.method, plan.why, seconds, outcome.error, tuple(_warnings(network, schedule, outcome)),
        {key[1]: rows[key] for key in rows if key[0] == "state"},
    )  # fmt: skip


def _noisy(machine: Machine, sensors: Mapping[str, Array], seed: int) -> dict[str, Array]:
    draw = np.random.default_rng(seed)
    return {name: v + machine.sensors[name].sigma * draw.standard_normal(len(v)) for name, v in sensors.items()}


def _contributions(
    network: Network, rows: Mapping[tuple[str, ...], Array], u: Mapping[str, Array], outcome: Outcome
) -> Iterator[tuple[tuple[str, str], Array]]:
    for (axis, name), entry in network.machine.expansions.items():
        readings = [
            rows["reading", axis, name, str(i)]
            if reading.how != "heat"
            else _heat_reading(network, reading.place, outcome)
            for i, reading in enumerate(entry.readings())
        ]
        yield (axis, name), np.asarray(entry.movement(u, *readings) * np.ones(len(outcome.plan.t)))


def _heat_reading(network: Network, place: Place, outcome: Outcome) -> Array:
    """Heat in a range above the reference [J]: what was there at the start and what flowed in since."""
    assert outcome.heat is not None
    share = network.heat_row(place)
    cold = sum_stored_heat(network, np.full(network.size, network.machine.reference))
    return np.asarray((outcome.heat + sum_stored_heat(network, outcome.T_start.copy()) - cold) @ share)


def channel(
    name: str, sensor: Sensor, rows: Mapping[tuple[str, ...], Array], tcp: Mapping[str, Array],
    states: Mapping[tuple[str, int], Array], u: Inputs,
) -> Array:  # fmt: skip
    """The truth through the sensor's effects, in their order; `u`: inputs and `time` at every instant."""
    reading = rows["sensor", name] if sensor.axis is None else tcp[sensor.axis]
    for i, effect in enumerate(sensor.effects):
        state = states.get((name, i))
        if state is None:
            state = _integrate_state(effect, u["time"], reading) if effect.has_state else np.zeros_like(reading)
        reading = effect.reading(reading, state, u)
    return np.asarray(reading - reading[0] if sensor.zero else reading)


def _integrate_state(effect: SensorEffect, t: Array, truth: Array) -> Array:
    """The state of an effect on a displacement channel: truth straight between samples, integrated exactly; `t` in any
    order, like the begins of all intervals and then their ends."""
    order = np.argsort(t, kind="stable")
    state = np.empty_like(truth)
    state[order] = _integrate_in_order(effect, t[order], truth[order])
    return state


def _integrate_in_order(effect: SensorEffect, t: Array, truth: Array) -> Array:
    one, zero = np.ones(()), np.zeros(())
    at_zero = float(effect.rate(zero, zero))
    by_truth, by_state = float(effect.rate(one, zero)) - at_zero, float(effect.rate(zero, one)) - at_zero
    h = np.diff(t)[:, None]
    first, second, _ = modal.phi(by_state * h)
    push = by_truth * truth + at_zero
    slope = np.diff(push)[:, None] / h
    states, last = modal.scan(
        np.exp(by_state * h), h * first * push[:-1, None] + h * h * second * slope, push[:1] / -by_state
    )
    return np.append(states[:, 0], last)


def _part_heat(network: Network, parts: Mapping[str, Array], outcome: Outcome) -> Mapping[str, Array]:
    """Heat absorbed by every part since the start: C ΔT, or what was summed over its lumps where it melts."""
    heat: dict[str, Callable[[], Array]] = {}
    for name in parts:
        lumps = network.parts[name]
        capacity = network.capacity[lumps]
        if network.machine.nodes[name].stored is not None and outcome.heat is not None:
            heat[name] = partial(np.sum, outcome.heat[:, lumps], axis=1)
        elif np.isfinite(capacity).all():
            heat[name] = partial(_warm, parts, name, float(capacity.sum()), float(outcome.T_start[lumps].mean()))
    return LazyCourses(heat)


def _warm(parts: Mapping[str, Array], name: str, capacity: float, start: float) -> Array:
    return capacity * (parts[name] - start)


def _tell_impossible(machine: Machine, schedule: Schedule) -> Iterator[str]:
    """Of a recording, whose readings are not all refused for a loose contact."""
    for name in (name for name, wanted in machine.inputs.items() if wanted == "degC" and name in schedule.signals):
        worst = find_impossible(schedule.signals[name])
        if worst is not None:
            yield f"{schedule.file}: {name} reads up to {worst:.4g} degC, which is taken as it stands; take it out"


def _warnings(network: Network, schedule: Schedule, outcome: Outcome) -> Iterator[str]:
    yield from (str(warning) for warning in network.machine.warnings)
    yield from list_extrapolated(network.machine, [schedule])
    yield from _tell_impossible(network.machine, schedule)
    plan = outcome.plan
    u = {name: np.concatenate([plan.left[name], plan.right[name]]) for name in plan.left}
    for path, entry in network.machine.entries():
        yield from (f"{path}: {remark}" for remark in (entry.remarks(u) if isinstance(entry, Effect) else ()))
    yield from _tell_implausible(network, outcome)


def _tell_implausible(network: Network, outcome: Outcome) -> Iterator[str]:
    for name, (low, high) in extremes(network, outcome, POSSIBLE).items():
        T = float(outcome.T_end[network.bodies[name]].max())
        far = high if not high < POSSIBLE[1] else low
        if not POSSIBLE[0] < far < POSSIBLE[1]:
            yield f"{name} reaches {far:.4g} degC; check its heat sources and losses"
        elif not PLAUSIBLE[0] < T < PLAUSIBLE[1]:
            yield f"{name} ends at {T:.4g} degC; check its heat sources and losses"
