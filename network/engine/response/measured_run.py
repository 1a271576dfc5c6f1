"""A recording made ready for fits: its intervals, and the cells of it that these are averaged to, alone and as one of
several runs that follow each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array, Mask
from network.engine.response.cells import Averages, Samples, averages
from network.engine.response.knots import Knots
from network.engine.solvers.plan import Plan
from network.recordings.inputs import Schedule, Start


@dataclass(frozen=True, eq=False)
class Run:
    """A recording made ready for fits. schedule: inputs on the knots; start: temperatures of the parts at the start;
    present: channel → which samples are used; layout: what fits of it work out, whatever the start."""

    name: str
    schedule: Schedule
    knots: Knots
    start: Mapping[str, float]
    present: Mapping[str, Mask]
    layout: Layout = field(default_factory=lambda: Layout(), init=False, repr=False)

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.present)

    def begun(self, start: Mapping[str, float], rule: Start | None) -> Run:
        """The same from other temperatures of the parts, as a rule for starts gives them."""
        other = replace(self, start=start, schedule=replace(self.schedule, start=rule))
        other.__dict__["layout"] = self.layout
        return other

    def driven_by(self, schedule: Schedule) -> Run:
        """The same with other inputs at the same instants."""
        other = replace(self, schedule=schedule)
        other.layout.resampled = self.layout.resampled
        return other

    def resampled(self, edges: Array) -> Resampled:
        """Its cells over the intervals between some edges."""
        last = self.layout.resampled
        if last is None or not (last.edges is edges or np.array_equal(last.edges, edges)):
            self.layout.resampled = last = Resampled(self, edges)
        return last


@dataclass(frozen=True, eq=False)
class Resampled:
    """The cells of a run over the intervals between some edges, worked out when they are asked for."""

    run: Run
    edges: Array

    @cached_property
    def averages(self) -> Averages:
        return averages(self.run.knots, self.edges, list(self.run.present.values()))


@dataclass(eq=False)
class Layout:
    """How a run was last laid out: networks whose laws jump at the same instants lay it out alike.

    plan: with the instants that it depends on; resampled: the cells of its intervals; joint: the plan of it and the
    runs that follow it, where these are followed as one.
    """

    plan: tuple[object, Plan] | None = None
    resampled: Resampled | None = None
    joint: JointPlan | None = None

    def plan_at(self, instants: object, make: Callable[[], Plan]) -> Plan:
        """The plan for laws that jump at some instants."""
        if self.plan is None or self.plan[0] != instants:
            self.plan = instants, make()
        return self.plan[1]

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process works it out for itself."""
        return Layout, ()


@dataclass(frozen=True, eq=False)
class JointPlan:
    """The plans of some runs, and the cells of each."""

    parts: tuple[Plan, ...]
    resampled: tuple[Resampled, ...]

    @cached_property
    def runs(self) -> tuple[slice, ...]:
        """The intervals of each run."""
        ends = np.cumsum([0, *(len(p.steps) for p in self.parts)]).tolist()
        return tuple(slice(a, b) for a, b in pairwise(ends))

    @cached_property
    def plan(self) -> Plan:
        """One after the other, on one clock."""
        first, steps = self.parts[0], np.concatenate([p.steps for p in self.parts])
        names = [n for n in first.left if all(n in p.left for p in self.parts)]
        left, right = ({n: np.concatenate([getattr(p, side)[n] for p in self.parts]) for n in names}
                       for side in ("left", "right"))  # fmt: skip
        plan = replace(first, edges=np.concatenate([[0.0], np.cumsum(steps)]), left=left, right=right)
        plan.__dict__["steps"] = steps
        return plan

    @cached_property
    def cells(self) -> tuple[int, ...]:
        return tuple(r.averages.cells for r in self.resampled)

    @cached_property
    def averages(self) -> Averages:
        """The cells of all runs, one run after the other."""
        over = [r.averages for r in self.resampled]
        sets = list(zip(*(own.set_of.tolist() for own in over), strict=True))
        different, count = list(dict.fromkeys(sets)), self.runs[-1].stop
        starts = np.concatenate([own.starts + run.start for own, run in zip(over, self.runs, strict=True)])
        left, right = (np.array([np.concatenate([getattr(own, side)[i] for own, i in zip(over, of, strict=True)])
                                 for of in different]) for side in ("left", "right"))  # fmt: skip
        samples = tuple(_join_samples([own.samples[i] for own, i in zip(over, of, strict=True)], self.runs, count)
                        for of in different)  # fmt: skip
        return Averages(starts, left, right, np.array([different.index(of) for of in sets]), samples)


def join_runs(runs: Sequence[Run], plans: Sequence[Plan]) -> JointPlan:
    """Some runs and their plans as one; as before where these are the same."""
    layout = runs[0].layout
    if layout.joint is None or [*map(id, layout.joint.parts)] != [*map(id, plans)]:
        cells = tuple(run.resampled(plan.edges) for run, plan in zip(runs, plans, strict=True))
        layout.joint = JointPlan(tuple(plans), cells)
    return layout.joint


def _join_samples(samples: Sequence[Samples], runs: Sequence[slice], count: int) -> Samples:
    interval = np.concatenate([s.interval + run.start for s, run in zip(samples, runs, strict=True)])
    since, share = (np.concatenate([getattr(s, name) for s in samples]) for name in ("since", "share"))
    return Samples(interval, since, share, count)
