"""plan → trajectory: one function that runs a machine through a scenario or along a recording."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import ThreadpoolController

from network.channels import Readouts, readouts
from network.declare import Array, Effect
from network.energy import EnergyAccount, heat_over_time, linear_account, stored_heat
from network.graph import Network, build
from network.inputs import Schedule, Start
from network.machine import Machine
from network.recording import Recording
from network.refusal import Complaints, Failed, Spot, likely
from network.scenario import Scenario
from network.sensors.sensor import Sensor
from network.solvers import expm, modal, reference, rosenbrock, switched
from network.solvers.linear import LinearProblem, LinearSolution, reduce
from network.solvers.modal import scan
from network.solvers.plan import Plan, make_plan
from network.start import start_temperatures
from network.trajectory import Trajectory
from network.units import unit

PLAUSIBLE = (-60.0, 400.0)
"""°C: a part outside is computed, and warned about."""
ROSENBROCK_TOLERANCE, REFERENCE_TOLERANCE = 1e-7, 1e-8
HOPELESS = 1e4
"""°C: beyond it nothing computed means anything."""
Progress = Callable[[float], None]


def simulate(
    machine: Machine, source: Scenario | Recording | Schedule, *, method: str = "auto", start: Start | None = None,
    parts: bool = True, noise_seed: int | None = None, rtol: float | None = None, progress: Progress | None = None,
) -> Trajectory:  # fmt: skip
    """Runs a machine through a scenario, or along the inputs of a recording.

    method: auto, modal, expm, solve_ivp:LSODA|BDF|Radau|RK45; start: overrides the file's; parts: mean temperature
    and heat of every part too; noise_seed: adds every sensor's noise; rtol: of rosenbrock and solve_ivp; progress: told the
    simulated time. Raises Refused for missing inputs or numbers, Failed where the integration breaks down.
    """
    check_known(machine)
    schedule = schedule_for(machine, source, start)
    network = build(machine)
    recording = source if isinstance(source, Recording) else None
    T0 = start_temperatures(network, schedule, recording)
    with _controller().limit(limits=1), np.errstate(over="ignore", invalid="ignore"):
        began = time.perf_counter()
        outcome = solve_schedule(network, schedule, T0, method, parts, rtol, progress)
        seconds = time.perf_counter() - began
    _check_sane(network, outcome.T_end)
    return _trajectory(network, schedule, outcome, seconds, noise_seed)


def _check_sane(network: Network, T_end: Array) -> None:
    """Raises Failed for a machine that has run away."""
    for name, part in network.parts.items():
        T = float(T_end[part].max())
        if not -HOPELESS < T < HOPELESS:
            raise Failed(
                f"{name} reaches {T:.3g} degC: it runs away; a heat source grows with its own temperature faster than "
                "the heat can leave, check friction that grows with temperature"
            )


_CONTROLLERS: list[ThreadpoolController] = []


def _controller() -> ThreadpoolController:
    """BLAS on one thread inside a simulation: two threads slow the small products of a network many times."""
    if not _CONTROLLERS:
        _CONTROLLERS.append(ThreadpoolController())
    return _CONTROLLERS[0]


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
        schedule = source.schedule(machine.inputs)
    else:
        schedule = source.schedule if isinstance(source, Scenario) else source
    complaints = Complaints()
    for name, wanted in machine.inputs.items():
        signal = schedule.signals.get(name)
        if signal is None:
            right = f"add `{name}: …` in {wanted} to its inputs ({likely(name, schedule.signals)})"
            complaints.refuse(Spot(schedule.file), f"the machine needs the input `{name}`, which is not there", right)
        elif signal.dimension != unit(wanted).dimension:
            wrong = f"the input `{name}` is in {signal.unit}, and the machine reads it in {wanted}"
            complaints.refuse(Spot(schedule.file), wrong, f"give it in a unit like {wanted}")
    complaints.raise_if_any()
    return replace(schedule, start=start) if start is not None else schedule


@dataclass(frozen=True)
class Outcome:
    """What a solver gave: base readings and sensor states (rows × t), heat of lumps over time where asked for."""

    plan: Plan
    readouts: Readouts
    y: Array
    T_start: Array
    T_end: Array
    account: EnergyAccount
    error: float
    heat: Array | None
    switches: tuple[tuple[float, str, bool], ...] = ()


def solve_schedule(
    network: Network, schedule: Schedule, T0: Array, method: str = "auto", parts: bool = True, rtol: float | None = None,
    progress: Progress | None = None,
) -> Outcome:  # fmt: skip
    """Plans and solves; from the temperatures of all lumps at the start to base readings and the energy account."""
    wants_heat = any(r.how == "heat" for e in network.machine.expansions.values() for r in e.readings())
    plan = make_plan(network, schedule, T0, method, stop_at_samples=wants_heat)
    outputs = readouts(network, parts)
    if plan.method.startswith("solve_ivp"):
        return _by_reference(plan, outputs, rtol, progress)
    if plan.method == "rosenbrock":
        return _by_rosenbrock(plan, outputs, rtol, progress)
    switches: tuple[tuple[float, int, int], ...] = ()
    if plan.method == "switched":
        found = switched.find(plan, outputs, progress)
        if found is None:
            why = "it switches, and its modes are too much alike for the closed form"
            return _by_reference(replace(plan, method="solve_ivp:LSODA", why=why), outputs, rtol, progress)
        plan, switches = found.plan, found.switches
    problem = reduce(plan, outputs)
    solution = modal.solve(problem, each_interval=wants_heat) if plan.method != "expm" else None
    if solution is None:
        if plan.method == "modal":
            plan = replace(plan, method="expm", why="linear, but its modes are too much alike: matrix exponentials")
        solution = expm.solve(problem, each_interval=wants_heat)
    return replace(_by_linear(plan, problem, solution, wants_heat), switches=_named(network, switches))


def _by_linear(plan: Plan, problem: LinearProblem, solution: LinearSolution, wants_heat: bool) -> Outcome:
    T0, T1 = problem.temperatures(problem.x0, 0), problem.temperatures(solution.x_end, -1)
    heat = None
    if wants_heat:
        at = np.searchsorted(plan.edges, plan.t - 1e-9)
        heat = heat_over_time(problem, solution)[at]
    account = linear_account(problem, solution)
    return Outcome(plan, problem.readouts, solution.y, T0, T1, account, solution.error, heat)


def _by_rosenbrock(plan: Plan, outputs: Readouts, rtol: float | None, progress: Progress | None) -> Outcome:
    rtol = rtol or ROSENBROCK_TOLERANCE
    solution = rosenbrock.solve(plan, outputs, rtol, progress)
    error = _error_from(solution.account, plan.network, rtol, solution.T_end)
    return Outcome(
        plan, outputs, solution.y, solution.T_start, solution.T_end, solution.account, error, solution.heat
    )  # fmt: skip


def _error_from(account: EnergyAccount, network: Network, rtol: float, T_end: Array) -> float:
    """What the account's gap would warm the machine by, or what the tolerance allows: the larger [K]."""
    gap = abs(account.closure) * max(account.in_, account.out, 1.0)
    allowed = rtol * float(np.abs(T_end[np.isfinite(network.capacity)]).max())
    return max(gap / float(network.capacity[network.free].sum()), allowed)


