"""Numbers of a machine with relays from the beginning of its recordings, and then ever more of them.

Over many cycles a model whose relays cycle a little too fast is soon out of step, and no step downhill leads back: J
has as many minima as there are cycles. Over the first few it cannot fall out of step; what is found there is good
enough for somewhat longer. How much longer is told by the misfit: where it leaps the fit has slipped a cycle, and less
is added to where it had not. Continuation with a step that follows what happened: Allgower & Georg, Numerical
Continuation Methods (1990), ch. 6; unverified.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from network.analysis.calibration.gauss_newton import minimise
from network.analysis.calibration.linearised import Linearised
from network.analysis.calibration.measured_means import Measured, weigh_recording
from network.analysis.calibration.misfit import chi_of
from network.analysis.calibration.problem import make_problem
from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.base import Relay
from network.engine.response.parameters import Parameter, at_prior_centres
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused
from network.platform.stages import Told, say
from network.recordings.inputs import Start

FIRST, GROWTH, LEAST_GROWTH = 1 / 16, 2.0, 1.15
"""Share of the recordings that is fitted first, by how much the next is longer, and at least."""
LEAP = 1.25
"""Ratio of misfits χ from one share to the next from which a cycle was slipped: one that slips leaves its whole swing,
many times the noise, in all that follows."""
STEPS = 8
"""Of a fit on the way: the next begins where it ends."""


def has_relays(machine: Machine) -> bool:
    """Whether something in it switches."""
    return any(isinstance(entry, Relay) for entry in machine.by_path.values())


def begin_in_step(
    machine: Machine, parameters: Sequence[Parameter], data: Sequence[Measured], start: Start | None,
    is_late: Callable[[], bool], tell: Told = lambda share: None,
) -> Array | None:  # fmt: skip
    """θ from which relays stay in step over whole recordings; None for a machine without relays, or where it always
    breaks down."""
    if not parameters or not has_relays(machine):
        return None
    known, theta = at_prior_centres(machine, parameters), None
    done, left, growth = 0.0, 1.0, GROWTH
    while done < 1 and not is_late():
        share = min(max(done * growth, FIRST), 1.0)
        say(tell, f"what switches falls into step: the first {100 * share:.2g} % of the recordings")
        some = [weigh_recording(known, d.recording.until(share), start) for d in data]
        at = _fit_beginning(machine, parameters, some, theta)
        if done and growth > LEAST_GROWTH and (at is None or chi_of(at) > LEAP * max(left, 1.0)):
            growth = float(np.sqrt(growth))
            continue
        if at is not None:
            theta, left = at.theta, chi_of(at)
        done, growth = share, min(GROWTH, growth**1.5)
    return theta


def _fit_beginning(
    machine: Machine, parameters: Sequence[Parameter], data: Sequence[Measured], theta: Array | None
) -> Linearised | None:
    """A few steps from there; None where it breaks down."""
    try:
        return minimise(replace(make_problem(machine, parameters, data), offsets=()), theta, STEPS)
    except (Failed, Refused):
        return None
