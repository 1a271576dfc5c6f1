"""Runs of one machine end to end: one course that begins anew with each, so that a fit asks once and not run by run.

A state is forgotten at the end of its run (gain and forcing of its last interval are zero), so answers to heat come for
all runs at once as well. Only for networks that are affine and switch nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from network.engine.channels import Readouts
from network.engine.network import Network
from network.engine.response.linear_run import LinearRun
from network.engine.response.measured_run import JointPlan, Run
from network.engine.response.modal_march import ModalEnds, follow, modes_by_regime
from network.engine.response.segments import Segment, segments
from network.engine.solvers.elimination import KnownRegimes
from network.engine.solvers.linear import LinearProblem, reduce
from network.engine.solvers.modal import Modes
from network.engine.solvers.plan import Plan

MOST_STATES = 4_000_000
"""Lumps times knots up to which runs are followed as one: beyond, memory counts more than calls."""


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
