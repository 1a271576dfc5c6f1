"""A run of a machine as its channels show it, and how they answer to further heat."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Mask
from network.engine.response.cell_means import Means, first_seen
from network.engine.response.cells import Averages, averages
from network.engine.response.knots import Knots
from network.engine.response.linear_run import LinearRun, Push
from network.engine.response.output_jacobian import SMALL, Slopes, channels_of, slopes_of
from network.machine.machine import Machine
from network.recordings.inputs import Schedule


@dataclass(frozen=True, eq=False)
class Run:
    """A recording made ready for fits. schedule: inputs on the knots; T0: temperatures of all lumps at the start, by
    part; present: channel → which samples are used."""

    name: str
    schedule: Schedule
    knots: Knots
    start: Mapping[str, float]
    present: Mapping[str, Mask]

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.present)


@dataclass(frozen=True, eq=False)
class Resampled:
    """The cells of a run over the intervals between some edges, worked out when they are asked for."""

    run: Run
    edges: Array

    @cached_property
    def averages(self) -> Averages:
        return averages(self.run.knots, self.edges, list(self.run.present.values()))


@dataclass(frozen=True, eq=False)
class Prediction:
    """One run of a machine at some values: channels at both ends of the intervals (2 K each). known: how its channels
    follow the readings, where that is the same for every run and θ."""

    run: Run
    machine: Machine
    course: LinearRun
    resampled: Resampled
    known: Slopes | None = None

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
        straight = self.averages.of(self.values)
        slopes, course = self.slopes, self.course
        if slopes is None:
            return np.asarray(straight.reshape(-1))
        if slopes.is_constant:
            return np.asarray(straight + self._means.bulge(course.output_map.through(slopes.matrix))).reshape(-1)
        rows = np.eye(course.output_map.count)[:, None].repeat(len(straight), axis=1)
        bulge = np.stack([self._means.bulge(course.output_map.through(row)) for row in rows])
        mean = self.averages.of(slopes.matrix.transpose(1, 0, 2))
        return np.asarray(straight + (mean * bulge).sum(axis=0)).reshape(-1)

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
        if not pushes:
            return np.empty((0, len(self.run.present) * self.averages.cells))
        pushes, slopes, course = self.course.complete_pushes(pushes, by_guard), self.slopes, self.course
        if slopes is None or not slopes.is_constant:
            return self.means(self.changes(course.ends(pushes, course.output_map)))
        output_map = course.output_map.through(slopes.matrix)
        means = self._means.respond_to(pushes, output_map)
        if slopes.zeroed.any():
            means[:, slopes.zeroed] -= first_seen(course, pushes, output_map)[:, slopes.zeroed, None]
        return means.reshape(len(pushes), -1)
