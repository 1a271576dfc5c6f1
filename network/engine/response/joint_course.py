"""Runs of one machine end to end: one course that begins anew with each, so that a fit asks once and not run by run.

A state is forgotten at the end of its run (gain and forcing of its last interval are zero), so answers to heat come for
all runs at once as well. Only for networks that are affine and switch nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.channels import Readouts
from network.engine.network import Network
from network.engine.response.cells import Averages, Samples
from network.engine.response.linear_run import LinearRun
from network.engine.response.measured_run import Resampled, Run
from network.engine.response.modal_march import ModalEnds, follow, modes_by_regime
from network.engine.response.segments import Segment, segments
from network.engine.solvers.elimination import KnownRegimes
from network.engine.solvers.linear import LinearProblem, reduce
from network.engine.solvers.modal import Modes
from network.engine.solvers.plan import Plan

MOST_STATES = 4_000_000
"""Lumps times knots up to which runs are followed as one: beyond, memory counts more than calls."""


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
    def beside(self) -> dict[int, Array]:
        return {}

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


def _join_samples(samples: Sequence[Samples], runs: Sequence[slice], count: int) -> Samples:
    interval = np.concatenate([s.interval + run.start for s, run in zip(samples, runs, strict=True)])
    since, share = (np.concatenate([getattr(s, name) for s in samples]) for name in ("since", "share"))
    return Samples(interval, since, share, count)


@dataclass(frozen=True, eq=False)
class JointCourse(LinearRun):
    """A course of several runs. stretches: as they answer, forgetting at the ends of runs; own: modes of each; runs:
    the intervals of each run."""

    stretches: tuple[Segment, ...] = ()
    own: tuple[ModalEnds, ...] = ()
    runs: tuple[slice, ...] = ()

    @property
    def restarts(self) -> tuple[int, ...]:
        return tuple(run.start for run in self.runs)

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        return self.stretches

    def modal_ends(self, s: Segment) -> ModalEnds:
        return self.own[self.stretches.index(s)]


def solve_together(
    joint: JointPlan, plans: Sequence[Plan], outputs: Readouts, known: dict[bytes, Modes], regimes: KnownRegimes
) -> tuple[JointCourse, list[LinearRun]]:
    """The courses of some runs, and all of them as one; plans: of the runs, in the intervals of the joint one."""
    whole = reduce(joint.plan.with_network(plans[0].network, plans[0].T0), outputs, regimes)
    modes = modes_by_regime(whole, known)
    problems = [_part_of(whole, plan, run) for plan, run in zip(plans, joint.runs, strict=True)]
    starts = {run.start: problem.x0 for run, problem in zip(joint.runs, problems, strict=True)}
    stretches = tuple(segments(whole, modes))
    x0, x1, own = follow(whole, stretches, starts)
    courses = [LinearRun(p, modes, x0[run], x1[run]) for p, run in zip(problems, joint.runs, strict=True)]
    for s in stretches:
        _forget(s, [run.stop - 1 - s.first for run in joint.runs if s.first < run.stop <= s.last])
    return JointCourse(whole, modes, x0, x1, stretches, own, joint.runs), courses


def _forget(s: Segment, ends: list[int]) -> None:
    """Nothing of a stretch is carried beyond the ends of runs."""
    for factor in (s.gain, s.c0, s.c1):
        factor[ends] = 0.0


def _part_of(whole: LinearProblem, plan: Plan, run: slice) -> LinearProblem:
    """The problem of one run."""
    forcing, lumped = whole.forcing, whole.forcing.lumped
    own = replace(
        forcing, held=(forcing.held[0][run], forcing.held[1][run]),
        lumped=lumped and (lumped[0][run], lumped[1][run]),
        sources=tuple((first[run], last[run]) for first, last in forcing.sources),
    )  # fmt: skip
    part = replace(
        whole, plan=plan, regime_of=whole.regime_of[run], forcing=own, f0=whole.f0[run], f1=whole.f1[run]
    )  # fmt: skip
    return replace(part, x0=part.begin(plan.T0))


def can_join(network: Network, runs: Sequence[Run]) -> bool:
    """Whether runs of a network can be followed as one."""
    same = all(run.channels == runs[0].channels for run in runs[1:])
    few = sum(len(run.knots.t) for run in runs) * network.size <= MOST_STATES
    return len(runs) > 1 and same and few and network.is_affine() and not network.relays
