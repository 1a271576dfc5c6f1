"""What drives a linear network: held temperatures and heats of sources at the ends of every interval."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.balance import source_series, with_modes
from network.engine.solvers.plan import Plan


@dataclass(frozen=True)
class Forcing:
    """Per interval, just after and just before its edges: held temperatures, and heats of the sources group by group.

    into: how the heat of every group spreads over all lumps; lumped: heats of all lumps, where they are given so.
    """

    held: tuple[Array, Array]
    lumped: tuple[Array, Array] | None
    sources: tuple[tuple[Array, Array], ...]
    into: tuple[Array, ...] = ()

    @cached_property
    def heat(self) -> tuple[Array, Array]:
        """Heats of all lumps (K, N)."""
        return self.lumped or (self.push(0), self.push(1))

    def beside(self, first: Array, last: Array) -> Forcing:
        """The same with further heats of all lumps just after and just before the edges (K, N)."""
        if self.lumped is not None:
            return replace(self, lumped=(self.lumped[0] + first, self.lumped[1] + last))
        sources, into = (*self.sources, (first, last)), (*self.into, np.eye(first.shape[1]))
        return replace(self, sources=sources, into=into)

    def push(self, side: int, rows: Array | None = None, at: Indices | slice = slice(None)) -> Array:
        """Heats of all lumps, or rows over them, in some intervals: (intervals, lumps or rows)."""
        if self.lumped is not None:
            heat = self.lumped[side][at]
            return np.asarray(heat if rows is None else heat @ rows.T)
        size = self.into[0].shape[0] if self.into else 0
        total = np.zeros((len(self.held[side][at]), size if rows is None else len(rows)))
        for group, into in zip(self.sources, self.into, strict=True):
            total += group[side][at] @ (into if rows is None else rows @ into).T
        return total

    def push_both(self, rows: Array, at: Indices | slice) -> tuple[Array, Array]:
        """Rows over the heats of all lumps just after and just before the edges of some intervals; heat that holds
        within all intervals is worked out once."""
        if self.lumped is not None:
            return self.push(0, rows, at), self.push(1, rows, at)
        shape = len(self.held[0][at]), len(rows)
        first, last = np.zeros(shape), np.zeros(shape)
        for (begin, end), into in zip(self.sources, self.into, strict=True):
            by = (rows @ into).T
            heat = begin[at] @ by
            first += heat
            last += heat if end is begin else end[at] @ by
        return first, last


def force_sources(plan: Plan) -> Forcing:
    """What drives a plan, a hair inside its intervals, so that a source that starts with a ramp is on at once."""
    network, count = plan.network, len(plan.edges) - 1
    begin, end = plan.just_inside
    groups = [*network.heats, *network.relays]
    modes = plan.modes if plan.modes is not None else np.zeros(network.relay_count)
    first = [source_series(heats, begin, mode, count) for heats, mode in with_modes(network, modes)]
    last = [
        source_series(heats, end, mode, count) if plan.is_ramped(heats.law) else same
        for same, (heats, mode) in zip(first, with_modes(network, modes), strict=True)
    ]
    held = plan.evaluate_held(plan.left), plan.evaluate_held(plan.right)
    none = None if groups else (np.zeros((count, network.size)), np.zeros((count, network.size)))
    return Forcing(held, none, tuple(zip(first, last, strict=True)), tuple(heats.into for heats in groups))
