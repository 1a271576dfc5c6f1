"""Where each recording began, as a calibrated machine would have it: parts without a sensor start anywhere near."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from network.calibration.evidence import measured
from network.calibration.fitting import linearise, make_problem
from network.calibration.noise import Noise
from network.calibration.parameters import Parameter
from network.comparison import Comparison, compare
from network.declare import Array
from network.inputs import Start
from network.machine import Machine
from network.recording import Recording

ROUNDS, CLOSE = 4, 1.0
"""How often a run is linearised about its start, and the least that another time must better the cost J."""


def beginning(
    machine: Machine, parameters: Sequence[Parameter], theta: Array, recording: Recording, start: Start | None,
    misfit: float,
) -> Start:  # fmt: skip
    """The most probable temperatures of the parts at the start of a recording, the numbers being known; the further the
    run is off otherwise, the less they move."""
    data, best = measured(machine, recording, start), np.inf
    found = {n.name: data.run.start[n.name] for n in data.starts}
    for _ in range(ROUNDS):
        problem = make_problem(machine, parameters, [data.started(found)], Noise())
        fit = linearise(replace(problem, offsets=(), firm_eta=misfit), theta)
        if fit.cost > best - CLOSE:
            break
        best, before = fit.cost, found
        moved = fit.eta[: len(data.starts)]
        found = {n.name: before[n.name] + float(x) for n, x in zip(data.starts, moved, strict=True)}
    return Start(nodes=found)


def begun(
    machine: Machine, original: Machine, parameters: Sequence[Parameter], theta: Array,
    recordings: Sequence[Recording], start: Start | None, misfit: float,
) -> Comparison | None:  # fmt: skip
    """Residuals of a calibrated machine with estimated starts; None without recordings."""
    if not recordings:
        return None
    starts = [beginning(original, parameters, theta, r, start, misfit) for r in recordings]
    each = [compare(machine, r, start=s).recordings[0] for r, s in zip(recordings, starts, strict=True)]
    return Comparison(machine, tuple(each))
