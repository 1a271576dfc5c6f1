"""Means over the cells of several runs that were found as one, and of what they answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.answers import Answers
from network.engine.response.cell_means import Means, first_seen
from network.engine.response.linear_run import LinearRun, Push, kick
from network.engine.response.measured_run import JointPlan
from network.engine.response.output_jacobian import Slopes


@dataclass(frozen=True, eq=False)
class JointMeans:
    """The cells of all runs of a joint course. beside: by run, what its channels owe to all but the states, as it is
    found; None where that is not the same for every θ."""

    course: LinearRun
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
        return [answers.whole for answers in self.divide(pushes, slopes)]

    def divide(self, pushes: Sequence[Push], slopes: Slopes, is_rough: bool = False) -> list[Answers]:
        """The same apart by laws; is_rough: without what bent laws add."""
        if not pushes:
            return [Answers(np.empty((0, len(slopes.matrix) * cells))) for cells in self.joint.cells]
        own, bent = (self.course.straighten(pushes), None) if is_rough else self.course.divide_pushes(pushes)
        straight, added = self._respond_to(own, slopes), self._respond_to(bent, slopes) if bent else ()
        return [Answers(*pair) for pair in zip(straight, added, strict=True)] if added else [*map(Answers, straight)]

    def _respond_to(self, pushes: Sequence[Push], slopes: Slopes) -> list[Array]:
        output_map = self.course.output_map.through(slopes.matrix)
        means = self._split(self._means.respond_to(pushes, output_map))
        for own, run in zip(means, self.joint.runs, strict=True) if slopes.zeroed.any() else ():
            seen = first_seen(self.course, pushes, output_map, run.start)
            own[:, slopes.zeroed] -= seen[:, slopes.zeroed, None]
        return [own.reshape(len(pushes), -1) for own in means]

    def divide_own(self, pushes: Sequence[Sequence[Push]], slopes: Slopes, is_rough: bool = False) -> list[Answers]:
        """The same by pushes of each run alone, as this counts its intervals: what one of every run does comes at once,
        for no run feels those of another."""
        together = [self._lay_out(each) for each in zip_longest(*pushes)]
        told = zip(self.divide(together, slopes, is_rough), pushes, strict=True)
        return [answers.first(len(mine)) for answers, mine in told]

    def _lay_out(self, pushes: Sequence[Push | None]) -> Push:
        """Pushes of the runs, one of each or none, as one of them all."""
        placed = [(run, push) for run, push in zip(self.joint.runs, pushes, strict=True) if push is not None]
        kicks = tuple((run.start + k, jump) for run, push in placed for k, jump in push.all_kicks)
        heats = [(run, push) for run, push in placed if push.is_heat]
        if not heats:
            return kick(self.course, *kicks)
        lumps = np.unique(np.concatenate([push.lumps for _, push in heats]))
        q0, q1 = np.zeros((2, len(self.course.x0), len(lumps)))
        for run, push in heats:
            into = push.into(np.eye(int(lumps.max()) + 1)[lumps])
            q0[run], q1[run] = push.q0 @ into, push.q1 @ into
        return Push(lumps, q0, q1, kicks)

    def _split(self, values: Array) -> list[Array]:
        return np.split(values, np.cumsum(self.joint.cells)[:-1], axis=-1)
