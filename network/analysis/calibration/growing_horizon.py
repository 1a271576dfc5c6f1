"""Numbers of a machine with relays from the beginning of its recordings, and then ever more of them.

Over many cycles a model whose relays cycle a little too fast is soon out of step, and no step downhill leads back: J
has as many minima as there are cycles. Over the first few it cannot fall out of step; what is found there is good
enough for twice as long. H. G. Bock, Multiple shooting (1983), meets the same trouble otherwise; unverified.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from network.analysis.calibration.gauss_newton import minimise
from network.analysis.calibration.measured_means import Measured, weigh_recording
from network.analysis.calibration.problem import make_problem
from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.base import Relay
from network.engine.response.parameters import Parameter, at_prior_centres
from network.machine.machine import Machine
from network.platform.refusal import Failed, Refused
from network.platform.stages import Told, say
from network.recordings.inputs import Start

SHARES = (1 / 16, 1 / 8, 1 / 4, 1 / 2)
"""Of the recordings, each twice the one before."""
STEPS = 8
"""Of a fit on the way: the next begins where it ends."""


def begin_in_step(
    machine: Machine, parameters: Sequence[Parameter], data: Sequence[Measured], start: Start | None,
    is_late: Callable[[], bool], tell: Told = lambda share: None,
) -> Array | None:  # fmt: skip
    """θ from which relays stay in step over whole recordings; None for a machine without relays."""
    if not parameters or not any(isinstance(source, Relay) for source in machine.sources.values()):
        return None
    known, theta = at_prior_centres(machine, parameters), None
    for share in SHARES:
        if is_late():
            break
        say(tell, f"what switches falls into step: the first {100 * share:.2g} % of the recordings")
        try:
            some = [weigh_recording(known, d.recording.until(share), start) for d in data]
            theta = minimise(replace(make_problem(machine, parameters, some), offsets=()), theta, STEPS).theta
        except (Failed, Refused):
            continue
    return theta
