"""Level 0 of a sweep: the closed form of the heat-quantity paper, computed from the machine instead of fitted.

The spindle unit is one lump (eq. 12–15): C₁ dT̄/dt = q_all − K′S (T̄ − T₀) − G_beam (T̄ − T_beam), so that between
changes of the inputs T̄ = d e^(−t/τ) + f with τ = C₁/(K′S + G_beam). The paper prints e^(−t): its time constant is
dropped there, measured later as 3400 s (eq. 24), and the e^(+t/3400) of eq. 25 is a misprint of the same.

Along an axis that only the unit moves, δ = α₁ L ΔT₁ with ΔT₁ = (T_s + T̄)/2 − T_ref (eq. 16): δ = i e^(−t/τ) + j
(eq. 18). T_s, the temperature next to the inner heat source, stands at its steady value at once: the paper does so in
eq. 17 and, with all of ΔT₁, in eq. 23, for a spindle that runs, and nowhere else. So the form jumps when a run begins,
and its first minutes do not fit. T_s is the mean of the parts inside the unit that sources heat, weighted by their
heat, in equilibrium with the beam as it was at the start. Where nothing but the spindle itself is heated, T_s is T̄.

Along an axis that the beam moves too, δ = α₂ L₂ Q_in2/C₂ + α₁ L₁ ΔT₁ (eq. 19–21) with q_in2 constant between changes
of the inputs, at its steady value, and ΔT₁ steady at once (eq. 22, 23): δ = k t + l. The beam integrates and loses
nothing. Over a schedule T̄ and Q_in2 are carried from step to step; where an input is ramped, all of them count with
their values in the middle of every sample. What else moves the tool centre point is named in `left_out`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.declaration.entry_path import EntryPath
from network.catalogue.declaration.sections import TCP
from network.catalogue.expansions.base import Expansion
from network.catalogue.expansions.stretching import Stretching
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.assembly import build
from network.engine.paper.spindle_unit import SpindleUnit
from network.engine.paper.steady_state import Settled, solve_steady_state
from network.engine.simulation import check_known, schedule_for
from network.engine.solvers.modal import scan
from network.engine.solvers.plan import SAME_INSTANT, interval_edges
from network.engine.start import start_temperatures
from network.machine.machine import Machine
from network.recordings.inputs import Schedule, Start
from network.recordings.recording import Recording
from network.recordings.scenario import Scenario


@dataclass(frozen=True)
class Law:
    """What holds between two changes of the inputs, t counted from `start` [s]: i e^(−t/τ) + j [m] on axes that the
    unit alone moves, k t + l [m/s, m] on those that the beam moves; q_in2: heat flow to the beam [W]."""

    start: float
    stop: float
    tau: float
    q_in2: float
    exponential: Mapping[str, tuple[float, float]]
    linear: Mapping[str, tuple[float, float]]

    def summary(self) -> dict[str, Any]:
        """In seconds, watts and micrometres."""
        tcp = {axis: {"i": i * 1e6, "j": j * 1e6} for axis, (i, j) in self.exponential.items()}
        tcp |= {axis: {"k": slope * 1e6, "l": at_start * 1e6} for axis, (slope, at_start) in self.linear.items()}
        return {"start": self.start, "stop": self.stop, "tau": self.tau, "q_in2": self.q_in2, "tcp": tcp}


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """tau: least and largest time constant [s]; jumps: whether T_s stands at its steady value anywhere; t [s]; T: T̄ of
    the unit [°C]; Q_in2: heat that the beam took up since the start [J]; tcp: axis → displacement [m]; laws: one
    between every two changes of the inputs, none where an input is ramped; left_out: entries that are no part of the
    form; simplified: entries that count otherwise than in the network, in words."""

    unit: SpindleUnit
    tau: tuple[float, float]
    jumps: bool
    t: Array
    T: Array
    Q_in2: Array
    tcp: Mapping[str, Array]
    laws: tuple[Law, ...]
    left_out: tuple[str, ...]
    simplified: tuple[str, ...]
    solve_seconds: float

    def summary(self) -> dict[str, Any]:
        """Its part of sweep.json."""
        return {
            "spindle": list(self.unit.parts), "beam": self.unit.beam,
            "heat_capacity": {"value": self.unit.heat_capacity, "unit": "J/K"}, "tau": self.tau,
            "laws": [law.summary() for law in self.laws], "left_out": self.left_out, "simplified": self.simplified,
        }  # fmt: skip


def closed_form(machine: Machine, source: Scenario | Recording | Schedule, start: Start | None = None) -> ClosedForm:
    """The paper's closed form along a schedule.

    Raises Refused for a machine that does not say which part is the spindle, or whose spindle loses heat to nothing.
    """
    check_known(machine)
    unit, network, schedule = SpindleUnit.of(machine), build(machine), schedule_for(machine, source, start)
    T0 = start_temperatures(network, schedule, source if isinstance(source, Recording) else None)
    first = {name: float(T0[network.parts[name]].mean()) for name in machine.nodes}
    began = time.perf_counter()
    changes = interval_edges(network, schedule)
    is_held = all(signal.is_held for signal in schedule.signals.values())
    course = _Course.of(unit, schedule, changes if is_held else _merge_instants(changes, schedule.t), first)
    T, Q, piece = course.at(schedule.t)
    tcp = course.tcp(T, Q, piece)
    seconds = time.perf_counter() - began
    laws = tuple(course.laws()) if is_held else ()
    goal, left_out, simplified = course.settled, tuple(_list_left_out(unit)), tuple(unit.list_linearised())
    tau, jumps = (float(goal.tau.min()), float(goal.tau.max())), bool(goal.inside.any())
    return ClosedForm(unit, tau, jumps, schedule.t, T, Q, tcp, laws, left_out, simplified, seconds)


def _merge_instants(changes: Array, samples: Array) -> Array:
    """All changes of the inputs and all samples, those that are one instant once."""
    edges = np.unique(np.concatenate([changes, samples]))
    return np.asarray(edges[np.append(True, np.diff(edges) > SAME_INSTANT)])


@dataclass(frozen=True, eq=False)
class _Course:
    """Pieces of time of constant inputs. T, Q: T̄ and Q_in2 at their beginnings; beam: its temperature at the start."""

    unit: SpindleUnit
    edges: Array
    settled: Settled
    T: Array
    Q: Array
    beam: float

    @classmethod
    def of(cls, unit: SpindleUnit, schedule: Schedule, edges: Array, first: Mapping[str, float]) -> _Course:
        goal, steps = solve_steady_state(unit, schedule, edges, first), np.diff(edges)
        nodes = unit.machine.nodes
        T0 = sum(nodes[name].capacity * first[name] for name in unit.parts) / unit.heat_capacity
        push = -np.expm1(-steps / goal.tau) * goal.T
        T, _ = scan(np.exp(-steps / goal.tau)[:, None], push[:, None], np.array([T0]))
        Q = np.append(0.0, np.cumsum(goal.q_in2 * steps))[:-1]
        beam = first[unit.beam] if unit.beam is not None else unit.machine.reference
        return cls(unit, edges, goal, T[:, 0], Q, beam)

    def at(self, t: Array) -> tuple[Array, Array, Indices]:
        """T̄ (eq. 15), Q_in2 and the piece of time at instants; at a change the piece after it."""
        piece = np.clip(np.searchsorted(self.edges, t + SAME_INSTANT, side="right") - 1, 0, len(self.edges) - 2)
        goal, since = self.settled, t - self.edges[piece]
        T = goal.T[piece] + (self.T - goal.T)[piece] * np.exp(-since / goal.tau[piece])
        return T, self.Q[piece] + goal.q_in2[piece] * since, piece

    def tcp(self, T: Array, Q: Array, piece: Indices) -> dict[str, Array]:
        """Displacements [m] for T̄ = T and Q_in2 = Q in the given pieces of time."""
        machine, moved = self.unit.machine, dict[str, Array]()
        for axis, (mine, by_beam) in _moving(self.unit).items():
            now = self.settled.T[piece] if by_beam else T
            rise = self.settled.rise(now, piece, machine.reference)
            moved[axis] = sum((_grow_part(entry, rise) for entry in mine), np.zeros(len(T)))
            if self.unit.beam is not None:
                rise = self.beam - machine.reference + Q / machine.nodes[self.unit.beam].capacity
                moved[axis] += sum((_grow_part(entry, rise) for entry in by_beam), np.zeros(len(T)))
        return moved

    def laws(self) -> Iterator[Law]:
        """The constants of the form, piece by piece."""
        goal, every, moving = self.settled, np.arange(len(self.T)), _moving(self.unit)
        begin, end = self.tcp(self.T, self.Q, every), self.tcp(goal.T, self.Q, every)
        later = self.tcp(self.T, self.Q + goal.q_in2, every)
        for n in every.tolist():
            i_j = {a: (float((begin[a] - end[a])[n]), float(end[a][n])) for a, (_, beam) in moving.items() if not beam}
            k_l = {a: (float((later[a] - begin[a])[n]), float(begin[a][n])) for a, (_, beam) in moving.items() if beam}
            start, stop = (float(edge) for edge in self.edges[n : n + 2])
            yield Law(start, stop, float(goal.tau[n]), float(goal.q_in2[n]), i_j, k_l)


def _grow_part(entry: Stretching, rise: Array) -> Array:
    """α L ΔT of a part at one temperature, by the entry's own length, expansion and direction."""
    return np.asarray(entry.movement({}, rise * entry.capacity if entry.method == "heat" else rise))


def _part(unit: SpindleUnit, entry: Expansion) -> str:
    """The part that an entry of the form stretches; empty for what is no part of the form."""
    node = entry.of.node if isinstance(entry, Stretching) and not entry.needs() else ""
    return node if node in (*unit.parts, unit.beam) else ""


def _moving(unit: SpindleUnit) -> dict[str, tuple[list[Stretching], list[Stretching]]]:
    """Axis → entries on the unit and entries on the beam, for every axis that the form moves."""
    found: dict[str, tuple[list[Stretching], list[Stretching]]] = {}
    for (axis, _), entry in unit.machine.expansions.items():
        if isinstance(entry, Stretching) and (part := _part(unit, entry)):
            found.setdefault(axis, ([], []))[part == unit.beam].append(entry)
    return found


def _list_left_out(unit: SpindleUnit) -> Iterator[str]:
    for (axis, name), entry in unit.machine.expansions.items():
        if not _part(unit, entry):
            yield str(EntryPath(TCP, axis, name))
    for name, source in unit.machine.sources.items():
        if isinstance(source, Relay):
            yield f"sources.{name}"
    for name, link in unit.machine.links.items():
        if isinstance(link, Relay):
            yield f"links.{name}"
