"""From a machine to the filter of a control, and the micrometres that this loses on every run given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import block_diag, expm

from network.analysis.correction.filter_model import FilterModel
from network.analysis.correction.input_table import InputTable, tabulate
from network.analysis.correction.kalman_gain import first_gain, main_directions, settle, unsure_drives
from network.analysis.correction.linear_model import LinearModel, linearise
from network.analysis.correction.reduction import Reduction, balance, cut
from network.analysis.sweep.lumping_error import LumpingError, estimate_over
from network.catalogue.declaration.declare import Array
from network.engine.simulation import check_known, schedule_for, simulate
from network.engine.trajectory import Trajectory, axis_unit
from network.machine.machine import Machine
from network.platform.printing import Brief, Result
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import unit
from network.platform.refusal import Spot, refuse
from network.recordings.inputs import Schedule
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario

UNSEEN = 0.5e-6
"""m: what is lost below half a micrometre is not worth a state where no displacement channel has a noise."""
LASTING = 1 + 1e-9
"""Growth of a state in a step, by rounding, of a machine that loses no heat."""
HARDLY = 1.05
"""Times what all states lose that is no more to speak of: both are told to two digits."""
USUAL_TOPS = {"rpm": 10_000.0, "m/min": 30.0}


@dataclass(frozen=True, eq=False, repr=False)
class Loss(Brief):
    """What one run loses: its name, and by axis the largest difference to the full model [m, rad]; t: steps [s]; full,
    told: by axis what the full model and the filter say there (of a parted recording the longest piece)."""

    run: str
    by_axis: Mapping[str, float]
    t: Array
    full: Mapping[str, Array]
    told: Mapping[str, Array]

    def summary(self) -> dict[str, Any]:
        return {"run": self.run, "axes": {axis: _shown(axis, value) for axis, value in self.by_axis.items()}}


@dataclass(frozen=True, eq=False, repr=False)
class Correction(Result):
    """filter: what the control runs; full: states of the machine; losses: of every run, without its sensors, from the
    same start; by_states: number of states → largest loss over all runs and axes [m], of those tried;
    lumping: what finer lumps would change in the full model, on the run where that is most."""

    machine: Machine
    filter: FilterModel
    full: int
    losses: tuple[Loss, ...]
    by_states: Mapping[int, float]
    notes: tuple[str, ...]
    lumping: LumpingError | None = None

    def summary(self) -> dict[str, Any]:
        """What export.json holds."""
        return {
            "machine": self.machine.name, "states": self.filter.own, "full_states": self.full,
            "unknown_states": self.filter.states - self.filter.own,
            "step": {"value": self.filter.step, "unit": "s"}, "inputs": dict(self.filter.inputs),
            "sensors": list(self.filter.sensors), "multiplications": self.filter.multiplications,
            "lost": [loss.summary() for loss in self.losses],
            "lost_by_states": {str(n): 1e6 * lost for n, lost in self.by_states.items()}, "notes": list(self.notes),
            "lumping": None if self.lumping is None else self.lumping.summary(),
        }  # fmt: skip


def _shown(axis: str, value: float) -> dict[str, Any]:
    return {"value": unit(axis_unit(axis)).from_si(value), "unit": axis_unit(axis)}


def make_correction(
    machine: Machine, sources: Sequence[Scenario | Recording], *, states: int | None = None,
    channels: Sequence[str] | None = None, step: float = 10.0,
) -> Correction:  # fmt: skip
    """The filter of a machine. sources: the runs that it is reduced for and judged on; channels: the inputs and
    sensors that the control has, all by default; an input that it lacks stays at its mean over the runs; states: as
    many as lose less than half the noise of the displacement channels, all without runs, unless given. Raises
    Refused."""
    check_known(machine)
    runs = [simulate(machine, source) for source in sources]
    sensors = [n for n in list_sensors(machine) if channels is None or n in channels]
    model = linearise(machine, runs, sensors)
    constant, tables = tabulate(model, _tops(machine, runs))
    noise = np.array([machine.sensors[name].sigma for name in sensors])
    to, back = balance(model.A, _drives(model, tables), _outputs(model))
    made: dict[int, tuple[FilterModel, tuple[Loss, ...]]] = {}
    for count in range(1, len(to) + 1) if states is None and runs else [min(states or len(to), len(to))]:
        reduced = cut(model.A, model.C, to, back, count)
        filter_ = _without(_filter(model, reduced, constant, tables, noise, step), runs, channels)
        made[count] = filter_, tuple(_lose(model, filter_, run, reduced) for run in runs)
        if _largest(made[count][1]) <= _unseen(machine):
            break
    filter_, losses = made[max(made)]
    _refuse_long_step(filter_)
    by_states = {n: _largest(lost) for n, (_, lost) in made.items()}
    lumping = estimate_over(machine, zip(sources, runs, strict=True))
    kept = _tell_all_kept(machine, by_states, len(to), step) if states is None else []
    notes = (*kept, *_notes(machine, sensors, channels))
    return Correction(machine, filter_, len(model.A), losses, by_states, notes, lumping)


def _refuse_long_step(filter_: FilterModel) -> None:
    if not filter_.growth <= LASTING:
        wrong = f"{filter_.step:g} s is too long for conductances that inputs drive: what they let pass is held so long"
        raise refuse(Spot("--step"), wrong, f"take a shorter one, like --step '{filter_.step / 5:g} s'")


def list_sensors(machine: Machine) -> list[str]:
    """Temperature channels that a filter can read: those that tell the truth but for noise."""
    return [n for n, s in machine.sensors.items() if s.place is not None and not s.effects and s.gate is None]


def _tops(machine: Machine, runs: Sequence[Trajectory]) -> dict[str, float]:
    """The largest magnitude of every input over the runs, in its unit."""
    tops = {}
    for name, text in machine.inputs.items():
        seen = [float(np.abs(run.inputs[name]).max()) / unit(text or "1").scale for run in runs if name in run.inputs]
        tops[name] = max(seen, default=0.0) or USUAL_TOPS.get(text, 1.0)
    return tops


def _drives(model: LinearModel, tables: Sequence[InputTable]) -> Array:
    """What the states are balanced for: an hour of every input at its largest, 5 K of every held node, a start."""
    columns = [3600 * model.F_heat @ table.above[-1][: model.network.size] for table in tables]
    columns += [3600 * 5.0 * column for column in model.F_held.T]
    return np.stack([*columns, 5.0 * _uniform(model)], axis=1)


def _uniform(model: LinearModel) -> Array:
    return np.where(model.network.is_state[model.network.free], 0.0, 1.0)


def _outputs(model: LinearModel) -> Array:
    """Axes in µm; a kelvin at a sensor counts as a micrometre."""
    return np.concatenate([model.C[: len(model.axes)] * 1e6, model.C[len(model.axes) :]])


def _filter(
    model: LinearModel, reduced: Reduction, constant: Array, tables: Sequence[InputTable], noise: Array, step: float
) -> FilterModel:
    """In steps, axes in µm and µrad, temperatures as rises over the reference."""
    r, axes, machine = reduced.states, len(model.axes), model.machine
    both = expm(np.block([[reduced.A, np.eye(r)], [np.zeros((r, 2 * r))]]) * step)
    Phi, Gamma = both[:r, :r], both[:r, r:]
    seen = axes + len(model.sensors)
    films = len(model.C) - seen
    spread = np.vstack([np.zeros((0, model.network.size)), *(film.spread for film in model.films)])
    scale = np.concatenate([[1 / unit(axis_unit(a)).scale for a in model.axes], np.ones(len(model.C) - axes)])
    by_heat = _by_drive(reduced, Gamma, model.F_heat, model.D_heat, scale)
    at_once = np.zeros((len(by_heat), axes))
    at_once[r : r + axes] = np.diag(scale[:axes])
    values = block_diag(np.hstack([by_heat, at_once]), np.eye(films))
    columns = _by_drive(reduced, Gamma, model.F_held, model.D_held, scale)
    held, fixed = _held(model, np.vstack([columns, np.zeros((films, columns.shape[1]))]))
    rises = np.concatenate([np.zeros(axes), np.full(len(model.sensors), machine.reference), np.zeros(films)])
    at_point = np.concatenate([np.zeros(r), (model.shift - rises) * scale, np.zeros(films)])
    constant = values @ constant + fixed + at_point
    heats, rooms = unsure_drives(model, tuple(tables))
    drives = np.stack([*(by_heat @ heat for heat in heats.values()), *(columns * [*rooms.values()]).T], axis=1)
    weights, like = main_directions(drives[: r + seen], [*heats, *rooms], max(len(model.sensors), 1))
    unknown = drives @ weights
    C, p = reduced.C * scale[:, None], unknown.shape[1]
    rows = np.hstack([C[seen:], unknown[r + seen :]])
    Phi, C, steady = settle(Phi, C[:axes], C[axes:seen], unknown[: r + seen], step, noise)
    cold = model.point[model.network.free] - machine.reference
    pad = np.insert(np.eye(len(constant)), [r] * p, 0.0, axis=0)
    return FilterModel(
        machine.name, step, machine.reference, {n: text or "1" for n, text in machine.drives.items()}, model.sensors,
        model.axes, tuple(axis_unit(a) for a in model.axes), r, like, np.eye(p) - steady.states[r:, r:], Phi,
        C[:axes], C[axes:], {name: pad @ column for name, column in held.items()},
        tuple(table.map(pad @ values) for table in tables),
        pad @ constant, _pad(reduced.project @ _uniform(model), p), _pad(reduced.project @ (cold * _uniform(model)), p),
        steady.gain, first_gain(reduced.project, C[axes:], noise),
        np.sqrt(np.einsum("ij,jk,ik->i", C[:axes], steady.states, C[:axes])), steady.missed,
        rows, (pad @ block_diag(by_heat, np.zeros((films, 0))) @ spread.T)[: r + p + axes].T,
    )  # fmt: skip


def _pad(states: Array, count: int) -> Array:
    return np.concatenate([states, np.zeros(count)])


def _by_drive(reduced: Reduction, Gamma: Array, F: Array, D: Array, scale: Array) -> Array:
    """What a drive does to the states in a step, and to the outputs at once."""
    return np.vstack([Gamma @ reduced.drive @ F, (reduced.direct @ F + D) * scale[:, None]])


def _held(model: LinearModel, columns: Array) -> tuple[dict[str, Array], Array]:
    """Columns of the held nodes by the input that holds them, and what the others, and the point, add."""
    machine, held, fixed = model.machine, dict[str, Array](), np.zeros(len(columns))
    for k, lump in enumerate(model.network.bound.tolist()):
        source = model.network.held[lump].source
        fixed -= columns[:, k] * (model.point[lump] - machine.reference)
        if isinstance(source, str):
            held[source] = held.get(source, 0.0) + columns[:, k]
        else:
            fixed += columns[:, k] * (source - machine.reference)
    return held, fixed


def _without(filter_: FilterModel, runs: Sequence[Trajectory], channels: Sequence[str] | None) -> FilterModel:
    """The filter of a control that lacks some inputs: they stay at their mean over the runs."""
    lacking = [name for name in filter_.inputs if channels is not None and name not in channels]
    constant = filter_.constant.copy()
    for name in lacking:
        seen = [run.inputs[name] for run in runs if name in run.inputs]
        at = unit(filter_.inputs[name]).from_si(float(np.mean(np.concatenate(seen))) if seen else 0.0)
        if name in filter_.held:
            constant += filter_.held[name] * (at - filter_.reference)
        constant += sum((table.at(at) for table in filter_.tables if table.name == name), 0 * constant)
    return replace(
        filter_, constant=constant, inputs={n: u for n, u in filter_.inputs.items() if n not in lacking},
        held={n: c for n, c in filter_.held.items() if n not in lacking},
        tables=tuple(t for t in filter_.tables if t.name not in lacking),
    )  # fmt: skip


def sample_inputs(filter_: FilterModel, schedule: Schedule) -> tuple[Array, dict[str, Array]]:
    """Instants of the filter's steps over a schedule, and its inputs there, in their units."""
    t = np.arange(schedule.t[0], schedule.t[-1] + filter_.step / 2, filter_.step)
    at = {name: schedule.signals[name].at(t) for name in filter_.inputs}
    return t, {name: in_own_unit(at[name], text) for name, text in filter_.inputs.items()}


