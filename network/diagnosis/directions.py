"""What a candidate would change in the channels, at a strength of engineering size, before anything is refitted.

Where it leaves the parts as they are, the further heat at the temperatures of the run is answered by the network as it
stands: one answer a candidate. Where it brings a part, a lag or a relay, the whole run is computed again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from weakref import WeakKeyDictionary

import numpy as np

from network.balance import heat_balance
from network.calibration.course import Push
from network.calibration.evidence import Measured
from network.calibration.parameters import at_values
from network.calibration.partials import inputs_at_ends
from network.calibration.predictor import Model, Prediction, channels_of
from network.channels import readouts
from network.declare import Array
from network.diagnosis.candidates import Candidate
from network.graph import Network, build
from network.machine import Machine
from network.refusal import Failed

_OWN: WeakKeyDictionary[Prediction, Array] = WeakKeyDictionary()
"""Heat into the lumps along a run, which every candidate is compared with."""


def direction(
    candidate: Candidate, values: Mapping[str, float], data: Sequence[Measured], predictions: Sequence[Prediction]
) -> Array | None:
    """Change of the cells' means of all runs that a candidate brings; None where it cannot be computed.

    values: the numbers at which the predictions were made, and those of the candidate.
    """
    machine = at_values(candidate.machine, {p: v for p, v in values.items() if _has(candidate.machine, p)})
    network = build(machine)
    outputs = readouts(network, parts=False)
    try:
        if all(_is_alike(network, p) and outputs.states == p.course.readouts.states for p in predictions):
            return np.concatenate([_by_heat(machine, network, p) for p in predictions])
        model = Model(machine, (), [d.run for d in data])
        moved = model.predict(np.empty(0))
        return np.concatenate([m.means(m.values) - p.means(p.values) for m, p in zip(moved, predictions, strict=True)])
    except (Failed, np.linalg.LinAlgError, FloatingPointError):
        return None


def _has(machine: Machine, path: str) -> bool:
    return path in machine.uncertain or path.rpartition(".")[0] in dict(machine.entries())


def _is_alike(network: Network, prediction: Prediction) -> bool:
    """Whether lumps, capacities and relays are those of the run."""
    own = prediction.course.problem.plan.network
    same = network.size == own.size and np.allclose(network.capacity, own.capacity, rtol=1e-9)
    return bool(same) and len(network.relays) == len(own.relays) and network.held == own.held


def _by_heat(machine: Machine, network: Network, prediction: Prediction) -> Array:
    course = prediction.course
    own, u = course.problem.plan.network, inputs_at_ends(course.problem.plan)
    T, K = np.concatenate(course.T), len(course.x0)
    modes = course.problem.plan.modes
    on = np.zeros((2 * K, 0)) if modes is None else np.concatenate([modes] * 2)
    if prediction not in _OWN:
        _OWN[prediction] = heat_balance(own, T, u, on).into
    heat = heat_balance(network, T, u, on).into - _OWN[prediction]
    change = np.zeros_like(prediction.values)
    lumps = np.flatnonzero(np.abs(heat).max(axis=0) > 1e-9)
    lumps = lumps[np.isin(lumps, np.concatenate([network.free, network.massless]))]
    if len(lumps):
        answer = course.answers([Push(lumps, heat[:K, lumps], heat[K:, lumps])])
        change = prediction.changes(answer)[0]
    outputs = readouts(network, parts=False)
    rows = np.vstack([outputs.rows @ T.T, course.readings[len(course.readouts.rows) :]])
    seen = channels_of(machine, outputs, rows, prediction.inputs, prediction.run.channels)
    return prediction.means(change + seen - prediction.values)
