"""The correction that controls have built in: an offset and a slope over position, straight in temperature.

δ = a + Σ b_i (T_i − T_0) + (P − P_0) (c + Σ d_i (T_i − T_0)), T_0 the machine's reference, P_0 the middle of the
travel; c and d where an axis moves with a position that the machine reads. Least squares on the runs of the full model.
Without sensors named, the one that does best alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.analysis.correction.correction import list_sensors
from network.analysis.sweep.lumping_error import LumpingError, estimate_over
from network.catalogue.declaration.declare import Array
from network.engine.simulation import check_known, simulate
from network.engine.trajectory import Trajectory, axis_unit, drop_rounding
from network.machine.machine import Machine
from network.platform.printing import Result
from network.platform.quantities.units import unit
from network.platform.refusal import Spot, refuse
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario


@dataclass(frozen=True)
class Formula:
    """Of one axis. offset, by_sensor: a [m], b [m/K]; slope, slope_by_sensor: c, d [m/m]; position: the input P, empty
    where it does not count; middle: P_0 [m]; lost: by run, the largest difference to the full model [m]; uncorrected:
    by run, the largest movement [m]."""

    axis: str
    sensors: tuple[str, ...]
    reference: float
    offset: float
    by_sensor: tuple[float, ...]
    position: str
    middle: float
    slope: float
    slope_by_sensor: tuple[float, ...]
    lost: tuple[float, ...]
    uncorrected: tuple[float, ...]

    def summary(self) -> dict[str, Any]:
        shown = unit(axis_unit(self.axis))
        told: dict[str, Any] = {
            "unit": axis_unit(self.axis), "sensors": list(self.sensors), "reference_degC": self.reference,
            "offset": shown.from_si(self.offset), "per_K": [shown.from_si(b) for b in self.by_sensor],
            "lost": [shown.from_si(v) for v in self.lost], "uncorrected": [shown.from_si(v) for v in self.uncorrected],
        }  # fmt: skip
        if self.position:
            told |= {"position": self.position, "position_0_mm": 1e3 * self.middle, "slope_um_per_m": 1e6 * self.slope,
                     "slope_per_K": [1e6 * d for d in self.slope_by_sensor]}  # fmt: skip
        return told


@dataclass(frozen=True, eq=False, repr=False)
class FormulaTable(Result):
    """formulas: one for each axis that moves; runs: the names of those they were fitted on; lumping: what finer lumps
    would change in the full model, on the run where that is most."""

    machine: Machine
    formulas: tuple[Formula, ...]
    runs: tuple[str, ...]
    lumping: LumpingError | None = None

    @property
    def sensors(self) -> tuple[str, ...]:
        """All that some axis reads."""
        return tuple(dict.fromkeys(name for formula in self.formulas for name in formula.sensors))

    def summary(self) -> dict[str, Any]:
        """What export.json holds."""
        axes = {formula.axis: formula.summary() for formula in self.formulas}
        lumping = None if self.lumping is None else self.lumping.summary()
        return {"machine": self.machine.name, "runs": list(self.runs), "axes": axes, "lumping": lumping}


def fit_formulas(
    machine: Machine, sources: Sequence[Scenario | Recording], channels: Sequence[str] | None = None
) -> FormulaTable:
    """Formulas of every axis on the runs of the full model. Raises Refused without a run, a sensor or an axis."""
    check_known(machine)
    known = list_sensors(machine)
    own = known if channels is None else [name for name in channels if name in known]
    if not sources:
        raise refuse(Spot("lptn export"), "has no run to fit two numbers an axis on", "give a scenario or a recording")
    if not own:
        right = f"give one of {', '.join(known)} in --inputs" if known else "add a temperature sensor"
        raise refuse(Spot(machine.file), "leaves the control no temperature", right)
    if not machine.tcp:
        raise refuse(Spot(machine.file), "moves no tool centre point, so there is nothing to correct", "add `tcp`")
    runs = [simulate(machine, source) for source in sources]
    choices = [(name,) for name in own] if channels is None else [tuple(own)]
    formulas = [min((_fit(machine, runs, axis, chosen) for chosen in choices), key=lambda pair: pair[0])[1]
                for axis in _moving(machine, runs)]  # fmt: skip
    lumping = estimate_over(machine, zip(sources, runs, strict=True))
    return FormulaTable(machine, tuple(formulas), tuple(run.schedule.name for run in runs), lumping)


def _moving(machine: Machine, runs: Sequence[Trajectory]) -> list[str]:
    """Axes that move along some run; all where none does."""
    moving = [axis for axis in machine.tcp if any(drop_rounding(run.tcp[axis]).any() for run in runs)]
    return moving or [*machine.tcp]


def _fit(machine: Machine, runs: Sequence[Trajectory], axis: str, sensors: tuple[str, ...]) -> tuple[float, Formula]:
    """The sum of squares left, and the formula."""
    position, middle = _position(machine, runs, axis)
    columns = [_columns(run, machine.reference, sensors, position, middle) for run in runs]
    moved = [run.tcp[axis] for run in runs]
    X = np.concatenate(columns)
    # 1e-9: of two sensors that read alike none gets a large number against the other
    penalty = 1e-9 * float(np.sum(X**2)) * np.diag([0.0, *([1.0] * (X.shape[1] - 1))])
    found = np.linalg.lstsq(X.T @ X + penalty, X.T @ np.concatenate(moved), rcond=None)[0].tolist()
    left = [values - each @ found for values, each in zip(moved, columns, strict=True)]
    n = len(sensors) + 1
    slopes = found[n:] or [0.0] * n
    formula = Formula(
        axis, sensors, machine.reference, found[0], tuple(found[1:n]), position, middle, slopes[0], tuple(slopes[1:]),
        tuple(float(np.abs(values).max()) for values in left), tuple(float(np.abs(v).max()) for v in moved),
    )  # fmt: skip
    return float(sum(np.sum(values**2) for values in left)), formula


def _position(machine: Machine, runs: Sequence[Trajectory], axis: str) -> tuple[str, float]:
    """The position that the axis moves with, and the middle of its travel [m]; none where it does not change."""
    reads = {name for (a, _), entry in machine.expansions.items() if a == axis for name in entry.needs()}
    for name in sorted(name for name in reads if machine.inputs[name] == "m"):
        seen = np.concatenate([run.inputs[name] for run in runs])
        if np.ptp(seen) > 0:
            return name, float(seen.min() + seen.max()) / 2
    return "", 0.0


def _columns(run: Trajectory, reference: float, sensors: tuple[str, ...], position: str, middle: float) -> Array:
    plain = np.stack([np.ones(len(run.t)), *(run.sensors[name] - reference for name in sensors)], axis=1)
    return plain if not position else np.hstack([plain, plain * (run.inputs[position] - middle)[:, None]])
