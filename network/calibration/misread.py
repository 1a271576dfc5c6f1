"""When nothing within reach fits: whether one number or one channel was given in a wrong unit.

A number a power of ten off lies far beyond its own prior, so a fit can only bend all others. Each number is tried at
powers of ten; each channel is compared with its simulation for a factor, and for kelvin read as degrees.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from network.calibration.fitting import Linearised, linearise
from network.calibration.parameters import Parameter, centres
from network.calibration.starting import rms
from network.comparison import ChannelResidual, Comparison
from network.refusal import Failed, Refusal, Spot
from network.units import show

HOPELESS = 20.0
"""rms of a fit from which a wrong unit is looked for."""
BETTER = 4.0
"""How many times a wrong unit has to lower what is left."""
POWERS = (1, 2, 3, 4, 6)
STRAIGHT = 0.95
ZERO_CELSIUS = 273.15


def misread(at: Linearised, before: Comparison) -> Iterator[Refusal]:
    """What may be in a wrong unit, given the best fit and the machine as written."""
    if rms(at.left) < HOPELESS:
        return
    found = [*_channels(before)]
    yield from found or _numbers(at)


def _numbers(at: Linearised) -> Iterator[Refusal]:
    """The number that explains most of what no fit can, if it were a power of ten off."""
    problem = at.problem
    file = problem.model.machine.file
    tried = [(residual_of(at, p, j, power), p, power) for j, p in enumerate(problem.parameters) if p.is_log
             for power in (*POWERS, *(-k for k in POWERS))]  # fmt: skip
    best, p, power = min(tried, key=lambda item: item[0], default=(np.inf, None, 0))
    if p is None or best > at.cost / BETTER**2:
        return
    there = show(p.value(p.centre + power * np.log(10)), p.field.unit)
    readings = max(len(at.left), 1)
    wrong = (f"{p.path} is {p.told(p.centre)}, and with {there} the recordings would be met to "
             f"{np.sqrt(best / readings):.3g} σ instead of {rms(at.left):.3g} σ")  # fmt: skip
    yield Refusal(Spot(file), wrong, "check its unit")


def residual_of(at: Linearised, p: Parameter, j: int, power: int) -> float:
    """J at the priors' centres with one number a power of ten off, that number's prior aside."""
    problem = at.problem
    moved = replace(p, centre=p.centre + power * np.log(10), low=-np.inf, high=np.inf)
    if not p.field.low <= p.value(moved.centre) <= p.field.high:
        return float("inf")
    theta = centres(problem.parameters)
    theta[j] = moved.centre
    try:
        about = linearise(problem, theta)
    except Failed:
        return float("inf")
    return about.cost - float(((theta[j] - p.centre) / p.spread) ** 2)


def _channels(before: Comparison) -> Iterator[Refusal]:
    for residual in before.recordings:
        for channel in residual.channels.values():
            told = _channel(channel)
            if told:
                yield Refusal(Spot(residual.recording.file), told, "check the unit in its header")


def _channel(channel: ChannelResidual) -> str:
    """What is strange about the size of a channel, '' if nothing is."""
    good = channel.finite
    measured, simulated = channel.measured[good], channel.simulated[good]
    shift = float(np.median(measured - simulated))
    if channel.unit == "degC" and abs(abs(shift) - ZERO_CELSIUS) < 40:
        return f"{channel.name} reads {shift:+.0f} K beside the simulation, as kelvin and degrees Celsius do"
    m, s = measured - measured[0], simulated - simulated[0]
    if channel.unit == "degC" or not s.any() or not m.any():
        return ""
    factor = float(m @ s / (s @ s))
    power = round(np.log10(abs(factor))) if factor else 0
    like = abs(float(m @ s)) / np.sqrt(float(m @ m) * float(s @ s))
    if abs(power) < 2 or like < STRAIGHT:
        return ""
    return f"{channel.name} reads 1e{power} times what is simulated, in the same shape"
