"""Runs of one machine end to end: one course that begins anew with each, so that a fit asks once and not run by run.

A state is forgotten at the end of its run (gain and forcing of its last interval are zero), so answers to heat come for
all runs at once as well. Only for networks that switch nothing and in which nothing melts.
"""

from __future__ import annotations

from collections.abc import Sequence

from network.engine.channels import Readouts
from network.engine.network import Network
from network.engine.response.bent_rounds import Guess
from network.engine.response.linear_run import LinearRun, solve
from network.engine.response.measured_run import JointPlan, Run
from network.engine.response.nonlinear_correction import BentCourse
from network.engine.response.waveform import course_of_runs
from network.engine.solvers.elimination import KnownRegimes
from network.engine.solvers.linear import begin_runs, part_of, reduce
from network.engine.solvers.modal import Modes
from network.engine.solvers.plan import Plan

MOST_STATES = 4_000_000
"""Lumps times knots up to which runs are followed as one: beyond, memory counts more than calls."""
MOST_BENT = 30_000_000
"""Lumps squared times knots, where laws are bent and every interval is a matrix."""


def solve_together(
    joint: JointPlan, plans: Sequence[Plan], outputs: Readouts, known: dict[bytes, Modes], regimes: KnownRegimes,
    guess: Guess | None = None,
) -> tuple[LinearRun, list[LinearRun]] | None:  # fmt: skip
    """All of some runs as one course, and the course of each; plans: of the runs, in the intervals of the joint one.
    None where bent laws do not settle in all of them at once."""
    plan = joint.plan.with_network(plans[0].network, plans[0].T0)
    if plan.network.is_affine():
        problem = reduce(plan, outputs, regimes)
        whole = solve(problem, known, starts=begin_runs(problem, plans, joint.runs))
    else:
        bent = course_of_runs(plan, outputs, plans, joint.runs, guess, known)
        if bent is None:
            return None
        whole = bent
    return whole, [_take_run(whole, own, run) for own, run in zip(plans, joint.runs, strict=True)]


def _take_run(whole: LinearRun, plan: Plan, run: slice) -> LinearRun:
    """The course of one run."""
    problem = part_of(whole.problem, plan, run)
    if isinstance(whole, BentCourse):
        bends = whole.bends and whole.bends.within(run)
        return BentCourse(problem, whole.modes, whole.x0[run], whole.x1[run], bends=bends)
    return LinearRun(problem, whole.modes, whole.x0[run], whole.x1[run])


def can_join(network: Network, runs: Sequence[Run]) -> bool:
    """Whether runs of a network can be followed as one."""
    same = all(run.channels == runs[0].channels for run in runs[1:])
    knots = sum(len(run.knots.t) for run in runs)
    few = knots * network.size <= MOST_STATES if network.is_affine() else knots * network.size**2 <= MOST_BENT
    return len(runs) > 1 and same and few and not (network.relays or network.melting)