def _named(network: Network, switches: Iterable[tuple[float, int, int]]) -> tuple[tuple[float, str, bool], ...]:
    """Switchings with the names of their sources."""
    names = [network.mechanisms[i] for relays in network.relays for i in relays.entry]
    return tuple((t, names[j].removeprefix("sources."), bool(mode)) for t, j, mode in switches)


def _by_reference(plan: Plan, outputs: Readouts, rtol: float | None, progress: Progress | None) -> Outcome:
    rtol = rtol or REFERENCE_TOLERANCE
    name = plan.method.partition(":")[2]
    solution = reference.solve(plan, outputs, name, rtol, rtol, progress)
    error = _error_from(solution.account, plan.network, rtol, solution.T_end)
    return Outcome(
        plan,
        outputs,
        solution.y,
        solution.T_start,
        solution.T_end,
        solution.account,
        error,
        solution.heat,
        _named(plan.network, solution.switches),
    )


def _trajectory(
    network: Network, schedule: Schedule, outcome: Outcome, seconds: float, noise_seed: int | None
) -> Trajectory:
    machine, plan = network.machine, outcome.plan
    u = plan.inputs_at_samples()
    for name, signal in schedule.signals.items():
        u[name][-1] = signal.at(plan.t[-1:])[0]  # at a jump the value after it, also at the end
    rows = dict(zip(outcome.readouts.keys, outcome.y, strict=False))
    contributions = dict(_contributions(network, rows, u, outcome))
    tcp = {
        axis: sum((contributions[axis, name] for name in entries), np.zeros(len(plan.t)))
        for axis, entries in machine.tcp.items()
    }
    states = outcome.y[len(outcome.readouts.keys) :]
    sensors = {
        name: channel(name, sensor, rows, tcp, dict(zip(outcome.readouts.state_of, states, strict=True)), plan.t)
        for name, sensor in machine.sensors.items()
        if sensor.axis is None or sensor.axis in tcp
    }
    if noise_seed is not None:
        draw = np.random.default_rng(noise_seed)
        sensors = {n: v + machine.sensors[n].sigma * draw.standard_normal(len(v)) for n, v in sensors.items()}
    parts = {key[1]: values for key, values in rows.items() if key[0] == "part"}
    return Trajectory(
        machine, schedule, network, plan.t, {n: u[n] for n in schedule.signals if n in machine.inputs}, sensors, tcp,
        contributions, parts, _part_heat(network, parts, outcome), outcome.T_start, outcome.T_end, outcome.account,
        outcome.switches, plan.method, plan.why, seconds, outcome.error, tuple(_warnings(network, outcome)),
    )  # fmt: skip


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


