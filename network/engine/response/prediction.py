"""A run of a machine as its channels show it, and how they answer to further heat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.answers import Answers
from network.engine.response.cell_means import Means, first_seen
from network.engine.response.cells import Averages
from network.engine.response.joint_means import JointMeans
from network.engine.response.linear_run import LinearRun, Push
from network.engine.response.measured_run import Resampled, Run
from network.engine.response.output_jacobian import SMALL, Slopes, channels_of, slopes_of
from network.machine.machine import Machine

INSTANTS = 4
"""At which slopes of channels are found that are known to be the same at all."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """One run of a machine at some values: channels at both ends of the intervals (2 K each). known: how its channels
    follow the readings, where that is the same for every run and θ; joint: its place among runs that were found as
    one."""

    run: Run
    machine: Machine
    course: LinearRun
    resampled: Resampled
    known: Slopes | None = None
    joint: tuple[JointMeans, int] | None = None

    @property
    def begun(self) -> dict[str, float]:
        """Temperatures of the parts at the start."""
        plan = self.course.problem.plan
        return {name: float(plan.T0[part].mean()) for name, part in plan.network.parts.items()}

    @property
    def averages(self) -> Averages:
        return self.resampled.averages

    @cached_property
    def _means(self) -> Means:
        return Means(self.course, self.averages)

    @cached_property
    def cells(self) -> Array:
        """Means over cells of the channels (channels · cells), with the bend of the run between its knots."""
        slopes = self.slopes
        beside = None if self.joint is None else self.joint[0].beside
        if slopes is None or self.joint is None or beside is None or not slopes.is_same:
            return self._add_bulge().reshape(-1)
        means, index = self.joint
        seen = means.follow_states(index, slopes)
        if index not in beside:
            beside[index] = self._add_bulge() - seen
        return (seen + beside[index]).reshape(-1)

    def _add_bulge(self) -> Array:
        """The same from the ends of the intervals (channels, cells)."""
        straight = self.averages.of(self.values)
        slopes, course = self.slopes, self.course
        if slopes is None:
            return straight
        if slopes.is_constant:
            return np.asarray(straight + self._bulge(slopes.matrix))
        rows = np.eye(course.output_map.count)[:, None].repeat(len(straight), axis=1)
        bulge = np.stack([self._means.bulge(course.output_map.through(row)) for row in rows])
        mean = self.averages.of(slopes.matrix.transpose(1, 0, 2))
        return np.asarray(straight + (mean * bulge).sum(axis=0))

    def _bulge(self, matrix: Array) -> Array:
        if self.joint is None:
            return self._means.bulge(self.course.output_map.through(matrix))
        return self.joint[0].bulge(self.joint[1], matrix)

    @cached_property
    def inputs(self) -> dict[str, Array]:
        return {name: values[:, 0] for name, values in self.course.inputs.items()}

    @cached_property
    def values(self) -> Array:
        """Channels at both ends of the intervals (channels, 2 K)."""
        return self.read(self.machine, self.course.readings)

    def read(self, machine: Machine, readings: Array, names: Sequence[str] | None = None) -> Array:
        """Channels of a machine from base readings (width, 2 K); names: some of them, default all."""
        return channels_of(machine, self.course.readouts, readings, self.inputs, names or self.run.channels)

    @cached_property
    def slopes(self) -> Slopes | None:
        """How the channels follow the readings; None where one depends on readings before its instant."""
        if self.known is not None:
            return self.known
        course = self.course
        return slopes_of(self.machine, course.readouts, course.readings, self.inputs, self.run.channels)

    def slopes_at_few(self) -> Slopes | None:
        """The same from a few instants alone, for channels that are known to follow readings alike at all of them."""
        course, few = self.course, np.linspace(0, len(self.course.x0) - 1, INSTANTS).astype(int)
        inputs = {name: values[few] for name, values in self.inputs.items()}
        return slopes_of(self.machine, course.readouts, course.readings[:, few], inputs, self.run.channels)

    def changes(self, answers: Array) -> Array:
        """Changes of the channels (pushes, channels, 2 K) from those of base readings."""
        if self.slopes is not None:
            return self.slopes(answers)
        base = self.values
        return np.stack([(self.read(self.machine, self.course.readings + SMALL * a) - base) / SMALL for a in answers])

    def means(self, values: Array) -> Array:
        """Means over cells (…, channels · cells) of straight lines between values (…, channels, 2 K); those of the run
        itself are `cells`."""
        return np.asarray(self.averages.of(values).reshape(*values.shape[:-2], -1))

    def respond_to(self, pushes: Sequence[Push], by_guard: Array | None = None) -> Array:
        """Changes of the cells' means by pushes: (pushes, channels · cells), as means(changes(answers)) but at once."""
        return self.divide(pushes, by_guard).whole

    def divide(self, pushes: Sequence[Push], by_guard: Array | None = None, is_rough: bool = False) -> Answers:
        """The same apart by laws, where channels follow readings alike at all instants; is_rough: without what bent
        laws add."""
        if not pushes:
            return Answers(np.empty((0, len(self.run.present) * self.averages.cells)))
        slopes, course = self.slopes, self.course
        if slopes is None or not slopes.is_constant:
            complete = course.complete_pushes(pushes, by_guard)
            return Answers(self.means(self.changes(course.ends(complete, course.output_map))))
        if is_rough and by_guard is None:
            return Answers(self._respond_to(course.straighten(pushes), slopes))
        own, bent = course.divide_pushes(pushes, by_guard)
        return Answers(self._respond_to(own, slopes), self._respond_to(bent, slopes) if bent else None)

    def _respond_to(self, pushes: Sequence[Push], slopes: Slopes) -> Array:
        course, output_map = self.course, self.course.output_map.through(slopes.matrix)
        means = self._means.respond_to(pushes, output_map)
        if slopes.zeroed.any():
            means[:, slopes.zeroed] -= first_seen(course, pushes, output_map)[:, slopes.zeroed, None]
        return means.reshape(len(pushes), -1)


def joint_of(predictions: Sequence[Prediction]) -> tuple[JointMeans | None, Slopes | None]:
    """What runs were found as one with, and how their channels follow readings, where this is the same for all."""
    joint = predictions[0].joint if predictions else None
    if joint is None or any(p.joint != (joint[0], i) for i, p in enumerate(predictions)):
        return None, None
    slopes = predictions[0].slopes
    if slopes is None or not slopes.is_constant or any(p.slopes is not slopes for p in predictions):
        return None, None
    return (joint[0], slopes) if len(predictions) == len(joint[0].joint.runs) else (None, None)


def answer_together(predictions: Sequence[Prediction], pushes: Sequence[Sequence[Push]]) -> list[Array]:
    """Changes of the cells' means of every run by its own pushes; at once where the runs were found as one."""
    return [answers.whole for answers in divide_together(predictions, pushes)]


def divide_together(
    predictions: Sequence[Prediction], pushes: Sequence[Sequence[Push]], is_rough: bool = False
) -> list[Answers]:  # fmt: skip
    """The same apart by laws; is_rough: without what bent laws add."""
    joint, slopes = joint_of(predictions)
    if joint is None or slopes is None:
        return [p.divide(own, None, is_rough) for p, own in zip(predictions, pushes, strict=True)]
    return joint.divide_own(pushes, slopes, is_rough)
