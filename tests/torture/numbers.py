"""Numbers of random networks: slopes by them against differences of runs, and whether they are found again in a
recording of the machine that has them."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import log
from typing import Any

import numpy as np
from fits import problem_of, recorded

from network import Machine, Refused, calibrate
from network.analysis.calibration.problem import Problem
from network.catalogue.declaration.declare import Array
from network.engine.response.parameters import centres
from network.recordings.inputs import Signal
from torture.networks import Drawn

SHARE = 0.05
"""How far slopes may lie from differences, as heats run straight between knots, which a part of less than a knot's
distance does not: a twentieth leaves numbers a twentieth of their σ off, and after five steps of Gauss-Newton 3e-7."""
STEP = 1e-5
"""Of the logarithm of a number, either way."""
SAMPLES = 120
SURE = 5.0
"""Standard errors that a number found again may be off by: of a million, one is by chance."""
OFF = 0.15
"""Share that the machine which is calibrated is off by, of the ± 30 % that it states."""


@dataclass(frozen=True)
class Compared:
    """way: of two; furthest: apart, in units of what is allowed."""

    way: str
    furthest: float


def compare_numbers(drawn: Drawn, chance: random.Random) -> Iterator[Compared]:
    """Of a linear network: up to three of its conductances."""
    t = np.linspace(0.0, float(drawn.schedule.t[-1]), SAMPLES)
    schedule = replace(drawn.schedule, t=t, signals=_at_samples(drawn.schedule.signals, t))
    links = chance.sample([*_links(drawn.machine)], 1 if len(drawn.machine.links) == 1 else 2)
    truth = drawn.machine.patched(_uncertain(drawn.machine, links, 1.0))
    yield from _compare_slopes(problem_of(truth, recorded(truth, schedule, None)))
    off = drawn.machine.patched(_uncertain(drawn.machine, links, 1 + OFF))
    try:
        found = calibrate(off, recorded(truth, schedule, chance.randrange(10**6)))
    except Refused:
        return
    values = {f"links.{name}.{key}": value for name, (key, value) in links}
    for parameter, theta, std in zip(found.parameters, found.fit.at.theta, found.known.std, strict=True):
        yield Compared("found again", abs(float(theta) - log(values[parameter.path])) / (SURE * float(std)))


def _at_samples(signals: Mapping[str, Signal], t: Array) -> dict[str, Signal]:
    """What is recorded of an input that steps between samples is another input."""
    moved = {}
    for name, signal in signals.items():
        order = np.arange(len(signal.t))
        moved[name] = replace(signal, t=t[np.maximum.accumulate(np.searchsorted(t, signal.t) - order) + order])
    return moved


def _links(machine: Machine) -> Iterator[tuple[str, tuple[str, float]]]:
    for name, link in machine.links.items():
        key = "capacity_flow" if hasattr(link, "capacity_flow") else "conductance"
        yield name, (key, float(getattr(link, key)))


def _uncertain(machine: Machine, links: list[tuple[str, tuple[str, float]]], factor: float) -> dict[str, Any]:
    plain: Any = machine.to_plain()["links"]
    return {"links": {name: {**plain[name], key: f"{value * factor:.17g} W/K ± 30 %"} for name, (key, value) in links}}


def _compare_slopes(problem: Problem) -> Iterator[Compared]:
    data, theta = problem.data[0], centres(problem.parameters)
    slopes = problem.model.mean_slopes(theta, problem.model.predict(theta))[0]
    weight = np.where(data.known, data.variance**-0.5, 0.0)
    for j in range(len(theta)):
        there, back = (_cells(problem, theta, j, sign * STEP) for sign in (1, -1))
        difference = (there - back) / (2 * STEP) * weight
        size = max(float(np.linalg.norm(difference)), 1.0)
        yield Compared("slopes", float(np.linalg.norm(slopes[j] * weight - difference)) / (SHARE * size))


def _cells(problem: Problem, theta: Array, j: int, step: float) -> Array:
    moved = theta.copy()
    moved[j] += step
    return problem.model.predict(moved)[0].cells
