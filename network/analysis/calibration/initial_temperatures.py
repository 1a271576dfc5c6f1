"""Where each recording began, as a calibrated machine would have it: parts without a sensor start anywhere near."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from network.analysis.calibration.gauss_newton import Problem, linearise, make_problem
from network.analysis.calibration.measured_means import START_ANYWHERE, Measured, weigh_recording
from network.analysis.calibration.noise import Noise
from network.analysis.comparison.compare import Comparison, RecordingResidual, compare
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import Parameter, at_values, values_at
from network.machine.machine import Machine
from network.platform.refusal import Failed
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.runs import runs_of

ROUNDS, CLOSE = 4, 1.0
"""How often a run is linearised about its start, and the least that another time must better the cost J."""
TRIED = (0.0, -0.7, 0.7)
"""K by which parts that may start anywhere are moved before."""


def beginning(
    machine: Machine, parameters: Sequence[Parameter], theta: Array, recording: Recording, start: Start | None,
    misfit: float,
) -> Start:  # fmt: skip
    """The most probable temperatures of the parts at the start of a recording, the numbers being known; the further the
    run is off otherwise, the less they move."""
    data = weigh_recording(machine, recording, start)
    problem = partial(_about, at_values(machine, values_at(parameters, theta)), data, misfit)
    anywhere = [n.name for n in data.starts if n.spread >= START_ANYWHERE]
    shifts = TRIED if anywhere else (0.0,)
    found = [_settle_start(problem, {n: data.run.start[n] + x for n in anywhere}) for x in shifts]
    return Start(nodes=min(found, key=lambda pair: pair[0])[1])


def _about(machine: Machine, data: Measured, misfit: float, start: Mapping[str, float]) -> Problem:
    """The run about other temperatures at its start."""
    problem = make_problem(machine, (), [data.with_start(start)], Noise())
    return replace(problem, offsets=(), firm_eta=misfit)


def _settle_start(
    problem: Callable[[Mapping[str, float]], Problem], start: Mapping[str, float]
) -> tuple[float, dict[str, float]]:
    """The cost J, and the start at which a run linearised about it stays."""
    best, settled = np.inf, dict(start)
    for _ in range(ROUNDS):
        try:
            fit = linearise(problem(start), np.empty(0))
        except Failed:
            break
        data = fit.problem.data[0]
        if fit.cost > best - CLOSE:
            break
        best, settled = fit.cost, data.move_start(fit.eta[: len(data.starts)])
        start = settled
    return best, settled


def compare_from_start(
    machine: Machine, original: Machine, parameters: Sequence[Parameter], theta: Array, recording: Recording,
    start: Start | None, misfit: float,
) -> RecordingResidual:  # fmt: skip
    """Residuals of one recording of a calibrated machine with its start estimated."""
    found = beginning(original, parameters, theta, recording, start, misfit)
    return compare(machine, recording, start=found).recordings[0]


def compare_all_from_start(
    machine: Machine, original: Machine, parameters: Sequence[Parameter], theta: Array,
    recordings: Sequence[Recording], start: Start | None, misfit: float,
) -> Comparison | None:  # fmt: skip
    """The same of several; None without recordings."""
    each = [compare_from_start(machine, original, parameters, theta, r, start, misfit) for r in recordings]
    return Comparison(machine, tuple(each)) if each else None


def estimate_start(machine: Machine, recordings: Sequence[Recording]) -> Comparison:
    """Residuals of recordings of a machine as it is, the start of each estimated from it."""
    each = (compare_from_start(machine, machine, (), np.empty(0), r, None, 1.0) for r in runs_of(machine, recordings))
    return Comparison(machine, tuple(each))
