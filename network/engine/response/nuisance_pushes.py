"""Pushes by what a run is uncertain of besides its numbers: its starts, and the instants of its jumps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.intervals import first_from
from network.engine.response.linear_run import LinearRun, Push, kick


def start_pushes(course: LinearRun, parts: Sequence[str]) -> list[Push]:
    """One kelvin more in a part at the start, for each part; what sensors make of it has settled at it, too."""
    network = course.problem.plan.network
    jumps = np.zeros((len(parts), course.problem.order))
    for jump, name in zip(jumps, parts, strict=True):
        part = network.parts[name]
        first, last = network.free.searchsorted((part.start, part.stop))
        jump[first:last] = 1.0
    _settle_sensors(course, jumps)
    return [kick(course, (0, jump)) for jump in jumps]


def _settle_sensors(course: LinearRun, jumps: Array) -> None:
    """States of sensors settle at other temperatures of the lumps: what they begin with moves by as much."""
    problem, sensors = course.problem, course.readouts
    if not sensors.states:
        return
    network, n = problem.plan.network, problem.order - sensors.states
    lumps = jumps[:, :n]
    moved = lumps @ sensors.state_T[:, network.free].T
    if len(network.massless):
        junctions = lumps @ problem.regimes[problem.regime_of[0]].P[network.massless, :n].T
        moved += junctions @ sensors.state_T[:, network.massless].T
    jumps[:, n:] = np.linalg.solve(sensors.state_z, -moved.T).T


def edge_pushes(course: LinearRun, instants: Array) -> list[Push]:
    """A jump of the inputs that comes a second later, for each instant."""
    plan = course.problem.plan
    dx0, dx1 = course.rates
    pushes = []
    for t in instants:
        k = int(first_from(plan.edges, t))
        pushes.append(kick(course, (k, dx1[k - 1] - dx0[k])))
    return pushes
