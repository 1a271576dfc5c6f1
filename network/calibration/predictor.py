"""What a machine's channels read at the knots of a run, and how that answers to its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.calibration.course import Course, Push, kick
from network.calibration.knots import Knots, cell_matrix
from network.calibration.parameters import Parameter, at_values, values_at
from network.calibration.partials import Slots, inputs_at_ends, push_of
from network.calibration.switchings import SwitchedCourse, switched_course
from network.calibration.waveform import course_of
from network.channels import Readouts, readouts
from network.declare import Array
from network.graph import Network, build
from network.inputs import Schedule
from network.machine import Machine
from network.observe import channel
from network.solvers.plan import Plan, joined, interval_edges, spans

DIFFERENCE = 1e-4
"""Step in θ for parameters that act otherwise than by heat."""
SMALL = 1e-4


@dataclass(frozen=True, eq=False)
class Run:
    """A recording made ready for fits. schedule: inputs on the knots; T0: temperatures of all lumps at the start, by
    part; present: channel → which samples are used."""

    name: str
    schedule: Schedule
    knots: Knots
    start: Mapping[str, float]
    present: Mapping[str, Array]

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.present)


@dataclass(frozen=True, eq=False)
class Prediction:
    """One run of a machine at some values: channels at both ends of the intervals (2 K each)."""

    run: Run
    machine: Machine
    course: Course

    @cached_property
    def matrices(self) -> Mapping[str, Array]:
        """Channel → means over its cells from values at the ends of the intervals."""
        edges = self.course.problem.plan.edges
        made: dict[bytes, Array] = {}
        for present in self.run.present.values():
            if present.tobytes() not in made:
                made[present.tobytes()] = cell_matrix(self.run.knots, edges, present)
        return {name: made[present.tobytes()] for name, present in self.run.present.items()}

    @cached_property
    def inputs(self) -> dict[str, Array]:
        return {name: values[:, 0] for name, values in inputs_at_ends(self.course.problem.plan).items()}

    @cached_property
    def values(self) -> Array:
        """Channels at both ends of the intervals (channels, 2 K)."""
        return self.read(self.machine, self.course.readings)

    def read(self, machine: Machine, readings: Array) -> Array:
        """Channels of a machine from base readings (width, 2 K)."""
        return channels_of(machine, self.course.readouts, readings, self.inputs, self.run.channels)

    def changes(self, answers: Array) -> Array:
        """Changes of the channels (pushes, channels, 2 K) from those of base readings."""
        base = self.values
        return np.stack([(self.read(self.machine, self.course.readings + SMALL * a) - base) / SMALL for a in answers])

    def means(self, values: Array) -> Array:
        """Means over cells (…, channels · cells) from values at both ends of the intervals (…, channels, 2 K)."""
        parts = [values[..., i, :] @ self.matrices[name].T for i, name in enumerate(self.run.channels)]
        return np.concatenate(parts, axis=-1)


def channels_of(
    machine: Machine, outputs: Readouts, readings: Array, u: Mapping[str, Array], names: Sequence[str]
) -> Array:
    """Channels (names, instants) from base readings and sensor states."""
    rows, count = outputs.named(readings), readings.shape[1]
    tcp: dict[str, Array] = {}
    for axis, entries in machine.tcp.items():
        moved = np.zeros(count)
        for name, entry in entries.items():
            read = [rows["reading", axis, name, str(i)] for i in range(len(entry.readings()))]
            moved = moved + entry.movement(u, *read)
        tcp[axis] = moved
    states = dict(zip(outputs.state_of, readings[len(outputs.rows) :], strict=True))
    return np.stack([channel(n, machine.sensors[n], rows, tcp, states, u) for n in names])


class Model:
    """A machine with free parameters on some runs."""

    def __init__(self, machine: Machine, parameters: Sequence[Parameter], runs: Sequence[Run]) -> None:
        self.machine, self.parameters, self.runs = machine, tuple(parameters), tuple(runs)
        network = build(machine)
        self.slots = Slots(network, self.parameters)
        self._fast = self.slots.suffice
        self._readouts = readouts(network, parts=False)
        self._guess: dict[int, tuple[Array, Array]] = {}

    def at(self, theta: Array) -> tuple[Machine, Network]:
        """Machine and network at θ."""
        values = values_at(self.parameters, theta)
        if self._fast:
            return self.machine, self.slots.at(values)
        machine = at_values(self.machine, values)
        return machine, build(machine)

    def predict(self, theta: Array, starts: Sequence[Mapping[str, float]] | None = None) -> tuple[Prediction, ...]:
        """All runs at θ. Raises Failed where one runs away."""
        machine, network = self.at(theta)
        outputs = self._readouts if self._fast else readouts(network, parts=False)
        return tuple(self._predict(i, run, machine, network, outputs, starts[i] if starts else run.start)
                     for i, run in enumerate(self.runs))  # fmt: skip

    def _predict(
        self, i: int, run: Run, machine: Machine, network: Network, outputs: Readouts, start: Mapping[str, float]
    ) -> Prediction:
        plan = plan_of(network, run, start)
        if network.relays:
            return Prediction(run, machine, switched_course(plan, outputs))
        course = course_of(plan, outputs, self._guess.get(i))
        if not network.is_affine():
            self._guess[i] = course.T
        return Prediction(run, machine, course)

    def slopes(self, theta: Array, predictions: Sequence[Prediction]) -> list[Array]:
        """∂(channels)/∂θ of every run: (parameters, channels, 2 K) each."""
        out = []
        others: dict[int, list[Array]] = {}
        for j, parameter in enumerate(self.parameters):
            if push_of(parameter, predictions[0].course, float(theta[j])) is None:
                others[j] = self._differences(theta, j, predictions)
        for r, prediction in enumerate(predictions):
            out.append(self._slopes(theta, prediction, {j: d[r] for j, d in others.items()}))
        return out

    def _slopes(self, theta: Array, prediction: Prediction, others: Mapping[int, Array]) -> Array:
        course = prediction.course
        by_heat = [j for j in range(len(self.parameters)) if j not in others]
        pushes = [push_of(self.parameters[j], course, float(theta[j])) for j in by_heat]
        pushed = [p for p in pushes if p is not None]
        if isinstance(course, SwitchedCourse):
            guards = [course.by_guard(self.parameters[j], float(theta[j])) for j in by_heat]
            answers = course.answers_with(pushed, np.array(guards).reshape(len(pushed), len(course.events)))
        else:
            answers = course.answers(pushed)
        slopes = np.empty((len(self.parameters), *prediction.values.shape))
        if by_heat:
            slopes[by_heat] = prediction.changes(answers)
        for j, values in others.items():
            slopes[j] = values
        return slopes

    def _differences(self, theta: Array, j: int, predictions: Sequence[Prediction]) -> list[Array]:
        """∂(channels)/∂θ_j by a difference of whole runs."""
        p = self.parameters[j]
        step = DIFFERENCE if theta[j] + DIFFERENCE <= p.high else -DIFFERENCE
        if not p.is_log:
            step *= max(p.spread, 1e-9) if np.isfinite(p.spread) else 1.0
        there = theta.copy()
        there[j] += step
        values = values_at(self.parameters, there)
        machine = at_values(self.machine, values)
        if p.entry.startswith("tcp."):
            return [(q.read(at_values(q.machine, {p.path: values[p.path]}), q.course.readings) - q.values) / step
                    for q in predictions]  # fmt: skip
        network = build(machine)
        outputs = readouts(network, parts=False)
        moved = [self._predict(i, run, machine, network, outputs, self._start_of(predictions[i]))
                 for i, run in enumerate(self.runs)]  # fmt: skip
        return [(_onto(m, q) - q.values) / step for m, q in zip(moved, predictions, strict=True)]

    @staticmethod
    def _start_of(prediction: Prediction) -> Mapping[str, float]:
        plan = prediction.course.problem.plan
        return {name: float(plan.T0[part].mean()) for name, part in plan.network.parts.items()}


def _onto(moved: Prediction, at: Prediction) -> Array:
    """Values of one prediction at the edges of another (they differ where relays switch)."""
    there, here = moved.course.problem.plan.edges, at.course.problem.plan.edges
    if len(there) == len(here):
        return moved.values
    K, L = len(there) - 1, len(here) - 1
    k = np.clip(np.searchsorted(there, (here[1:] + here[:-1]) / 2) - 1, 0, K - 1)
    left, right = ((x - there[k]) / (there[k + 1] - there[k]) for x in (here[:-1], here[1:]))
    v0, v1 = moved.values[:, :K], moved.values[:, K:]
    out = np.empty((len(v0), 2 * L))
    out[:, :L] = v0[:, k] + left * (v1 - v0)[:, k]
    out[:, L:] = v0[:, k] + right * (v1 - v0)[:, k]
    return out


def plan_of(network: Network, run: Run, start: Mapping[str, float]) -> Plan:
    """The plan of a run: restarts at every knot and wherever a law says so."""
    edges = joined(interval_edges(network, run.schedule), run.knots.t)
    left, right = spans(run.schedule, edges)
    T0 = np.full(network.size, network.machine.reference)
    for name, part in network.parts.items():
        T0[part] = start.get(name, network.machine.reference)
    held = {i: left[source][0] if isinstance(source, str) else source for i, source in network.held.items()}
    for i, value in held.items():
        T0[i] = value
    return Plan(network, run.schedule.t, edges, left, right, T0, "modal", "on the knots of a fit")


def start_pushes(course: Course, parts: Sequence[str]) -> list[Push]:
    """One kelvin more in a part at the start, for each part."""
    network = course.problem.plan.network
    pushes = []
    for name in parts:
        part = network.parts[name]
        jump = np.zeros(course.problem.order)
        jump[: len(network.free)] = (network.free >= part.start) & (network.free < part.stop)
        pushes.append(kick(course, (0, jump)))
    return pushes


def edge_pushes(course: Course, instants: Array) -> list[Push]:
    """A jump of the inputs that comes a second later, for each instant."""
    plan = course.problem.plan
    dx0, dx1 = course.rates
    pushes = []
    for t in instants:
        k = int(np.argmin(np.abs(plan.edges - t)))
        pushes.append(kick(course, (k, dx1[k - 1] - dx0[k])))
    return pushes
