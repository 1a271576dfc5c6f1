"""Pushes by what a run is uncertain of besides its numbers: its starts, and the instants of its jumps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.intervals import first_from
from network.engine.response.linear_run import LinearRun, Push, kick


def start_pushes(course: LinearRun, parts: Sequence[str]) -> list[Push]:
    """One kelvin more in a part at the start, for each part."""
    network = course.problem.plan.network
    jumps = np.zeros((len(parts), course.problem.order))
    for jump, name in zip(jumps, parts, strict=True):
        part = network.parts[name]
        first, last = network.free.searchsorted((part.start, part.stop))
        jump[first:last] = 1.0
    return [kick(course, (0, jump)) for jump in jumps]


def edge_pushes(course: LinearRun, instants: Array) -> list[Push]:
    """A jump of the inputs that comes a second later, for each instant."""
    plan = course.problem.plan
    dx0, dx1 = course.rates
    pushes = []
    for t in instants:
        k = int(first_from(plan.edges, t))
        pushes.append(kick(course, (k, dx1[k - 1] - dx0[k])))
    return pushes
