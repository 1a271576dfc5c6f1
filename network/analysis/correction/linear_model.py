"""A machine as a linear model about a point: rises of its lumps, the heats that drive them, what is read and moved.

dz/dt = A z + F_held ΔT_held + F_heat q and y = C z + D_held ΔT_held + D_heat q + shift, with z the rises of the free
lumps over the point. A linear network is exact about its reference; others are linearised about the mean temperatures
and inputs of the runs given, but for conductances that an input drives; what that costs is told with the loss.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.correction.driven_films import DrivenFilms, list_films
from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.expansions.base import Expansion
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.assembly import build
from network.engine.balance import flow_heat, jacobian, source_heat
from network.engine.channels import plain_readouts
from network.engine.network import Network
from network.engine.solvers.elimination import regime_from
from network.engine.trajectory import Trajectory
from network.machine.machine import Machine
from network.platform.printing import Brief
from network.platform.refusal import Complaints, Spot


@dataclass(frozen=True, eq=False, repr=False)
class LinearModel(Brief):
    """network; point: temperatures of all lumps [°C]; u: inputs there (SI); axes, sensors: what y holds, in that order,
    and then the differences that drive the films;
    A (n, n); F_held (n, held), F_heat (n, N); C (m, n), D_held, D_heat; rest: heat into every lump at the point without
    the sources [W]; shift: y there."""

    network: Network
    point: Array
    u: Inputs
    axes: tuple[str, ...]
    sensors: tuple[str, ...]
    A: Array
    F_held: Array
    F_heat: Array
    C: Array
    D_held: Array
    D_heat: Array
    rest: Array
    shift: Array
    films: tuple[DrivenFilms, ...]

    @property
    def machine(self) -> Machine:
        return self.network.machine


def linearise(machine: Machine, runs: Sequence[Trajectory], sensors: Sequence[str]) -> LinearModel:
    """The model; sensors: the temperature channels that the control reads. Raises Refused for what no linear model can
    be made of, with every entry and what to do."""
    network = build(machine)
    _refuse_what_bends(network)
    u = {name: np.array(_mean([run.inputs[name] for run in runs if name in run.inputs])) for name in machine.inputs}
    u["time"] = np.array(0.0)
    point = _point(network, runs)
    films = tuple(list_films(network))
    rows, shift = _output_rows(network, point, u, sensors)
    rows = np.vstack([rows, *(film.differences for film in films)])
    shift = np.append(shift, np.zeros(len(rows) - len(shift)))
    K = jacobian(network, point, u, np.zeros(0))
    regime = regime_from(network, K, plain_readouts(rows))
    return LinearModel(
        network, point, u, tuple(machine.tcp), tuple(sensors), regime.A, regime.F_held, regime.F_heat, rows @ regime.P,
        rows @ regime.P_held, rows @ regime.P_heat, _rest(network, point, u), shift, films,
    )  # fmt: skip


def _mean(series: Sequence[Array]) -> float:
    return float(np.mean([values.mean() for values in series])) if series else 0.0


def _point(network: Network, runs: Sequence[Trajectory]) -> Array:
    """The reference for a linear network; else the mean temperatures of the runs, by part."""
    point = np.full(network.size, network.machine.reference)
    if network.is_affine() or not runs:
        return point
    for name, part in network.bodies.items():
        point[part] = _mean([run.parts[name] for run in runs if name in run.parts])
    return point


def _rest(network: Network, point: Array, u: Inputs) -> Array:
    """Heat into every lump at the point by links and streams [W], and by the states of entries."""
    into = np.zeros(network.size)
    for flows in network.flows:
        into += flow_heat(flows, point, u) @ flows.spread
    for rates in network.heats:
        if not rates.is_heat:
            into += rates.into @ source_heat(rates, point, u)
    return into


def _output_rows(network: Network, point: Array, u: Inputs, sensors: Sequence[str]) -> tuple[Array, Array]:
    """Rows of y over the rises of all lumps, and y at the point: axes, then sensors."""
    machine, capacity = network.machine, network.heat_capacity
    rows, shift = [], []
    for axis in machine.tcp:
        row, at = np.zeros(network.size), 0.0
        for entry in (e for (a, _), e in machine.expansions.items() if a == axis):
            own = [network.heat_row(r.place) * capacity if r.how == "heat" else network.reading_row(r)
                   for r in entry.readings()]  # fmt: skip
            readings = [np.array(float(r @ (point - machine.reference))) for r in own]
            row = row + sum((float(s) * r for s, r in zip(entry.slopes(u, *readings), own, strict=True)), 0 * row)
            at += float(entry.movement(u, *readings)) if readings else 0.0
        rows.append(row)
        shift.append(at)
    for name in sensors:
        place = machine.sensors[name].place
        assert place is not None
        rows.append(network.row(place))
        shift.append(float(rows[-1] @ point))
    return np.array(rows).reshape(-1, network.size), np.array(shift)


def moves_at_once(entry: Expansion) -> bool:
    """Whether it moves by inputs alone."""
    return not entry.readings()


def _refuse_what_bends(network: Network) -> None:
    complaints, machine = Complaints(), network.machine
    for name in network.melting:
        melts = machine.nodes[name].melts is not None
        right = "give it the heat capacity that it has while it does not melt"
        right = right if melts else "leave its material's specific_heat_slope out"
        wrong = f"{network.tell_melting(name)}, which no linear model does"
        complaints.refuse(machine.nodes[name].spot_of("melts"), wrong, right)
    for relays in network.relays:
        right = "replace it, say by a heat_source of its mean power or a node held at the temperature that it keeps"
        _refuse_entries(network, relays.entry, "switches, which no linear model does", right, complaints)
    for group in network.groups:
        if group.law.follows_time or len(group.law.edges(1e9)):
            wrong, right = "follows the clock, which a control does not share", "replace it by what follows an input"
            _refuse_entries(network, group.entry, wrong, right, complaints)
    for (axis, name), expansion in machine.expansions.items():
        if expansion.needs() and not moves_at_once(expansion):
            wrong = f"tcp.{axis}.{name} grows as far as {', '.join(expansion.needs())} says"
            complaints.refuse(expansion.spot, wrong, "give the place for which to correct, as in `at: 300 mm`")
    if not machine.tcp:
        complaints.refuse(Spot(machine.file), "moves no tool centre point, so there is nothing to correct", "add `tcp`")
    complaints.raise_if_any()


def _refuse_entries(network: Network, entries: Indices, wrong: str, right: str, complaints: Complaints) -> None:
    for path in sorted({network.mechanisms[i] for i in entries.tolist()}):
        section, _, name = path.partition(".")
        entry = getattr(network.machine, section)[name]
        complaints.refuse(entry.spot, f"{path} {wrong}", right)
