"""What a machine's channels read at the knots of a run, and how that answers to its parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.sections import TCP
from network.engine.assembly import build
from network.engine.channels import Readouts, readouts
from network.engine.network import Network
from network.engine.response.answers import Answers
from network.engine.response.difference_slopes import differ_otherwise
from network.engine.response.followed_relays import follow_relays, own_numbers
from network.engine.response.heat_sensitivity import Slots, push_of
from network.engine.response.joint_course import can_join, solve_together
from network.engine.response.joint_means import JointMeans
from network.engine.response.linear_run import LinearRun, Push
from network.engine.response.measured_run import Run, join_runs
from network.engine.response.output_jacobian import Slopes, channels_of, see_readings_alone
from network.engine.response.parameters import Parameter, at_values, values_at
from network.engine.response.prediction import Prediction, divide_together, joint_of
from network.engine.response.run_plan import plan_of, start_of
from network.engine.response.switchings import SwitchedCourse, build_course_about, build_switched_course, check_followed
from network.engine.response.warm_start import WarmStart
from network.engine.response.waveform import course_of
from network.engine.solvers.elimination import KnownRegimes
from network.engine.solvers.modal import Modes
from network.engine.solvers.plan import Plan, list_own_edges
from network.machine.machine import Machine

__all__ = ["Model", "Prediction", "Run", "channels_of"]

JOINT = -1
"""The place of all runs as one among what is left of them."""
SHOWN = (TCP, "sensors")
"""Sections of entries whose numbers only change what is seen of a run, or a state that sees it."""


class Model:
    """A machine with free parameters on some runs, its relays switched by their modes where all runs tell these;
    switches: whether it has others, so that what it predicts is rough; warm: what is left of its last predictions."""

    def __init__(self, machine: Machine, parameters: Sequence[Parameter], runs: Sequence[Run]) -> None:
        self.original, self.parameters, self.runs = machine, tuple(parameters), tuple(runs)
        self.machine = follow_relays(machine, _shared_inputs(self.runs))
        self.own = own_numbers(self.machine, self.original, self.parameters)
        network = build(self.machine)
        check_followed(network)
        self.switches = bool(network.relays)
        self.slots = Slots(network, tuple(p for p in self.own if p.entry.section not in SHOWN))
        self.shown = tuple(p for p in self.own if p.entry.section in SHOWN)
        acting = self.slots.acting
        self._idle = [j for j, p in enumerate(self.parameters) if p not in self.own]
        self._otherwise = [j for j, p in enumerate(self.parameters) if p in self.own and p not in acting]
        self._readouts = readouts(network, parts=False)
        self.warm = WarmStart()

    def afresh(self) -> Model:
        """The same without what its predictions left."""
        return self._on(self.runs)

    def about(self, runs: Sequence[Run]) -> Model:
        """The same on the same runs from other temperatures of the parts or under other inputs: what these come to is
        near to what they came to."""
        other = self._on(runs)
        other.warm.guess.update(self.warm.guess)
        other.warm.middle.update(self.warm.middle)
        return other

    def _on(self, runs: Sequence[Run]) -> Model:
        """The same on runs that tell as many modes; nothing is built again for that."""
        other = copy(self)
        other.runs, other.warm = tuple(runs), WarmStart()
        return other

    def at(self, theta: Array) -> tuple[Machine, Network]:
        """Machine and network at θ."""
        values = self.values_at(theta)
        if not self.slots.suffice:
            machine = at_values(self.machine, values)
            return machine, build(machine)
        network = self.slots.at(values)
        if not self.shown:
            return self.machine, network
        machine = at_values(self.machine, {p.path: values[p.path] for p in self.shown})
        return machine, replace(network, machine=machine)

    def values_at(self, theta: Array) -> dict[str, float]:
        """Numbers in SI by path, those that it has."""
        values = values_at(self.parameters, theta)
        return {p.path: values[p.path] for p in self.own} if self._idle else values

    def predict(self, theta: Array, starts: Sequence[Mapping[str, float]] | None = None) -> tuple[Prediction, ...]:
        """All runs at θ. Raises Failed where one runs away."""
        machine, network = self.at(theta)
        return self.run_from(machine, network, starts or [run.start for run in self.runs])

    def run_from(
        self, machine: Machine, network: Network, starts: Sequence[Mapping[str, float]],
        beside: Sequence[Prediction] | None = None,
    ) -> tuple[Prediction, ...]:  # fmt: skip
        """All runs from starts; beside: those whose tangents bent laws beside relays keep."""
        outputs = self._readouts if machine is self.machine else readouts(network, parts=False)
        laid = [self._lay_out(run, network) for run in self.runs]
        plans = [plan.with_network(network, start_of(network, start, plan.left))
                 for plan, start in zip(laid, starts, strict=True)]  # fmt: skip
        known: dict[bytes, Modes] = {}
        regimes: KnownRegimes = {}
        joins = can_join(network, self.runs) and not self.warm.is_apart
        joint = join_runs(self.runs, laid) if joins else None
        near = self.warm.guess.get(JOINT)
        told = None if joint is None else solve_together(joint, plans, outputs, known, regimes, near)
        if joint is None or told is None:
            if beside is not None:
                pairs = zip(plans, beside, strict=True)
                plans = [replace(plan, about=of.course.problem.plan.about) for plan, of in pairs]
            courses = [self._course(i, plan, outputs, known, regimes) for i, plan in enumerate(plans)]
            self.warm.is_apart |= joint is not None
            return self._share_slopes([self._predict(i, machine, course, None) for i, course in enumerate(courses)])
        whole, parts = told
        if not network.is_affine():
            self.warm.guess[JOINT] = whole.T
        same = machine is self.machine and not len(network.massless)
        means = JointMeans(whole, joint, self.warm.beside(joint) if same else None)
        return self._share_slopes([self._predict(i, machine, course, (means, i)) for i, course in enumerate(parts)])

    def _share_slopes(self, made: Sequence[Prediction]) -> tuple[Prediction, ...]:
        """Runs in which channels are seen by other numbers than the file's, but by the same in each: once it is known
        that these hold at all instants, they are found at a few."""
        first, channels = made[0], self.runs[0].channels
        is_alike = self._seen_alike and all(run.channels == channels for run in self.runs)
        if first.machine is self.machine or not is_alike:
            return tuple(made)
        slopes = first.slopes_at_few() if self.warm.is_seen_same else first.slopes
        self.warm.is_seen_same = slopes is not None and slopes.is_same
        return tuple(replace(p, known=slopes) for p in made) if self.warm.is_seen_same else tuple(made)

    def _course(
        self, i: int, plan: Plan, outputs: Readouts, known: dict[bytes, Modes], regimes: KnownRegimes
    ) -> LinearRun:  # fmt: skip
        if plan.network.relays and plan.about is not None:
            return build_switched_course(plan, outputs, known, regimes)
        if plan.network.relays:
            switched, self.warm.middle[i] = build_course_about(plan, outputs, known, regimes, self.warm.middle.get(i))
            return switched
        course = course_of(plan, outputs, self.warm.guess.get(i), known, regimes)
        if not plan.network.is_affine():
            self.warm.guess[i] = course.T
        return course

    def _predict(
        self, i: int, machine: Machine, course: LinearRun, joint: tuple[JointMeans, int] | None
    ) -> Prediction:  # fmt: skip
        slopes = self._known_slopes(i) if machine is self.machine else None
        resampled = self.runs[i].resampled(course.problem.plan.edges)
        made = Prediction(self.runs[i], machine, course, resampled, slopes, joint)
        self._remember(i, made)
        return made

    def _known_slopes(self, i: int) -> Slopes | None:
        """Of a run before, or of the first where all runs are seen by the same law."""
        known = self.warm.slopes
        if i not in known and 0 in known and self.runs[i].channels == self.runs[0].channels and self._seen_alike:
            known[i] = known[0]
        return known.get(i)

    @cached_property
    def _seen_alike(self) -> bool:
        return see_readings_alone(self.machine, self.runs[0].channels)

    def _remember(self, i: int, made: Prediction) -> None:
        """Slopes that are the same at all instants and readings stay so at other θ."""
        if self.parameters and i not in self.warm.slopes and made.machine is self.machine:
            slopes = made.slopes
            if slopes is not None and slopes.is_same:
                known = self.warm.slopes.values()
                self.warm.slopes[i] = next((other for other in known if slopes.equals(other)), slopes)

    @staticmethod
    def _lay_out(run: Run, network: Network) -> Plan:
        """The plan of a run; its edges and inputs are found once for the same edges of laws."""
        own = list_own_edges(network, float(run.schedule.t[-1]))
        instants = (np.concatenate([*own, np.empty(0)]).tobytes(), bool(network.melting))
        return run.layout.plan_at(instants, lambda: plan_of(network, run, run.start))

    def slopes(self, theta: Array, predictions: Sequence[Prediction]) -> list[Array]:
        """∂(channels)/∂θ of every run: (parameters, channels, 2 K) each."""
        others = self._others(theta, predictions)
        out = []
        for r, prediction in enumerate(predictions):
            course = prediction.course
            by_heat, pushes, guards = self._pushes(theta, course)
            slopes = np.empty((len(self.parameters), *prediction.values.shape))
            if by_heat:
                complete = course.complete_pushes(pushes, guards)
                slopes[by_heat] = prediction.changes(course.ends(complete, course.output_map))
            for j, values in others.items():
                slopes[j] = values[r]
            out.append(slopes)
        return out

    def mean_slopes(
        self, theta: Array, predictions: Sequence[Prediction], also: Sequence[Sequence[Push]] | None = None
    ) -> list[Array]:
        """∂(cells' means)/∂θ of every run, below them its answers to further pushes: (parameters + pushes, ·) each."""
        return [answers.whole for answers in self.divide_slopes(theta, predictions, also)]

    def divide_slopes(
        self, theta: Array, predictions: Sequence[Prediction], also: Sequence[Sequence[Push]] | None = None,
        is_rough: bool = False,
    ) -> list[Answers]:  # fmt: skip
        """The same apart by laws; is_rough: without what bent laws add."""
        others, out = self._others(theta, predictions, cells=True), []
        further = divide_together(predictions, also, is_rough) if also else None
        for r, (by_heat, answers) in enumerate(self._heat_slopes(theta, predictions, is_rough)):
            slopes = answers.among(len(self.parameters), by_heat)
            for j, values in others.items():
                slopes.straight[j] = values[r]
            out.append(slopes if further is None else slopes.above(further[r]))
        return out

    def _heat_slopes(
        self, theta: Array, predictions: Sequence[Prediction], is_rough: bool
    ) -> Iterator[tuple[list[int], Answers]]:  # fmt: skip
        """Parameters that act by heat, and what the cells' means of every run answer to them."""
        joint, slopes = joint_of(predictions)
        if joint is not None and slopes is not None:
            by_heat, pushes, _ = self._pushes(theta, joint.course)
            yield from ((by_heat, answers) for answers in joint.divide(pushes, slopes, is_rough))
            return
        for prediction in predictions:
            by_heat, pushes, guards = self._pushes(theta, prediction.course)
            yield by_heat, prediction.divide(pushes, guards, is_rough)

    def _pushes(self, theta: Array, course: LinearRun) -> tuple[list[int], list[Push], Array | None]:
        """Parameters that act by heat, their pushes, and how they move the guards of relays."""
        known, idle = self.slots.stands, {*self._idle}
        acting = ((j, p) for j, p in enumerate(self.parameters) if j not in idle)
        found = [(j, push_of(p, course, float(theta[j]), known.get(p))) for j, p in acting]
        by_heat, pushes = [j for j, p in found if p is not None], [p for _, p in found if p is not None]
        if not isinstance(course, SwitchedCourse):
            return by_heat, pushes, None
        guards = [course.by_guard(self.parameters[j], float(theta[j])) for j in by_heat]
        return by_heat, pushes, np.array(guards).reshape(len(pushes), len(course.events))

    def _others(self, theta: Array, predictions: Sequence[Prediction], cells: bool = False) -> dict[int, list[Array]]:
        """∂(channels)/∂θ_j, or of their cells' means, run by run, of parameters that act otherwise than by heat."""
        moved = {j: differ_otherwise(self, theta, j, predictions, cells) for j in self._otherwise}
        return moved | {j: [np.zeros_like(p.cells if cells else p.values) for p in predictions] for j in self._idle}


def _shared_inputs(runs: Sequence[Run]) -> set[str]:
    return set.intersection(*({*run.schedule.signals} for run in runs)) if runs else set()
