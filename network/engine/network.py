"""Network: the machine as arrays. Lumps in a fixed order, flows grouped by class, places as weights over lumps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.catalogue.declaration.fields import Place
from network.catalogue.drift import Drift
from network.catalogue.expansions.base import Reading
from network.catalogue.mechanisms.mechanism import Inputs, Mechanism, Relay
from network.engine.entry_groups import Flows, Heats
from network.machine.lumps import weights
from network.machine.machine import Machine
from network.platform.printing import Brief


@dataclass(frozen=True)
class Held:
    """A temperature that is given: the name of an input or a constant [°C], and how it drifts from that."""

    source: str | float
    drift: Drift | None = None

    def at(self, u: Inputs) -> Array:
        """°C, at inputs of any shape."""
        given = u[self.source] if isinstance(self.source, str) else np.full(np.shape(u["time"]), self.source)
        return given if self.drift is None else given + self.drift.at(u["time"])

    def edges(self, duration: float) -> Array:
        """Instants at which it bends by itself."""
        return np.empty(0) if self.drift is None else self.drift.edges(duration)


@dataclass(frozen=True, repr=False)
class Network(Brief):
    """N lumps; capacity [J/K] is 0 for massless junctions and inf for held nodes.

    mechanisms: names as in the file, then the bars' inner conduction; parts: node → its lumps; held: lump → what holds
    it; states: lumps that stand for a state of an entry, by their names among the parts.
    """

    machine: Machine
    parts: Mapping[str, slice]
    capacity: Array
    held: Mapping[int, Held]
    mechanisms: tuple[str, ...]
    flows: tuple[Flows, ...]
    heats: tuple[Heats[Mechanism], ...]
    relays: tuple[Heats[Relay], ...]
    states: Mapping[str, int] = field(default_factory=dict)

    @property
    def size(self) -> int:
        return len(self.capacity)

    @cached_property
    def free(self) -> Indices:
        return np.flatnonzero((self.capacity > 0) & np.isfinite(self.capacity))

    @cached_property
    def massless(self) -> Indices:
        return np.flatnonzero(self.capacity == 0)

    @cached_property
    def bound(self) -> Indices:
        return np.flatnonzero(np.isinf(self.capacity))

    @cached_property
    def heat_capacity(self) -> Array:
        """Of every lump [J/K], 0 for held ones too."""
        return np.where(np.isfinite(self.capacity), self.capacity, 0.0)

    @property
    def relay_count(self) -> int:
        return sum(relays.into.shape[1] for relays in self.relays)

    @cached_property
    def bodies(self) -> Mapping[str, slice]:
        """The parts that hold heat: all but the states of entries."""
        return {name: part for name, part in self.parts.items() if name not in self.states}

    @cached_property
    def is_state(self) -> Mask:
        """Lumps that stand for a state."""
        return np.isin(np.arange(self.size), list(self.states.values()))

    @cached_property
    def groups(self) -> tuple[Flows | Heats[Mechanism] | Heats[Relay], ...]:
        return (*self.flows, *self.heats, *self.relays)

    @property
    def melting(self) -> list[str]:
        """Parts whose heat capacity is not constant: they melt, or their specific heat changes as they warm."""
        return [name for name, node in self.machine.nodes.items() if node.stored is not None]

    def tell_melting(self, name: str) -> str:
        """What keeps the heat capacity of one of `melting` from being constant, with its path."""
        stored = self.machine.nodes[name].stored
        return f"nodes.{name} {stored.manner if stored is not None else 'is constant'}"

    def is_affine(self) -> bool:
        """Heat flows are linear in temperatures, at given inputs and relay modes; capacities are constant."""
        return not self.melting and all(group.law.is_affine() for group in self.groups)

    def row(self, place: Place) -> Array:
        """Σ w_i T_i over a place, as a row over all lumps."""
        row = np.zeros(self.size)
        part = self.parts[place.node]
        row[part] = weights(place, part.stop - part.start)
        return row

    def reading_row(self, reading: Reading) -> Array:
        """A reading as a row over all lumps, applied to rises over the reference (mean, gradient)."""
        return self.row(reading.place) if reading.how == "mean" else self._gradient_row(reading.place)

    def _gradient_row(self, place: Place) -> Array:
        """Σ ΔT_i y_i w_i / Σ y_i² w_i, y the distance from the middle of the range: exact for linear profiles."""
        row, part = self.row(place), self.parts[place.node]
        lumps = part.stop - part.start
        length = float(self.machine.nodes[place.node].length)
        low, high = (
            np.maximum(np.arange(lumps) / lumps, place.start),
            np.minimum(np.arange(1, lumps + 1) / lumps, place.stop),
        )
        y = ((low + high) / 2 - (place.start + place.stop) / 2) * length
        moment = row[part] * y
        total = float((moment * y).sum())
        row[part] = moment / total if total > 0 else 0.0
        return row

    def heat_row(self, place: Place) -> Array:
        """Share of each lump's heat that counts to a range, as a row over all lumps."""
        row, part = np.zeros(self.size), self.parts[place.node]
        lumps = part.stop - part.start
        row[part] = weights(place, lumps) * max(place.share * lumps, 1.0 if place.share == 0 else 0.0)
        return row
