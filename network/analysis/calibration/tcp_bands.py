"""How well the tool centre point is known over a run: what the numbers' uncertainty and the machine leave it.

Half the band of 95 % is 1.96 √(σ_θ(t)² + left²): σ_θ² = Sᵀ C S, S the slopes of the axis by θ along this very run and C
their covariance; left: what the machine leaves on runs it has not seen (generalisation.py). A probe that reads zero at
the start shares what is left then, and less of it later: its band is too wide near the start, and no wider than √2.
Range: σ_θ is linearised. Where numbers of an incomplete machine are known to some 10 % only and cancel each other, it
can be half of what drawn numbers spread; what the machine leaves is then several times either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.calibration.uncertainty import LEVEL
from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import displacement
from network.catalogue.declaration.fields import Amount
from network.catalogue.sensors.sensor import Sensor
from network.engine.assembly import build
from network.engine.response.knots import make_knots, on_knots
from network.engine.response.model import Model, Run
from network.engine.response.parameters import Parameter, centres, free_parameters
from network.engine.simulation import schedule_for
from network.engine.start import start_temperatures
from network.engine.trajectory import axis_unit
from network.machine.machine import Machine
from network.platform.printing import Brief
from network.platform.quantities.unit_values import in_difference_unit
from network.recordings.call_arguments import expect_run
from network.recordings.inputs import Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario


@dataclass(frozen=True, eq=False, repr=False)
class Band(Brief):
    """Of one axis over one run. t [s]; centre, std (1σ by the numbers): [m] or [rad]; unit: shown; left: 1σ of what the
    machine leaves, None where no channel measured the axis."""

    axis: str
    t: Array
    centre: Array
    std: Array
    unit: str
    left: float | None = None

    @property
    def largest(self) -> float:
        """Largest 1σ, in its unit."""
        return float(in_difference_unit(self.std, self.unit).max())

    @property
    def total(self) -> Array:
        """1σ by numbers and machine."""
        return np.asarray(np.hypot(self.std, self.left or 0.0))

    @property
    def widest(self) -> float:
        """Largest half of the band of 95 %, in its unit."""
        return float(in_difference_unit(LEVEL * self.total, self.unit).max())

    def limits(self, t: Array, centre: Array) -> tuple[Array, Array]:
        """Lower and upper end of the band of 95 % about a course at other instants."""
        half = LEVEL * np.interp(t, self.t, self.total)
        return centre - half, centre + half

    def at(self, t: Array) -> tuple[Array, Array]:
        """Centre and 1σ at other instants."""
        return np.interp(t, self.t, self.centre), np.interp(t, self.t, self.std)

    def summary(self) -> dict[str, object]:
        k = int(np.argmax(self.std))
        return {"axis": self.axis, "largest_std": self.largest, "at": float(self.t[k]), "unit": self.unit,
                "left": None if self.left is None else float(in_difference_unit(np.array(self.left), self.unit)),
                "widest95": self.widest}  # fmt: skip


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
    start: Start | None = None, left: Mapping[str, float] | None = None,
) -> tuple[Band, ...]:  # fmt: skip
    """Bands of all axes; `machine` with its sensors, which tell where the run begins; left: 1σ by axis."""
    if not machine.tcp:
        return ()
    known = Posterior(parameters, theta, covariance)
    names = [displacement(axis) for axis in machine.tcp]
    t, course, stds = spread_of(with_axes(machine), known, run_of(machine, source, start), names)
    return tuple(Band(axis, t, course[i], stds[i], axis_unit(axis), (left or {}).get(axis))
                 for i, axis in enumerate(machine.tcp))  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Posterior(Brief):
    """Uncertain numbers, θ, and its covariance."""

    parameters: Sequence[Parameter]
    theta: Array
    covariance: Array

    @classmethod
    def of(cls, machine: Machine, root: Mapping[str, Sequence[float]]) -> Posterior:
        """Those of a calibrated machine; root: rows of L by path, L Lᵀ their correlation. A number that came to it
        later is tied to none."""
        parameters = free_parameters(machine)
        place = {path: i for i, path in enumerate(root)}
        L = np.zeros((len(parameters), len(root) + len(parameters)))
        for i, p in enumerate(parameters):
            row = np.array(root.get(p.path, ()))
            L[i, : len(row)] = row / np.linalg.norm(row) if len(row) else 0.0
            L[i, len(root) + i] = 0.0 if p.path in place else 1.0
        scaled = L * np.array([[p.spread] for p in parameters]).reshape(-1, 1)
        return cls(parameters, centres(parameters), np.asarray(scaled @ scaled.T))


def spread_of(machine: Machine, known: Posterior, run: Run, names: Sequence[str]) -> tuple[Array, Array, Array]:
    """Of some channels over a run: instants, course, and 1σ by the numbers, (channels, instants) each."""
    run = replace(run, present={name: np.ones(1, bool) for name in names})
    model = Model(machine, known.parameters, [run])
    (prediction,) = model.predict(known.theta)
    (slopes,) = model.slopes(known.theta, [prediction])
    variance = np.einsum("ick,ij,jck->ck", slopes, known.covariance, slopes, optimize=True)
    edges, spread = prediction.course.problem.plan.edges, np.sqrt(np.maximum(variance, 0.0))
    count = len(edges) - 1
    values, spread = (np.hstack([v[:, :count], v[:, -1:]]) for v in (prediction.values, spread))
    return edges, values, spread


def bands_of(machine: Machine, source: Recording | Scenario, start: Start | None = None) -> tuple[Band, ...]:
    """Bands of 95 % of all axes of a calibrated machine along a run, from what its file says of the calibration; none
    for a machine that was not calibrated. Raises Refused where a run lacks an input, or a fit cannot follow."""
    expect_run(machine, source, start)
    known = machine.validity
    if known is None:
        return ()
    numbers = Posterior.of(machine, known.root)
    return bands(machine, numbers.parameters, numbers.theta, numbers.covariance, source, start, known.left)
