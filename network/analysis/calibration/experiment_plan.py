"""Before any recording: which numbers a schedule will determine with these sensors, and which sensor would buy most.

The channels' slopes at the priors' centres give the posterior of a recording that has not been made yet: its covariance
is (SᵀS + V⁻¹)⁻¹ whatever will be read. Source: Fedorov, Theory of Optimal Experiments (1972), ch. 1; unverified.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from network.analysis.calibration.measured_means import OFFSET
from network.analysis.calibration.recording_admission import check_parameters
from network.analysis.calibration.tcp_bands import Band, bands, run_of
from network.analysis.calibration.uncertainty import CLOSELY, PRIOR_ONLY
from network.analysis.comparison.common_start import START
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import displacement
from network.catalogue.declaration.fields import Amount, Place
from network.catalogue.sensors.sensor import Sensor
from network.engine.response.model import Model
from network.engine.response.nuisance_pushes import start_pushes
from network.engine.response.parameters import Parameter, at_prior_centres, centres, free_parameters
from network.engine.trajectory import axis_unit
from network.machine.machine import Machine
from network.platform.printing import Brief, Result, summarise
from network.platform.threads import on_one_thread
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

USUAL = {"degC": 0.1, "um": 0.5e-6, "urad": 0.5e-6}
"""1σ of a sample of a sensor that is not there yet, where none of its kind is."""


@dataclass(frozen=True, eq=False, repr=False)
class Candidate(Brief):
    """A sensor that is not there. ratio: 1σ of each number with it over that without; bands: worst 1σ of each axis."""

    measures: str
    noise: str
    ratio: Array
    bands: Mapping[str, float]

    @property
    def worth(self) -> float:
        """Nats that it tells about the numbers, each for itself."""
        return float(-np.log(self.ratio).sum())


@dataclass(frozen=True, eq=False, repr=False)
class Foresight(Result):
    """What a schedule would tell. covariance: posterior of θ; bands: of the TCP before and after; candidates: further
    sensors, the best first."""

    machine: Machine
    schedule: str
    parameters: tuple[Parameter, ...]
    covariance: Array
    bands_before: tuple[Band, ...]
    bands: tuple[Band, ...]
    candidates: tuple[Candidate, ...]

    @cached_property
    def std(self) -> Array:
        return np.asarray(np.sqrt(np.diag(self.covariance)), float)

    @cached_property
    def share(self) -> Array:
        """Posterior over prior 1σ."""
        return np.asarray(self.std / [p.spread for p in self.parameters])

    @property
    def pairs(self) -> Iterator[tuple[int, int, float]]:
        """Pairs that are only known together, the closest first."""
        C = self.covariance / np.outer(self.std, self.std)
        n = len(C)
        rows = [(i, j, float(C[i, j])) for i in range(n) for j in range(i + 1, n) if abs(C[i, j]) > CLOSELY]
        told = [r for r in rows if max(self.share[r[0]], self.share[r[1]]) <= PRIOR_ONLY]
        yield from sorted(told, key=lambda r: -abs(r[2]))

    def summary(self) -> dict[str, Any]:
        return summarise(self)

    def __repr__(self) -> str:
        return f"<what {self.schedule} would tell about {self.machine.name}>"


@on_one_thread
def foresee(machine: Machine, source: Scenario | Recording, *, start: Start | None = None) -> Foresight:
    """What a recording along a schedule would tell. Raises Refused for a machine without uncertain numbers."""
    parameters = free_parameters(machine)
    check_parameters(machine, parameters)
    return _foresee(machine, parameters, source, start)


def _foresee(
    machine: Machine, parameters: tuple[Parameter, ...], source: Scenario | Recording, start: Start | None
) -> Foresight:
    known = at_prior_centres(machine, parameters)
    further = candidates(machine)
    gained = information(replace(known, sensors={**machine.sensors, **further}), parameters, source, start)
    n, theta = len(parameters), centres(parameters)
    prior = np.diag([*(p.spread**-2.0 for p in parameters), *[START**-2.0] * len(parts_of(machine))])
    precision = prior + sum((gained[name] for name in machine.sensors), np.zeros(prior.shape))
    before, covariance = (inverse(matrix)[:n, :n] for matrix in (prior, precision))
    width = [bands(known, parameters, theta, C, source, start) for C in (before, covariance)]
    rated = []
    for name, sensor in further.items():
        with_it = inverse(precision + gained[name])[:n, :n]
        ratio = np.sqrt(np.diag(with_it) / np.diag(covariance))
        reached = bands(known, parameters, theta, with_it, source, start)
        rated.append(Candidate(str(sensor.measures), str(sensor.noise), ratio, {b.axis: b.largest for b in reached}))
    rated.sort(key=lambda c: -c.worth)
    return Foresight(machine, source.name, parameters, covariance, width[0], width[1], tuple(rated))


def parts_of(machine: Machine) -> list[str]:
    return [name for name, node in machine.nodes.items() if node.is_part]


def inverse(matrix: Array) -> Array:
    return np.asarray(np.linalg.inv(matrix), np.float64)


def candidates(machine: Machine) -> dict[str, Sensor]:
    """A sensor for every part and every axis that has none, as good as the usual one of the machine."""
    sensed = {s.place.node for s in machine.sensors.values() if s.place}
    read = {s.axis for s in machine.sensors.values()}
    sensors = {}
    for name, node in machine.nodes.items():
        if node.is_part and name not in sensed:
            sensors[f"new {name}"] = Sensor(f"new {name}", measures=Place(name), noise=_usual(machine, "degC"))
    for axis in machine.tcp:
        if axis not in read:
            channel = displacement(axis)
            noise = _usual(machine, axis_unit(axis))
            sensors[f"new {channel}"] = Sensor(f"new {channel}", measures=channel, noise=noise)
    return sensors


def _usual(machine: Machine, unit_text: str) -> Amount:
    """The median noise of the sensors of that unit."""
    sigmas = [s.sigma for s in machine.sensors.values() if s.unit == unit_text] or [USUAL[unit_text]]
    return Amount(float(np.median(sigmas)), "K" if unit_text == "degC" else unit_text)


def information(
    machine: Machine, parameters: Sequence[Parameter], source: Scenario | Recording, start: Start | None
) -> dict[str, Array]:
    """What each channel tells about θ and the start of every part, its own constant error aside: SᵀΣ⁻¹S."""
    run = run_of(machine, source, start)
    model = Model(machine, parameters, [run])
    theta = centres(parameters)
    (prediction,) = model.predict(theta)
    slopes = prediction.means(model.slopes(theta, [prediction])[0])
    pushes = start_pushes(prediction.course, parts_of(machine))
    begin = prediction.means(prediction.changes(prediction.course.answers(pushes)))
    columns, cells, by_channel = np.vstack([slopes, begin]), run.knots.cells, {}
    counts = np.maximum(np.bincount(run.knots.cell_of, minlength=cells), 1)
    for i, name in enumerate(run.channels):
        own, sensor = slice(i * cells, (i + 1) * cells), machine.sensors[name]
        sigma = np.diag(sensor.sigma**2 / counts) + OFFSET[sensor.unit] ** 2
        by_channel[name] = np.asarray(columns[:, own] @ np.linalg.solve(sigma, columns[:, own].T))
    return by_channel
