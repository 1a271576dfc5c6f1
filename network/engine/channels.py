"""Readouts: which scalars a run must deliver from the lumps' temperatures, and how channels are made of them.

Base readings are rows over all lumps: part means, what expansions read, what temperature sensors see. Displacements
and sensor effects are computed from them pointwise; a sensor's own state (lag) is integrated with the network.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import Place
from network.catalogue.sensors.sensor import Sensor
from network.engine.network import Network
from network.engine.solvers.courses import Courses, LazyCourses

Key: TypeAlias = tuple[str, ...]


@dataclass(frozen=True)
class Readouts:
    """What is wanted: each key is one of the rows over all lumps, plus an offset.

    rows: different ones only, for a part of one lump is all its places; where: key → (its row, its offset). Keys:
    ('part', node), ('state', path), ('reading', axis, entry, i), ('sensor', name). States of sensor effects, in the
    order of `state_of`: dz/dt = state_T @ T + state_z @ z + state_constant.
    """

    rows: Array
    where: Mapping[Key, tuple[int, float]]
    state_of: tuple[tuple[str, int], ...]
    state_T: Array
    state_z: Array
    state_constant: Array

    @property
    def own_rows(self) -> Array:
        """Rows that somebody reads: all but those that are only the mean of a part; those of the states of sensors."""
        read = sorted({row for key, (row, _) in self.where.items() if key[0] != "part"})
        return np.vstack([self.rows[read] if self.where else self.rows, self.state_T])

    @property
    def states(self) -> int:
        return len(self.state_of)

    @property
    def width(self) -> int:
        """Rows and states: what a solver delivers at every instant."""
        return len(self.rows) + self.states

    def split_by_key(self, y: Array | Courses) -> Mapping[Key, Array]:
        """Readings by key, from what a solver delivered (width × instants), each when it is asked for."""
        return LazyCourses({key: partial(_read, y, *at) for key, at in self.where.items()})

    def read(self, key: Key, y: Array) -> Array:
        """One reading, from what a solver delivered (width × instants)."""
        return _read(y, *self.where[key])

    def start_states(self, T: Array) -> Array:
        """Sensor states in equilibrium: the solution of dz/dt = 0."""
        return np.asarray(np.linalg.solve(self.state_z, -(self.state_T @ T + self.state_constant)))


def _read(y: Array | Courses, row: int, offset: float) -> Array:
    return np.asarray(y[row] + offset if offset else y[row])


def plain_readouts(rows: Array) -> Readouts:
    """Nothing but rows over all lumps."""
    N = rows.shape[1]
    return Readouts(rows, {}, (), np.zeros((0, N)), np.zeros((0, 0)), np.zeros(0))


def readouts(network: Network, parts: bool = True) -> Readouts:
    """All base readings of a machine; `parts`: the mean temperature of every part, and every state, too."""
    machine = network.machine
    reference = machine.reference
    rows: list[tuple[Key, Array, float]] = []
    if parts:
        rows += [(("part", name), network.row(Place(name)), 0.0) for name in machine.nodes]
        rows += [(("state", name), network.row(Place(name)), 0.0) for name in network.states]
    for (axis, name), entry in machine.expansions.items():
        for i, reading in enumerate(entry.readings()):
            if reading.how != "heat":
                row = network.reading_row(reading)
                rows.append((("reading", axis, name, str(i)), row, -reference * float(row.sum())))
    for name, sensor in machine.sensors.items():
        if sensor.place is not None:
            rows.append((("sensor", name), network.row(sensor.place), 0.0))
    state_of, state_T, state_z, constant = _states(network)
    places: dict[bytes, int] = {}
    where = {key: (places.setdefault(row.tobytes(), len(places)), shift) for key, row, shift in rows}
    different = np.frombuffer(b"".join(places)).reshape(len(places), network.size)
    return Readouts(different, where, state_of, state_T, state_z, constant)


def stateful(network: Network) -> Iterator[tuple[str, Sensor]]:
    """Temperature sensors with an effect that keeps a state of its own."""
    for name, sensor in network.machine.sensors.items():
        if sensor.place is not None and any(effect.has_state for effect in sensor.effects):
            yield name, sensor


def states_of(network: Network) -> list[tuple[str, int]]:
    """Sensor and index of every effect that keeps a state."""
    return [(name, i) for name, s in stateful(network) for i, e in enumerate(s.effects) if e.has_state]


def _states(network: Network) -> tuple[tuple[tuple[str, int], ...], Array, Array, Array]:
    """Each sensor's chain of effects, as far as it is steady: an affine function of temperatures and states."""
    order = states_of(network)
    index = {key: k for k, key in enumerate(order)}
    nz = len(order)
    state_T, state_z, constant = np.zeros((nz, network.size)), np.zeros((nz, nz)), np.zeros(nz)
    one, zero = np.ones(()), np.zeros(())
    for name, sensor in stateful(network):
        assert sensor.place is not None
        row, z_row, shift = network.row(sensor.place), np.zeros(nz), 0.0
        for i, effect in enumerate(sensor.effects):
            if not effect.is_steady:
                break
            k = index.get((name, i))
            unit_z = np.eye(nz)[k] if k is not None else np.zeros(nz)
            if k is not None:
                at_zero = effect.rate(zero, zero)
                by_truth, by_state = effect.rate(one, zero) - at_zero, effect.rate(zero, one) - at_zero
                state_T[k], state_z[k] = by_truth * row, by_truth * z_row + by_state * unit_z
                constant[k] = at_zero + by_truth * shift
            at_zero = effect.reading(zero, zero, {})
            by_truth, by_state = effect.reading(one, zero, {}) - at_zero, effect.reading(zero, one, {}) - at_zero
            row, z_row, shift = by_truth * row, by_truth * z_row + by_state * unit_z, float(at_zero + by_truth * shift)
    return tuple(order), state_T, state_z, constant
