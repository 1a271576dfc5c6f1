"""When nothing within reach fits: whether one number or one channel was given in a wrong unit.

A number a power of ten off lies far beyond its own prior, so a fit can only bend all others. Each number is tried at
powers of ten; each channel is compared with its simulation for a factor, and for kelvin read as degrees.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import takewhile

import numpy as np

from network.analysis.calibration.gauss_newton import Linearised, linearise, make_problem, residual_cost
from network.analysis.calibration.linearised import move_beside
from network.analysis.calibration.measured_means import Measured
from network.analysis.calibration.multistart import rms
from network.analysis.comparison.channel_residual import ChannelResidual
from network.engine.response.parameters import centres
from network.engine.response.prediction import Prediction
from network.platform.quantities.units import show
from network.platform.refusal import Failed, Refusal, Spot

HOPELESS, HARDLY = 20.0, 3.0
"""rms of a fit from which a wrong unit is looked for, and times that the fit lowered it at most."""
BETTER = 4.0
"""How many times a wrong unit has to lower what is left."""
POWERS = (3, 1, 2, 6, 4)
"""Of ten, either way; thousands are tried in any case."""
ALIKE, FEWEST = 0.95, 2
"""Correlation of the movements measured and simulated from which a factor means anything, and means of a channel that
always lie along each other."""
ZERO_CELSIUS, NEAR_ZERO = 273.15, 40.0


def misread(at: Linearised, is_late: Callable[[], bool] = lambda: False) -> Iterator[Refusal]:
    """What may be in a wrong unit, given the best fit; once it is late, only thousands are tried."""
    if rms(at.left) < HOPELESS:
        return
    written = move_beside(at, centres(at.problem.parameters))
    if written is None:
        return
    found = [*_channels(written)]
    yield from found or (_numbers(at, is_late) if at.cost > written.cost / HARDLY**2 else ())


def _numbers(at: Linearised, is_late: Callable[[], bool] = lambda: False) -> Iterator[Refusal]:
    """The number that explains most of what no fit can, if it were a power of ten off: by thousands, for so units
    differ most often, and by others where there is time."""
    problem, enough = at.problem, at.cost / BETTER**2
    shortest = _lay_out_shortest(at)
    numbers = [j for j, p in enumerate(problem.parameters) if not p.is_unknown]
    powers = takewhile(lambda k: k == POWERS[0] or not is_late(), POWERS)
    tried = ((j, 10.0**power) for k in powers for power in (k, -k) for j in numbers)
    able = (each for each in tried if shortest is None or residual_of(shortest, *each) <= enough)
    costs = [(residual_of(at, j, factor), problem.parameters[j], factor) for j, factor in able]
    best, p, factor = min(costs, key=lambda item: item[0], default=(np.inf, None, 1.0))
    if p is None or best > enough:
        return
    there, readings = show(factor * p.value(p.centre), p.field.unit), max(len(at.left), 1)
    met = f"to {np.sqrt(best / readings):.3g} σ instead of {rms(at.left):.3g} σ"
    wrong = f"{p.path} is {p.format_value(p.centre)}, and with {there} the recordings would be met {met}"
    yield Refusal(Spot(problem.model.machine.file), wrong, "check its unit")


def _lay_out_shortest(at: Linearised) -> Linearised | None:
    """The problem on the run with the fewest readings, at the same numbers: its misfit is a part of that of all, so
    that what leaves too much there need not be tried on all. None where there is no other run, that one breaks down
    alone, or relays may take it otherwise alone."""
    problem = at.problem
    if len(problem.data) < 2 or problem.model.switches:
        return None
    i = min(range(len(problem.data)), key=lambda i: len(problem.data[i].means))
    alone = make_problem(problem.model.machine, problem.parameters, [problem.data[i]])
    try:
        return linearise(replace(alone, offsets=(), whiteners=(problem.whiteners[i],)), at.theta)
    except Failed:
        return None


def residual_of(at: Linearised, j: int, factor: float) -> float:
    """J at the priors' centres with one number off by a factor, that number's prior aside."""
    p, theta = at.problem.parameters[j], centres(at.problem.parameters)
    value = factor * p.value(p.centre)
    if not p.field.low <= value <= p.field.high or not value:
        return float("inf")
    theta[j] = np.log(value) if p.is_log else value
    return residual_cost(at, theta) - float(((theta[j] - p.centre) / p.spread) ** 2)


def _channels(written: Linearised) -> Iterator[Refusal]:
    """Channels that are off by themselves at the numbers of the file: in kelvin, or by a factor that others do not
    share."""
    units = {name: sensor.unit for name, sensor in written.problem.model.machine.sensors.items()}
    for data, prediction in zip(written.problem.data, written.predictions, strict=True):
        channels = {c.name: c for c in _lay_beside(data, prediction, units)}
        factors = {name: power_of(channel) for name, channel in channels.items() if channel.n > FEWEST}
        for name, power in factors.items():
            wrong = _in_kelvin(channels[name])
            ordinary = any(other is not None and abs(other) < 1 for n, other in factors.items() if n != name)
            if power is not None and abs(power) >= 2 and ordinary and channels[name].unit != "degC":
                wrong = f"{name} reads 1e{power} times what is simulated, in the same shape"
            if wrong:
                yield Refusal(Spot(data.recording.file), wrong, "check the unit in its header")


def _lay_beside(data: Measured, prediction: Prediction, units: Mapping[str, str]) -> Iterator[ChannelResidual]:
    """The cells' means of every channel beside those that are simulated; units: of the sensors."""
    count, measured = data.run.knots.cells, np.where(data.known, data.means, np.nan)
    for i, name in enumerate(data.run.channels):
        own = slice(i * count, (i + 1) * count)
        yield ChannelResidual(name, units[name], data.centres, measured[own], prediction.cells[own], data.sigma[name])


def _in_kelvin(channel: ChannelResidual) -> str:
    shift = float(np.nanmedian(channel.residual))
    if channel.unit != "degC" or abs(abs(shift) - ZERO_CELSIUS) > NEAR_ZERO:
        return ""
    return f"{channel.name} reads {shift:+.0f} K beside the simulation, as kelvin and degrees Celsius do"


def power_of(channel: ChannelResidual) -> int | None:
    """The power of ten by which a channel moves more than simulated; None where it moves otherwise."""
    good = channel.finite
    m, s = (v[good] - v[good][0] for v in (channel.measured, channel.simulated))
    if not s.any() or not m.any():
        return None
    like = float(m @ s) / np.sqrt(float(m @ m) * float(s @ s))
    return round(float(np.log10(abs(m @ s) / (s @ s)))) if abs(like) > ALIKE else None
