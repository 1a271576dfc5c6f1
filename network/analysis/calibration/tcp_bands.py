"""How well the tool centre point is known over a recording: ±1σ that the calibrated numbers' uncertainty leaves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import displacement
from network.catalogue.declaration.fields import Amount
from network.catalogue.sensors.sensor import Sensor
from network.engine.assembly import build
from network.engine.response.knots import make_knots, on_knots
from network.engine.response.model import Model, Prediction, Run
from network.engine.response.parameters import Parameter
from network.engine.simulation import schedule_for
from network.engine.start import start_temperatures
from network.engine.trajectory import axis_unit, in_difference_unit
from network.machine.machine import Machine
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Band:
    """Of one axis over one recording. t [s]; centre, std: [m] or [rad]; unit: shown."""

    axis: str
    t: Array
    centre: Array
    std: Array
    unit: str

    @property
    def largest(self) -> float:
        """Largest 1σ, in its unit."""
        return float(in_difference_unit(self.std, self.unit).max())

    def at(self, t: Array) -> tuple[Array, Array]:
        """Centre and 1σ at other instants."""
        return np.interp(t, self.t, self.centre), np.interp(t, self.t, self.std)

    def summary(self) -> dict[str, object]:
        k = int(np.argmax(self.std))
        return {"axis": self.axis, "largest_std": self.largest, "at": float(self.t[k]), "unit": self.unit}


def with_axes(machine: Machine) -> Machine:
    """The machine with a further probe on every axis, called like it."""
    probes = {displacement(a): Sensor(displacement(a), measures=displacement(a), noise=Amount(1e-6, axis_unit(a)))
              for a in machine.tcp}  # fmt: skip
    return replace(machine, sensors={**machine.sensors, **probes})


def run_of(machine: Machine, source: Recording | Scenario, start: Start | None) -> Run:
    """A schedule laid out for a fit, all channels present at every sample."""
    schedule = schedule_for(machine, source, start)
    knots, network = make_knots(schedule), build(machine)
    T0 = start_temperatures(network, schedule, source if isinstance(source, Recording) else None)
    parts = {name: float(T0[part].mean()) for name, part in network.parts.items()}
    present = {name: np.ones(len(schedule.t), bool) for name in machine.sensors}
    return Run(source.name, on_knots(schedule, knots), knots, parts, present)


def bands(
    machine: Machine, parameters: Sequence[Parameter], theta: Array, covariance: Array, source: Recording | Scenario,
    start: Start | None = None,
) -> tuple[Band, ...]:  # fmt: skip
    """Bands of all axes; `machine` with its sensors, which tell where the run begins."""
    if not machine.tcp:
        return ()
    probed = with_axes(machine)
    run = replace(run_of(machine, source, start), present={displacement(a): np.ones(1, bool) for a in machine.tcp})
    model = Model(probed, parameters, [run])
    (prediction,) = model.predict(theta)
    (slopes,) = model.slopes(theta, [prediction])
    variance = np.einsum("ick,ij,jck->ck", slopes, covariance, slopes, optimize=True)
    return tuple(_band(axis, i, prediction, variance) for i, axis in enumerate(machine.tcp))


def _band(axis: str, i: int, prediction: Prediction, variance: Array) -> Band:
    edges = prediction.course.problem.plan.edges
    count = len(edges) - 1
    first, last = slice(0, count), slice(2 * count - 1, 2 * count)
    values, spread = prediction.values[i], np.sqrt(np.maximum(variance[i], 0.0))
    centre, std = (np.concatenate([v[first], v[last]]) for v in (values, spread))
    return Band(axis, edges, centre, std, axis_unit(axis))