def _lose(model: LinearModel, filter_: FilterModel, run: Trajectory, reduced: Reduction) -> Loss:
    """The filter without sensors beside the full model, from the same start."""
    pieces = [_lose_piece(model, filter_, piece, reduced) for piece in run.pieces or (run,)]
    worst = {axis: max(piece.by_axis[axis] for piece in pieces) for axis in filter_.axes}
    return replace(max(pieces, key=lambda piece: len(piece.t)), run=run.schedule.name, by_axis=worst)


def _lose_piece(model: LinearModel, filter_: FilterModel, run: Trajectory, reduced: Reduction) -> Loss:
    t, inputs = sample_inputs(filter_, schedule_for(model.machine, run.schedule))
    z = reduced.project @ ((run.T_start - model.point)[model.network.free] * _uniform(model))
    z = _pad(z, filter_.states - filter_.own)
    told, _ = filter_.run(inputs, np.full((len(t), len(filter_.sensors)), np.nan), z)
    ours = {axis: told[:, k] * unit(axis_unit(axis)).scale for k, axis in enumerate(filter_.axes)}
    full = {axis: np.interp(t, run.t, run.tcp[axis]) for axis in filter_.axes}
    lost = {axis: float(np.abs(ours[axis] - full[axis]).max()) for axis in filter_.axes}
    return Loss(run.schedule.name, lost, t, full, ours)


