"""Numbers of a machine whose relays recordings tell: found beside the modes that were read, where nothing can fall out
of step, they are near those at which the relays keep step by themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from network.analysis.calibration.gauss_newton import minimise
from network.analysis.calibration.growing_horizon import InStep, know_left_over, lay_out_share
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.recorded_modes import read_modes
from network.engine.response.parameters import Parameter, centres
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused
from network.recordings.inputs import Start


def begin_beside_modes(
    machine: Machine, parameters: Sequence[Parameter], data: Sequence[Measured], start: Start | None,
    is_late: Callable[[], bool] = lambda: False,
) -> InStep | None:  # fmt: skip
    """The most probable numbers beside the modes that recordings tell, and the misfit there over any share of them;
    once it is late, what was come to. None for a machine without relays, where a recording does not tell the modes of
    each, or that breaks down."""
    recordings = read_modes(machine, [d.recording for d in data])
    if not (parameters and recordings[0].modes):
        return None
    try:
        problem = lay_out_share(machine, parameters, recordings, start, 1.0)
        at = minimise(problem, centres(parameters), until=lambda at: is_late())
    except (Failed, Refused, np.linalg.LinAlgError):
        return None
    there = InStep.of(at)
    return replace(there, left_over=know_left_over(machine, parameters, recordings, start, there))