def _heat_reading(network: Network, place: object, outcome: Outcome) -> Array:
    """Heat in a range above the reference [J]: what was there at the start and what flowed in since."""
    from network.fields import Place

    assert isinstance(place, Place) and outcome.heat is not None
    share = network.heat_row(place)
    cold = stored_heat(network, np.full(network.size, network.machine.reference))
    return np.asarray((outcome.heat + stored_heat(network, outcome.T_start.copy()) - cold) @ share)


def channel(
    name: str, sensor: Sensor, rows: Mapping[tuple[str, ...], Array], tcp: Mapping[str, Array],
    states: Mapping[tuple[str, int], Array], t: Array,
) -> Array:  # fmt: skip
    """The truth through the sensor's effects, in their order."""
    reading = rows["sensor", name] if sensor.axis is None else tcp[sensor.axis]
    for i, effect in enumerate(sensor.effects):
        state = states.get((name, i))
        if state is None:
            state = _followed(effect, t, reading) if effect.has_state else np.zeros_like(reading)
        reading = effect.reading(reading, state)
    return np.asarray(reading - reading[0] if sensor.zero else reading)


def _followed(effect: object, t: Array, truth: Array) -> Array:
    """The state of an effect on a displacement channel: truth straight between samples, integrated exactly."""
    from network.sensors.base import SensorEffect

    assert isinstance(effect, SensorEffect)
    one, zero = np.ones(()), np.zeros(())
    at_zero = float(effect.rate(zero, zero))
    by_truth, by_state = float(effect.rate(one, zero)) - at_zero, float(effect.rate(zero, one)) - at_zero
    h = np.diff(t)[:, None]
    first, second, _ = modal.phi(by_state * h)
    push = by_truth * truth + at_zero
    slope = np.diff(push)[:, None] / h
    states, last = scan(
        np.exp(by_state * h), h * first * push[:-1, None] + h * h * second * slope, push[:1] / -by_state
    )
    return np.append(states[:, 0], last)


def _part_heat(network: Network, parts: Mapping[str, Array], outcome: Outcome) -> dict[str, Array]:
    """Heat absorbed by every part since the start: C ΔT, or what was summed over its lumps where it melts."""
    heat: dict[str, Array] = {}
    for name, T in parts.items():
        capacity = network.capacity[network.parts[name]]
        if network.machine.nodes[name].melts is not None and outcome.heat is not None:
            heat[name] = outcome.heat[:, network.parts[name]].sum(axis=1)
        elif np.isfinite(capacity).all():
            heat[name] = float(capacity.sum()) * (T - float(outcome.T_start[network.parts[name]].mean()))
    return heat


def _warnings(network: Network, outcome: Outcome) -> Iterator[str]:
    yield from (str(warning) for warning in network.machine.warnings)
    plan = outcome.plan
    u = {name: np.concatenate([plan.left[name], plan.right[name]]) for name in plan.left}
    for path, entry in network.machine.entries():
        yield from (f"{path}: {remark}" for remark in (entry.remarks(u) if isinstance(entry, Effect) else ()))
    for name, part in network.parts.items():
        T = float(outcome.T_end[part].max())
        if not PLAUSIBLE[0] < T < PLAUSIBLE[1]:
            yield f"{name} ends at {T:.4g} degC; check its heat sources and losses"