def _largest(losses: Sequence[Loss]) -> float:
    return max((value for loss in losses for value in loss.by_axis.values()), default=0.0)


def _unseen(machine: Machine) -> float:
    """Half the noise of the finest displacement channel [m]."""
    noise = [sensor.sigma for sensor in machine.sensors.values() if sensor.axis is not None]
    return min(noise, default=2 * UNSEEN) / 2


def _tell_all_kept(machine: Machine, by_states: Mapping[int, float], most: int, step: float) -> list[str]:
    """Why no state is left out, where none is."""
    if not by_states or max(by_states) < most:
        return []
    limit = f"{1e6 * _unseen(machine):.2g} µm (half the noise of the finest displacement channel)"
    lost = by_states[most]
    if lost > _unseen(machine):
        few = min(n for n, each in by_states.items() if each <= HARDLY * lost)
        enough = f" `--states {few}` loses hardly more." if few < most else ""
        why = f"that is lost by the step of {step:g} s and by what is not linear.{enough}"
        return [f"Even with no state left out {1e6 * lost:.3g} µm are lost, more than {limit}: {why}"]
    if most - 1 not in by_states:
        return []
    fewer = f"one fewer would lose {1e6 * by_states[most - 1]:.3g} µm, more than {limit}"
    return [f"No state can be left out: {fewer}. `--states N` takes fewer all the same."]


def _notes(machine: Machine, sensors: Sequence[str], channels: Sequence[str] | None) -> list[str]:
    left = [n for n, s in machine.sensors.items() if s.place is not None and n not in sensors]
    lacking = [n for n in machine.drives if channels is not None and n not in channels]
    notes = [f"Not read, for they tell more than the truth: {', '.join(left)}."] if left and channels is None else []
    return notes + ([f"Without {', '.join(lacking)}: held at the mean over the runs."] if lacking else [])
