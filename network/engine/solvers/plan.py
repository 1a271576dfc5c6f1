"""The plan of a run: where integration restarts, what the inputs are in between, which solver, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.mechanism import Inputs, Mechanism
from network.engine.network import Network
from network.recordings.inputs import Schedule

SAME_INSTANT = 1e-9
"""s: input changes closer together than this are one."""
HAIR = 1e-6
"""s: how far inside an interval the clock is read at its ends."""
OF_INPUTS = ("just_inside", "ramped", "steps", "step_lengths")
"""What a plan works out from its inputs and instants alone."""


@dataclass(frozen=True)
class Plan:
    """Intervals between input changes; within each, every input runs straight from `left` to `right`.

    t: instants of output [s]; edges: K+1 instants, the first is the start, the last the end; left, right: input →
    K values just after and just before the edges of each interval, SI; `time` is among them; T0: temperatures of all
    lumps at the start [°C]; modes: of the relays (0 off, 1 on) in each interval, (K, relays), once they are known;
    about: temperatures of all lumps (N) at which laws that are not straight are replaced by their tangents, where they
    have to be, by default the reference.
    """

    network: Network
    t: Array
    edges: Array
    left: Mapping[str, Array]
    right: Mapping[str, Array]
    T0: Array
    method: str
    why: str
    modes: Array | None = None
    about: Array | None = None

    def with_network(self, network: Network, T0: Array) -> Plan:
        """The same with other numbers and another start; what was found of its inputs and instants stays known."""
        plan = replace(self, network=network, T0=T0)
        plan.__dict__.update({name: getattr(self, name) for name in OF_INPUTS})
        return plan

    def inputs_in(self, k: int, t: float) -> Inputs:
        """Inputs at t within interval k."""
        share = (t - self.edges[k]) / (self.edges[k + 1] - self.edges[k])
        return {name: self.left[name][k] + share * (self.right[name][k] - self.left[name][k]) for name in self.left}

    @cached_property
    def just_inside(self) -> tuple[dict[str, Array], dict[str, Array]]:
        """Inputs (K, 1) a hair after the begin and before the end of every interval: what starts with a ramp is on."""
        return self._inside(1e-12), self._inside(1 - 1e-12)

    def _inside(self, share: float) -> dict[str, Array]:
        return {name: (a + share * (self.right[name] - a))[:, None] for name, a in self.left.items()}

    def evaluate_held(self, values: Mapping[str, Array]) -> Array:
        """Temperatures of the held lumps [°C] for inputs of shape (K,): (K, held)."""
        held, count = self.network.held, len(values["time"])
        columns = [held[int(i)].at(values) for i in self.network.bound]
        return np.stack(columns, axis=1) if columns else np.zeros((count, 0))

    @cached_property
    def ramped(self) -> frozenset[str]:
        """Inputs that change within some interval; `time`, which always does, is not among them."""
        held = (n for n, a in self.left.items() if a is self.right[n] or np.array_equal(a, self.right[n]))
        return frozenset(self.left) - {"time", *held}

    def is_ramped(self, law: Mechanism) -> bool:
        """Whether what it gives changes within some interval, at given temperatures."""
        return law.follows_time or not self.ramped.isdisjoint(law.needs())

    @cached_property
    def steps(self) -> Array:
        return np.diff(self.edges)

    @cached_property
    def step_lengths(self) -> tuple[Array, Indices]:
        """Their different lengths [s], and which of them each has."""
        lengths, of_step = np.unique(np.round(self.steps, 9), return_inverse=True)
        return lengths, of_step

    @cached_property
    def bounds(self) -> Indices:
        """K+1 indices: interval k has the instants of output t[bounds[k]:bounds[k + 1]]; at an edge the one after."""
        bounds = np.searchsorted(self.t, self.edges - SAME_INSTANT)
        bounds[0], bounds[-1] = 0, len(self.t)
        return bounds

    @cached_property
    def interval_of(self) -> Indices:
        """The interval in which each instant of output lies."""
        return np.repeat(np.arange(len(self.steps)), np.diff(self.bounds))

    @cached_property
    def spacing(self) -> float:
        """Distance of the instants of output where it is even, else 0."""
        gaps = np.diff(self.t)
        return float(gaps[0]) if np.ptp(gaps) < 1e-9 * gaps[0] else 0.0

    def inputs_at_samples(self) -> dict[str, Array]:
        """Every input at the instants of output."""
        share = (self.t - np.repeat(self.edges[:-1], np.diff(self.bounds))) / np.repeat(
            self.steps, np.diff(self.bounds)
        )
        return {name: self._sample(name, share) for name in self.left}

    def _sample(self, name: str, share: Array) -> Array:
        counts, left, right = np.diff(self.bounds), self.left[name], self.right[name]
        first = np.repeat(left, counts)
        return (
            first if left is right or np.array_equal(left, right) else first + share * np.repeat(right - left, counts)
        )


def interval_edges(network: Network, schedule: Schedule) -> Array:
    """Start, end, and every instant in between at which an input or a timer changes."""
    start, end = float(schedule.t[0]), float(schedule.t[-1])
    changes = [signal.t for signal in schedule.signals.values()]
    changes += list_own_edges(network, end)
    inner = np.unique(np.concatenate([np.ravel(c) for c in changes])) if changes else np.empty(0)
    inner = inner[(inner > start + SAME_INSTANT) & (inner < end - SAME_INSTANT)]
    if len(inner):
        inner = inner[np.append(True, np.diff(inner) > SAME_INSTANT)]
    return np.concatenate([[start], inner, [end]])


def list_own_edges(network: Network, duration: float) -> list[Array]:
    """Instants at which the laws of a network, and what holds its nodes, jump or bend by themselves."""
    laws = [group.law.edges(duration) for group in network.groups]
    return laws + [held.edges(duration) for held in network.held.values()]


def merge_instants(edges: Array, instants: Array) -> Array:
    """Both, with instants that lie on an edge only once."""
    gap = np.abs(edges[np.clip(np.searchsorted(edges, instants), 0, len(edges) - 1)] - instants)
    below = np.abs(edges[np.clip(np.searchsorted(edges, instants) - 1, 0, None)] - instants)
    return np.unique(np.concatenate([edges, instants[np.minimum(gap, below) > SAME_INSTANT]]))


def spans(schedule: Schedule, edges: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Input values just after and just before the edges of every interval; `time` a hair inside, so that a timer that
    switches at an edge is on the right side of it whatever the rounding."""
    hair = np.minimum(HAIR, 1e-3 * np.diff(edges))
    left: dict[str, Array] = {"time": edges[:-1] + hair}
    right: dict[str, Array] = {"time": edges[1:] - hair}
    for name, signal in schedule.signals.items():
        left[name], right[name] = signal.span(edges[:-1], edges[1:])
    return left, right
