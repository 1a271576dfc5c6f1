"""Pushes by what a run is uncertain of besides its numbers: its starts, and the instants of its jumps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.intervals import first_from
from network.engine.response.linear_run import LinearRun, Push, kick


def start_pushes(course: LinearRun, parts: Sequence[str]) -> list[Push]:
    """One kelvin more in a part at the start, for each part; sensors have settled at it."""
    problem, network = course.problem, course.problem.plan.network
    still, pushes = problem.begin(np.zeros(network.size)), []
    for name in parts:
        warm = np.zeros(network.size)
        warm[network.parts[name]] = 1.0
        pushes.append(kick(course, (0, problem.begin(warm) - still)))
    return pushes


def edge_pushes(course: LinearRun, instants: Array) -> list[Push]:
    """A jump of the inputs that comes a second later, for each instant."""
    plan = course.problem.plan
    dx0, dx1 = course.rates
    pushes = []
    for t in instants:
        k = int(first_from(plan.edges, t))
        pushes.append(kick(course, (k, dx1[k - 1] - dx0[k])))
    return pushes
