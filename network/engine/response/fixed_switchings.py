"""Slopes of runs with relays by numbers that act otherwise than by heat: differences of runs that switch together.

dy/dθ = ∂y/∂θ at fixed switchings + Σ ∂y/∂t_e dt_e/dθ. The first is a difference of two linear runs on the same
intervals, which needs no search for crossings and is smooth however far a switching moves; the second follows from what
the guards see otherwise at the crossings, in closed form (`switchings`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.channels import Readouts
from network.engine.network import Network
from network.engine.response.linear_run import kick, solve
from network.engine.response.prediction import Prediction
from network.engine.response.run_plan import start_of
from network.engine.response.switchings import SwitchedCourse
from network.engine.solvers.elimination import KnownRegimes
from network.engine.solvers.linear import reduce
from network.engine.solvers.modal import Modes
from network.engine.solvers.plan import list_own_edges
from network.machine.machine import Machine


def runs_alike(network: Network, prediction: Prediction) -> bool:
    """Whether a run of another network has the lumps and, by its laws, the instants of a prediction with relays."""
    if not isinstance(prediction.course, SwitchedCourse):
        return False
    own, end = prediction.course.problem.plan.network, float(prediction.run.schedule.t[-1])
    edges, others = (np.concatenate([*list_own_edges(n, end), np.empty(0)]) for n in (own, network))
    same = own.size == network.size and own.parts == network.parts and own.held.keys() == network.held.keys()
    return same and np.array_equal(edges, others)


def differ_at_switchings(
    machine: Machine, network: Network, outputs: Readouts, at: Prediction, step: float, cells: bool,
    known: dict[bytes, Modes], regimes: KnownRegimes,
) -> Array:  # fmt: skip
    """∂(channels)/∂θ (channels, 2 K), or of their cells' means (·,), from the network at θ + step."""
    course = at.course
    assert isinstance(course, SwitchedCourse)
    other = _rerun(network, outputs, course, at.begun, known, regimes)
    moved = Prediction(at.run, machine, other, at.resampled)
    push, by_guard = [kick(course)], (other.guards - course.guards)[None] / step
    if cells:
        return np.asarray((moved.cells - at.cells) / step + at.respond_to(push, by_guard)[0])
    answers = course.ends(course.complete_pushes(push, by_guard), course.output_map)
    return np.asarray((moved.values - at.values) / step + at.changes(answers)[0])


def _rerun(
    network: Network, outputs: Readouts, at: SwitchedCourse, start: Mapping[str, float], known: dict[bytes, Modes],
    regimes: KnownRegimes,
) -> SwitchedCourse:  # fmt: skip
    """The run of another network whose relays switch when they did."""
    plan = at.problem.plan
    moved = solve(reduce(plan.with_network(network, start_of(network, start, plan.left)), outputs, regimes), known)
    return SwitchedCourse(moved.problem, moved.modes, moved.x0, moved.x1, at.events)
