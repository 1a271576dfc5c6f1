"""A plan carried out: the solver it names, and one form for what any of them gives."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.balance import MOST_LUMPS
from network.engine.channels import Readouts, readouts
from network.engine.energy import EnergyAccount, heat_over_time, linear_account
from network.engine.network import Network
from network.engine.solvers import expm, modal_run, switched
from network.engine.solvers.courses import Courses, KnownCourses
from network.engine.solvers.linear import LinearProblem, LinearSolution, reduce
from network.engine.solvers.method_choice import make_plan, why_not_krylov
from network.engine.solvers.plan import Plan
from network.platform.refusal import Failed
from network.recordings.inputs import Schedule

if TYPE_CHECKING:
    from network.engine.solvers.reference import ReferenceSolution
    from network.engine.solvers.step_courses import RosenbrockSolution

ROSENBROCK_TOLERANCE, REFERENCE_TOLERANCE = 1e-7, 1e-8
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Outcome:
    """What a solver gave: base readings and sensor states over time, heat of lumps over time where asked for."""

    plan: Plan
    readouts: Readouts
    courses: Courses
    T_start: Array
    T_end: Array
    account: EnergyAccount
    error: float
    heat: Array | None
    problem: LinearProblem | None = None
    switches: tuple[tuple[float, str, bool], ...] = ()

    @cached_property
    def limits(self) -> tuple[Array, Array]:
        """What no row is below and above."""
        return self.courses.limits()


def solve_schedule(
    network: Network, schedule: Schedule, T0: Array, method: str = "auto", parts: bool = True,
    rtol: float | None = None, progress: Progress | None = None, outputs: Readouts | None = None,
) -> Outcome:  # fmt: skip
    """Plans and solves; from the temperatures of all lumps at the start to base readings (`outputs`, if not those of
    the machine) and the energy account."""
    wants_heat = any(r.how == "heat" for e in network.machine.expansions.values() for r in e.readings())
    plan = make_plan(network, schedule, T0, method, stop_at_samples=wants_heat)
    outputs = outputs or readouts(network, parts)
    if plan.method == "rosenbrock" or plan.method.startswith("solve_ivp"):
        return _by_steps(plan, outputs, rtol, progress, wants_heat)
    switches: tuple[tuple[float, int, int], ...] = ()
    if plan.method == "switched":
        found = switched.find(plan, outputs, progress)
        if found is None:
            why = "it switches, and its modes are too much alike for the closed form"
            return _by_steps(replace(plan, method="rosenbrock", why=why), outputs, rtol, progress, wants_heat)
        plan, switches = found.plan, found.switches
    if plan.method == "krylov":
        reduced = _by_krylov(plan, outputs)
        if reduced is not None:
            return reduced
        plan = replace(plan, method="modal", why="linear: exact in its modes, for a subspace leaves out too much")
    problem = reduce(plan, outputs)
    solution = modal_run.solve(problem, each_interval=wants_heat) if plan.method != "expm" else None
    if solution is None:
        if plan.method == "modal":
            plan = replace(plan, method="expm", why="linear, but its modes are too much alike: matrix exponentials")
        solution = expm.solve(problem, each_interval=wants_heat)
    return replace(_by_linear(plan, problem, solution, wants_heat), switches=_name_switches(network, switches))


def _by_krylov(plan: Plan, outputs: Readouts) -> Outcome | None:
    """None where the subspace leaves out too much. Raises Failed where there is no other way either."""
    from network.engine.solvers.krylov import reduce_by_krylov  # slow to load, for scipy's sake

    reduction = None if why_not_krylov(plan.network) else reduce_by_krylov(plan, outputs)
    solution = modal_run.solve(reduction.problem) if reduction is not None else None
    if reduction is None or solution is None:
        if plan.network.size > MOST_LUMPS:
            right = "take fewer lumps"
            many = f"{plan.network.size} lumps follow no small subspace"
            raise Failed(f"{many}, and are too many for their modes; {right}")
        return None
    return replace(_by_linear(plan, reduction.problem, solution, False), error=max(solution.error, reduction.error))


def _by_linear(plan: Plan, problem: LinearProblem, solution: LinearSolution, wants_heat: bool) -> Outcome:
    T0, T1 = problem.temperatures(problem.x0, 0), problem.temperatures(solution.x_end, -1)
    heat = None
    if wants_heat:
        at = np.searchsorted(plan.edges, plan.t - 1e-9)
        heat = heat_over_time(problem, solution)[at]
    account = linear_account(problem, solution)
    return Outcome(plan, problem.readouts, solution.courses, T0, T1, account, solution.error, heat, problem)


def _by_steps(
    plan: Plan, outputs: Readouts, rtol: float | None, progress: Progress | None, wants_heat: bool
) -> Outcome:  # fmt: skip
    """By RODAS or solve_ivp, with the energy account summed over their steps."""
    from network.engine.solvers import reference, rosenbrock  # slow to load, for scipy's sake

    solution: RosenbrockSolution | ReferenceSolution
    if plan.method == "rosenbrock":
        rtol = rtol or ROSENBROCK_TOLERANCE
        solution = rosenbrock.solve(plan, outputs, rtol, progress)
    else:
        rtol = rtol or REFERENCE_TOLERANCE
        solution = reference.solve(plan, outputs, plan.method.partition(":")[2], rtol, rtol, progress)
    switches = _name_switches(plan.network, solution.switches)
    account, T0, T1 = solution.account, solution.T_start, solution.T_end
    error = _error_from(account, plan.network, rtol, T1)
    heat = solution.heat if wants_heat or plan.network.melting else None
    return Outcome(plan, outputs, KnownCourses(solution.y), T0, T1, account, error, heat, switches=switches)


def _error_from(account: EnergyAccount, network: Network, rtol: float, T_end: Array) -> float:
    """What the account's gap would warm the machine by, or what the tolerance allows: the larger [K]."""
    gap = abs(account.closure) * max(account.in_, account.out, 1.0)
    allowed = rtol * float(np.abs(T_end[np.isfinite(network.capacity)]).max())
    return max(gap / float(network.capacity[network.free].sum()), allowed)


def _name_switches(network: Network, switches: Iterable[tuple[float, int, int]]) -> tuple[tuple[float, str, bool], ...]:
    """Switchings with the names of what switches."""
    names = [network.mechanisms[i] for relays in network.relays for i in relays.entry]
    return tuple((t, names[j].partition(".")[2], bool(mode)) for t, j, mode in switches)
