"""Means over the cells of several runs that were found as one, and of what they answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.cell_means import Means, first_seen
from network.engine.response.joint_course import JointCourse
from network.engine.response.linear_run import Push, kick
from network.engine.response.measured_run import JointPlan
from network.engine.response.output_jacobian import Slopes


@dataclass(frozen=True, eq=False)
class JointMeans:
    """The cells of all runs of a joint course. beside: by run, what its channels owe to all but the states, as it is
    found; None where that is not the same for every θ."""

    course: JointCourse
    joint: JointPlan
    beside: dict[int, Array] | None

    @cached_property
    def _means(self) -> Means:
        return Means(self.course, self.joint.averages)

    @cached_property
    def _found(self) -> dict[bytes, list[Array]]:
        return {}

    def bulge(self, index: int, matrix: Array) -> Array:
        """What the means of a run differ by from those of straight lines, for combinations of what is seen."""
        key = matrix.tobytes()
        if key not in self._found:
            self._found[key] = self._split(self._means.bulge(self.course.output_map.through(matrix)))
        return self._found[key][index]

    def follow_states(self, index: int, slopes: Slopes) -> Array:
        """What the means of a run's channels owe to its states."""
        if b"" not in self._found:
            output_map = self.course.output_map.through(slopes.matrix)
            self._found[b""] = self._split(self._means.follow_states(output_map))
            for own, run in zip(self._found[b""], self.joint.runs, strict=True):
                at = output_map.over[int(self.course.problem.regime_of[run.start])] @ self.course.x0[run.start]
                own[slopes.zeroed] -= at[slopes.zeroed, None]
        return self._found[b""][index]

    def respond_to(self, pushes: Sequence[Push], slopes: Slopes) -> list[Array]:
        """Changes of the cells' means of every run by pushes: (pushes, channels · cells) each."""
        if not pushes:
            return [np.empty((0, len(slopes.matrix) * cells)) for cells in self.joint.cells]
        output_map = self.course.output_map.through(slopes.matrix)
        means = self._split(self._means.respond_to(pushes, output_map))
        for own, run in zip(means, self.joint.runs, strict=True) if slopes.zeroed.any() else ():
            seen = first_seen(self.course, pushes, output_map, run.start)
            own[:, slopes.zeroed] -= seen[:, slopes.zeroed, None]
        return [own.reshape(len(pushes), -1) for own in means]

    def respond_to_starts(self, pushes: Sequence[Push], slopes: Slopes) -> list[Array]:
        """The same by jumps at the beginning of a run, which are those of every run."""
        jumps = (push.kicks[0][1] for push in pushes)
        everywhere = [kick(self.course, *((k, jump) for k in self.course.restarts)) for jump in jumps]
        return self.respond_to(everywhere, slopes)

    def _split(self, values: Array) -> list[Array]:
        return np.split(values, np.cumsum(self.joint.cells)[:-1], axis=-1)


def common_starts(pushes: Sequence[Sequence[Push]]) -> int:
    """How many pushes that the runs begin with are the same jump at the beginning of each run."""
    count = 0
    for each in zip(*pushes, strict=False):
        jumps = [push.kicks[0][1] for push in each if not push.is_heat and [k for k, _ in push.kicks] == [0]]
        if len(jumps) < len(each) or any(not np.array_equal(jumps[0], jump) for jump in jumps[1:]):
            break
        count += 1
    return count
