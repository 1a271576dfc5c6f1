"""How channels follow base readings: a matrix where it is the same at all instants, else slopes over time.

Displacements and most sensor effects are linear in the readings of their instant. A channel zeroed at its start also
loses what it read then; a displacement behind a lag, or a channel whose clock is shifted, depends on what went before
and has to be computed whole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array, Mask
from network.engine.channels import Readouts
from network.engine.observe import channel
from network.machine.machine import Machine

SMALL = 1e-4
"""K: by how much readings are moved."""
EVEN = 1e-6
"""Of the largest slope: changes along a run, or from run to run, that are rounding."""
AT_ONCE = 4_000_000
"""Numbers that are held at a time."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """matrix: (channels, width), or (channels, width, 2 K) where it changes in time; zeroed: channels that read zero at
    their start; is_straight: it does not depend on the readings either."""

    matrix: Array
    zeroed: Mask
    is_straight: bool

    @property
    def is_constant(self) -> bool:
        return self.matrix.ndim == 2

    @property
    def is_same(self) -> bool:
        """Whether it is the same at all instants and readings."""
        return self.is_constant and self.is_straight

    def equals(self, other: Slopes) -> bool:
        """Whether both are the same but for the rounding of the differences they come from."""
        if self.matrix.shape != other.matrix.shape or (self.zeroed != other.zeroed).any():
            return False
        return bool(
            np.abs(self.matrix - other.matrix).max(initial=0.0) <= EVEN * np.abs(self.matrix).max(initial=1e-12)
        )

    def __call__(self, answers: Array) -> Array:
        """Changes of channels (pushes, channels, 2 K) from those of base readings (pushes, width, 2 K)."""
        changes = self.matrix @ answers if self.is_constant else np.einsum("cwk,pwk->pck", self.matrix, answers)
        changes[:, self.zeroed] -= changes[:, self.zeroed, :1]
        return np.asarray(changes)


def channels_of(
    machine: Machine, outputs: Readouts, readings: Array, u: Mapping[str, Array], names: Sequence[str]
) -> Array:
    """Channels (names, instants) from base readings and sensor states (·, instants); of several courses at once (·, …,
    instants) where none is zeroed at its start or looks back."""
    rows, shape = outputs.split_by_key(readings), readings.shape[1:]
    tcp: dict[str, Array] = {}
    for axis, entries in machine.tcp.items():
        moved = np.zeros(shape)
        for name, entry in entries.items():
            read = [rows["reading", axis, name, str(i)] for i in range(len(entry.readings()))]
            moved = moved + entry.movement(u, *read)
        tcp[axis] = moved
    states = dict(zip(outputs.state_of, readings[len(outputs.rows) :], strict=True))
    return np.stack([channel(n, machine.sensors[n], rows, tcp, states, u) for n in names])


def slopes_of(
    machine: Machine, outputs: Readouts, readings: Array, u: Mapping[str, Array], names: Sequence[str]
) -> Slopes | None:
    """How channels follow the readings about what these are; None where one depends on those before its instant."""
    sensors = [machine.sensors[n] for n in names]
    if any(e.looks_back or (e.has_state and s.axis is not None) for s in sensors for e in s.effects):
        return None
    plain = replace(machine, sensors={n: s.replaced(zero=None) for n, s in zip(names, sensors, strict=True)})
    here, there = (_differentiate(plain, outputs, r, u, names) for r in (readings, readings + 1.0))
    straight = bool(np.abs(here - there).max(initial=0.0) <= 1e-5 * np.abs(here).max(initial=1e-12))
    constant = bool(np.ptp(here, axis=2).max(initial=0.0) <= EVEN * np.abs(here).max(initial=1e-12))
    zeroed = np.array([s.zero == "start" for s in sensors])
    return Slopes(here.mean(axis=2) if constant else here, zeroed, straight)


def see_readings_alone(machine: Machine, names: Sequence[str]) -> bool:
    """Whether channels follow the readings by the same law at every instant of every run, whatever drives it."""
    sensors = [machine.sensors[n] for n in names]
    entries = [entry for axis in machine.tcp.values() for entry in axis.values()]
    return not any(s.effects for s in sensors) and not any(e.needs() for e in (*sensors, *entries))


def _differentiate(
    machine: Machine, outputs: Readouts, readings: Array, u: Mapping[str, Array], names: Sequence[str]
) -> Array:  # fmt: skip
    """Channels' changes by one unit of each reading, (channels, width, instants)."""
    width, count = readings.shape
    at_once = max(1, AT_ONCE // (2 * width * count))
    blocks = [np.eye(width)[i : i + at_once] * SMALL for i in range(0, width, at_once)]
    columns = []
    along = {name: np.broadcast_to(values, count) for name, values in u.items()}
    for steps in blocks:
        moved = readings[:, None, None] + np.stack([steps.T, -steps.T], axis=1)[..., None]
        read = channels_of(machine, outputs, moved, along, names)
        columns.append((read[:, 0] - read[:, 1]) / (2 * SMALL))
    return np.concatenate(columns, axis=1)
