"""Networks that are not linear in temperature, as linear ones with a heat that is corrected until it agrees.

In windows of time the heat balance is linearised; what the straight laws leave out is a heat over time that follows
the run: T ← answer to K_w T + [Q(T_before) − K_w T_before]. Each round shrinks the error by the ratio of the slopes
left out to the conductances around them. Sources that read temperatures are first left out of K_w, which stays
symmetric and the same in all windows then; where that is too slow, everything goes in; where a first guess is too far
off, one is made step by step. Only the lumps that bent laws touch are followed from round to round. Source: waveform
relaxation (Picard iteration on whole courses), Burrage, Parallel and Sequential Methods for ODEs (1995), ch. 7;
unverified.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.channels import Readouts
from network.engine.response.bent_layout import Begun, lay_out
from network.engine.response.bent_rounds import Guess, Rounds
from network.engine.response.linear_run import LinearRun, solve
from network.engine.response.nonlinear_correction import BentCourse
from network.engine.solvers import rosenbrock
from network.engine.solvers.elimination import KnownRegimes, regime_from
from network.engine.solvers.linear import reduce
from network.engine.solvers.modal import Modes
from network.engine.solvers.plan import Plan
from network.platform.refusal import Failed

ROUGHLY = 1e-4
"""Tolerance of the steps that give a guess."""
TIMES = 4
"""How often windows are laid anew before a run is given up."""


def course_of(
    plan: Plan, readouts: Readouts, guess: Guess | None = None, known: dict[bytes, Modes] | None = None,
    regimes: KnownRegimes | None = None,
) -> LinearRun:  # fmt: skip
    """The run of a plan without relays, or whose relay modes are known; `known`, `regimes`: modes and regimes found
    before. Raises Failed where the rounds do not come together."""
    if plan.network.is_affine():
        return solve(reduce(plan, readouts, regimes), known)
    known = {} if known is None else known
    rounds, course = _settle_from(Begun((plan,), (slice(0, len(plan.steps)),)), plan, readouts, guess, known)
    if course is None:
        rounds = Rounds(rounds.begun, plan, readouts, step_through(plan), known, sources_too=True)
        course = rounds.course(TIMES)
    if course is None:
        off = f"still {rounds.change:.2g} K off"
        raise Failed(f"the fixed-point iteration did not converge ({off}): a heat source may run away")
    return course


def course_of_runs(
    plan: Plan, readouts: Readouts, plans: Sequence[Plan], runs: Sequence[slice], guess: Guess | None,
    known: dict[bytes, Modes],
) -> BentCourse | None:  # fmt: skip
    """The course of several runs that follow each other in one plan; None where they do not settle together."""
    return _settle_from(Begun(tuple(plans), tuple(runs)), plan, readouts, guess, known)[1]


def _settle_from(
    begun: Begun, plan: Plan, readouts: Readouts, guess: Guess | None, known: dict[bytes, Modes]
) -> tuple[Rounds, BentCourse | None]:
    """What comes of rounds from a guess, first without sources that read temperatures in the windows."""
    rounds = Rounds(begun, plan, readouts, guess, known, sources_too=False)
    course = rounds.course(1)
    if course is None:
        rounds = Rounds(begun, plan, readouts, guess, known, sources_too=True)
        course = rounds.course(TIMES)
    return rounds, course


def step_through(plan: Plan) -> tuple[Array, Array]:
    """Temperatures at both ends of the intervals from a step by step solution: a guess where none from afar will do.
    Raises Failed where the run does run away."""
    size = plan.network.size
    lumps = Readouts(np.eye(size), {}, (), np.zeros((0, size)), np.zeros((0, 0)), np.zeros(0))
    y = rosenbrock.solve(replace(plan, t=plan.edges), lumps, ROUGHLY).y
    return y[:, :-1].T.copy(), y[:, 1:].T.copy()


def keeps_bends(course: LinearRun) -> bool:
    """Whether the heats of its bent laws are kept, so that sensors can be seen otherwise without another search."""
    return isinstance(course, BentCourse) and course.melts is None


def see_otherwise(course: BentCourse, readouts: Readouts) -> LinearRun:
    """The same temperatures with sensors whose states follow them otherwise; no part melts."""
    problem = course.problem
    regimes = [regime_from(problem.plan.network, regime.K, readouts) for regime in problem.regimes]
    held, heat = problem.forcing.held, np.concatenate(problem.forcing.heat)
    return solve(lay_out(problem.plan, readouts, regimes, problem.regime_of, held, heat))
