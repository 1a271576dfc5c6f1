"""Slopes by numbers that act otherwise than by heat: differences of runs, as few as they take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.channels import Readouts, readouts
from network.engine.network import Network
from network.engine.response.fixed_switchings import differ_at_switchings, runs_alike
from network.engine.response.nonlinear_correction import BentCourse
from network.engine.response.parameters import Parameter
from network.engine.response.prediction import Prediction
from network.engine.response.seen_differences import differ_as_seen, is_seen_only
from network.engine.response.waveform import keeps_bends, see_otherwise
from network.engine.solvers.elimination import KnownRegimes
from network.engine.solvers.modal import Modes
from network.machine.machine import Machine

DIFFERENCE = 1e-4
"""Step in θ for parameters that act otherwise than by heat."""


class Moved(Protocol):
    """A machine with free parameters on some runs, at any values of these."""

    parameters: tuple[Parameter, ...]
    machine: Machine

    def at(self, theta: Array) -> tuple[Machine, Network]:
        """Machine and network at θ."""

    def run_from(
        self, machine: Machine, network: Network, starts: Sequence[Mapping[str, float]],
        beside: Sequence[Prediction] | None = None,
    ) -> tuple[Prediction, ...]:  # fmt: skip
        """All runs of these from starts."""


def differ_otherwise(
    model: Moved, theta: Array, j: int, predictions: Sequence[Prediction], cells: bool
) -> list[Array]:  # fmt: skip
    """∂(channels)/∂θ_j by a difference of whole runs; means over cells are the same cells where relays switch at
    other times, values at the edges are not."""
    p, there = model.parameters[j], theta.copy()
    step = _find_step(p, float(theta[j]))
    there[j] += step
    if is_seen_only(model.machine, p.entry):
        return differ_as_seen(p.entry, {p.path: p.value(float(there[j]))}, step, predictions, cells)
    machine, network = model.at(there)
    if p.entry.section == "sensors" and all(keeps_bends(q.course) for q in predictions):
        outputs = readouts(network, parts=False)
        return [_differ_in_states(machine, outputs, q, step, cells) for q in predictions]
    if all(runs_alike(network, q) for q in predictions):
        outputs, known, regimes = readouts(network, parts=False), dict[bytes, Modes](), KnownRegimes()
        return [differ_at_switchings(machine, network, outputs, q, step, cells, known, regimes)
                for q in predictions]  # fmt: skip
    moved = model.run_from(machine, network, [q.begun for q in predictions], predictions)
    if cells:
        return [(m.cells - q.cells) / step for m, q in zip(moved, predictions, strict=True)]
    return [(_onto(m, q) - q.values) / step for m, q in zip(moved, predictions, strict=True)]


def _find_step(p: Parameter, at: float) -> float:
    step = DIFFERENCE if at + DIFFERENCE <= p.high else -DIFFERENCE
    if p.is_log:
        return step
    return step * (max(p.spread, 1e-9) if np.isfinite(p.spread) else 1.0)


def _differ_in_states(machine: Machine, outputs: Readouts, at: Prediction, step: float, cells: bool) -> Array:
    """The same where only states of sensors follow the temperatures of a run otherwise."""
    assert isinstance(at.course, BentCourse)
    moved = Prediction(at.run, machine, see_otherwise(at.course, outputs), at.resampled)
    return np.asarray((moved.cells - at.cells if cells else moved.values - at.values) / step)


def _onto(moved: Prediction, at: Prediction) -> Array:
    """Values of one prediction at the edges of another (they differ where relays switch)."""
    there, here = moved.course.problem.plan.edges, at.course.problem.plan.edges
    if len(there) == len(here):
        return moved.values
    K, L = len(there) - 1, len(here) - 1
    k = np.clip(np.searchsorted(there, (here[1:] + here[:-1]) / 2) - 1, 0, K - 1)
    left, right = ((x - there[k]) / (there[k + 1] - there[k]) for x in (here[:-1], here[1:]))
    v0, v1 = moved.values[:, :K], moved.values[:, K:]
    out = np.empty((len(v0), 2 * L))
    out[:, :L] = v0[:, k] + left * (v1 - v0)[:, k]
    out[:, L:] = v0[:, k] + right * (v1 - v0)[:, k]
    return out
