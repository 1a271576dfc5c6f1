"""What channels of a run would show had its inputs stood at zero, within each of the steps that it is cut into.

About the temperatures of the run the heat that then would not flow acts by superposition: what a stretch of steps
changes is the sum of what its steps change.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from network.analysis.diagnosis.standstill.driver import Driver
from network.catalogue.declaration.declare import Array, Indices, Mask
from network.engine.assembly import build
from network.engine.balance import heat_into
from network.engine.response.linear_run import Push
from network.engine.response.output_jacobian import channels_of
from network.engine.response.prediction import Prediction
from network.machine.machine import Machine

MOST = 300
"""Steps of a run (budget)."""
NOTHING = 1e-9
"""W, or SI unit of a channel, below which nothing changes."""


@dataclass(frozen=True, eq=False)
class Absence:
    """edges: of the steps [s], one more than they are; moves: in which of them there is something to stop; changes: of
    the cells' means until each edge, had the inputs stood from the first on (edges, channels · cells)."""

    edges: Array
    moves: Mask
    changes: Array


def find_absence(prediction: Prediction, driver: Driver) -> Absence | None:
    """None where they stand all the time."""
    machine = driver.put_in(prediction.machine)
    heat, seen = _change_heat(prediction, machine, driver), _change_readings(prediction, machine, driver)
    K = len(heat) // 2
    moves = np.maximum(np.abs(heat).max(axis=1), np.abs(seen).max(axis=0)).reshape(2, K).max(axis=0) > NOTHING
    if not moves.any():
        return None
    cuts = np.unique(np.linspace(0, K, min(K, MOST) + 1).astype(int))
    within = np.array([(np.arange(K) >= a) & (np.arange(K) < b) for a, b in pairwise(cuts)])
    lumps = np.flatnonzero(np.abs(heat).max(axis=0) > NOTHING)
    steps = prediction.respond_to([_push(heat, lumps, own) for own in within])
    steps = steps + prediction.means(seen * np.tile(within, 2)[:, None])
    changes = np.vstack([np.zeros(steps.shape[1]), np.cumsum(steps, axis=0)])
    return Absence(prediction.course.problem.plan.edges[cuts], (within & moves).any(axis=1), changes)


def _push(heat: Array, lumps: Indices, within: Mask) -> Push:
    K = len(within)
    return Push(lumps, heat[:K, lumps] * within[:, None], heat[K:, lumps] * within[:, None])


def _change_heat(prediction: Prediction, machine: Machine, driver: Driver) -> Array:
    """Heat into the lumps with the inputs at zero less that as it is, at both ends of the intervals (2 K, N)."""
    course = prediction.course
    plan, T, (before, after) = course.problem.plan, course.T_ends, _inputs(course.inputs, driver)
    network = plan.network if machine is prediction.machine else build(machine)
    modes = np.concatenate([plan.modes] * 2) if plan.modes is not None else np.zeros((len(T), 0))
    change = heat_into(network, T, after, modes) - heat_into(network, T, before, modes)
    return np.where(np.isinf(network.capacity), 0.0, change)


def _change_readings(prediction: Prediction, machine: Machine, driver: Driver) -> Array:
    """The same of the channels at the same temperatures (channels, 2 K)."""
    course, names = prediction.course, prediction.run.channels
    flat = [{name: u[:, 0] for name, u in inputs.items()} for inputs in _inputs(course.inputs, driver)]
    before, after = (channels_of(machine, course.readouts, course.readings, u, names) for u in flat)
    return np.asarray(after - before)


def _inputs(inputs: Mapping[str, Array], driver: Driver) -> tuple[Mapping[str, Array], Mapping[str, Array]]:
    """As they are, what says when a source is on among them; and with those at zero that stand."""
    before = {**{name: np.ones_like(inputs["time"]) for name in driver.inputs}, **inputs}
    return before, {**before, **{name: np.zeros_like(before[name]) for name in driver.inputs}}
