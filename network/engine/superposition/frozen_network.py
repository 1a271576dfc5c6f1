"""Networks that are not linear: each cause alone, in the network as it was along the run.

Along a run every heat flow is Q = G(t) (T_a − T_b) with G(t) = Q/(T_a − T_b) as it was, every source gave the heat
that it gave, and a part that melts had the heat capacity dH/dT. With these G, heats and capacities held the balance is
linear with coefficients that change in time, so the answers to all causes add up to the run. It says what each cause
brought in this machine as it ran, not what would be missing without it: a colder part would have radiated less.
Integrated by Radau IIA of order 3, which serves massless junctions (Hairer & Wanner, Solving ODEs II, table IV.5.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.balance import relay_slices, source_heat
from network.engine.energy import sum_stored_heat
from network.engine.entry_groups import Flows
from network.engine.network import Network
from network.engine.superposition.causes import Cause

STAGES = 1 / 3, 1.0
RADAU = np.array([[5 / 12, -1 / 12], [3 / 4, 1 / 4]])
FULL = 60
"""Lumps up to which matrices are kept with their zeros."""
TOO_CLOSE = 1e-6
"""K: temperatures so close tell no conductance; the slope of the law does."""


@dataclass(frozen=True)
class FrozenRun:
    """A run at the ends and stages of its steps.

    edges: S+1 ends of steps; T: temperatures of all lumps at the first edge, then at two stages of every step, the
    second a hair before its end (2 S + 1, N); u: inputs there (2 S + 1, 1); modes: of the relays there.
    """

    network: Network
    edges: Array
    T: Array
    u: Inputs
    modes: Array

    @cached_property
    def inner(self) -> Indices:
        """Lumps whose temperatures follow: parts and junctions."""
        return np.flatnonzero(np.isfinite(self.network.capacity) & ~self.network.is_state)

    @cached_property
    def conductances(self) -> tuple[Array, Indices]:
        """Of every elementary flow G (instants, flows), and where it stands in the flattened matrix, (4, flows)."""
        N, groups = self.network.size, self.network.flows
        if not groups:
            return np.zeros((len(self.T), 0)), np.zeros((4, 0), np.intp)
        G = np.concatenate([self._conductance(flows) for flows in groups], axis=1)
        a, b = (np.concatenate([getattr(flows, side) for flows in groups]) for side in ("a", "b"))
        return G, np.stack([b * N + a, b * N + b, a * N + b, a * N + a])

    @cached_property
    def gives(self) -> Array:
        """1 for a flow that its first lump loses, 0 for a stream."""
        return np.concatenate(
            [np.empty(0), *(np.full(len(flows.a), float(not flows.one_way)) for flows in self.network.flows)]
        )

    def _conductance(self, flows: Flows) -> Array:
        gap = self.T[:, flows.a] - self.T[:, flows.b]
        Q = flows.heat_flow(self.T, self.u)
        by_a, by_b, *_ = flows.slopes(self.T, self.u)
        near = np.abs(gap) < TOO_CLOSE
        G = np.where(near, (by_a - by_b) / 2, Q / np.where(near, 1.0, gap))
        return np.asarray(flows.w * (G if flows.relay is None else G * self.modes[:, flows.relay]))

    def matrix(self, m: int) -> Any:
        """K [W/K] at an instant: heat into the lumps is K T and what the sources give. Large: without zeros."""
        G, where = self.conductances
        signs = np.stack([np.ones_like(self.gives), -np.ones_like(self.gives), self.gives, -self.gives])
        N, values = self.network.size, (signs * G[m]).ravel()
        if N > FULL:
            from scipy.sparse import csr_matrix

            return csr_matrix((values, divmod(where.ravel(), N)), (N, N))
        return np.asarray(np.bincount(where.ravel(), values, N * N).reshape(N, N), np.float64)

    @cached_property
    def heats(self) -> list[Array]:
        """What every source gave, by group (heats, then relays): (instants, sources)."""
        plain = [source_heat(heats, self.T, self.u) for heats in self.network.heats]
        parts = relay_slices(self.network)
        return plain + [source_heat(relays, self.T, self.u, self.modes[:, part]) for relays, part in parts]

    @cached_property
    def capacities(self) -> Array:
        """Of the lumps in `inner` in every step [J/K]: what melts by the heat it took and how far it warmed."""
        capacity = np.tile(self.network.capacity[self.inner], (len(self.edges) - 1, 1))
        if self.network.melting:
            ends = self.T[::2][:, self.inner]
            heat = sum_stored_heat(self.network, self.T[::2])[:, self.inner]
            warmed, took = np.diff(ends, axis=0), np.diff(heat, axis=0)
            moved = np.abs(warmed) > TOO_CLOSE
            capacity = np.where(moved, took / np.where(moved, warmed, 1.0), capacity)
        return capacity


def answer_frozen(run: FrozenRun, causes: Sequence[Cause], rows: Array, base: float) -> Array:
    """Rises over `base` [°C] that each cause brings to rows over all lumps, (edges, rows, N), at the edges:
    (causes, rows, edges)."""
    network, inner = run.network, run.inner
    held = _held_rises(run, causes, base)
    rise = np.zeros((network.size, len(causes)))
    rise[inner, next(i for i, cause in enumerate(causes) if cause.is_start)] = run.T[0, inner] - base
    rise[network.bound] = held[0]
    _settle_junctions(run, causes, rise)
    answer = np.empty((len(causes), rows.shape[1], len(run.edges)))
    answer[:, :, 0] = (rows[0] @ rise).T
    for k, h in enumerate(np.diff(run.edges)):
        stages = []
        for m in (2 * k + 1, 2 * k + 2):
            K = run.matrix(m)
            from_held = K[inner][:, network.bound] @ held[m]
            stages.append((K[inner][:, inner], from_held + _source_heat(run, causes, m)[inner]))
        rise[inner] = _step(run.capacities[k], h, stages, rise[inner])
        rise[network.bound] = held[2 * k + 2]
        answer[:, :, k + 1] = (rows[k + 1] @ rise).T
    return answer


def _held_rises(run: FrozenRun, causes: Sequence[Cause], base: float) -> Array:
    """Of the held nodes, each with its own cause: (instants, held, causes)."""
    rises = np.zeros((len(run.T), len(run.network.bound), len(causes)))
    for i, cause in enumerate(causes):
        if cause.held is not None:
            rises[:, cause.held, i] = run.T[:, run.network.bound[cause.held]] - base
    return rises


def _source_heat(run: FrozenRun, causes: Sequence[Cause], m: int) -> Array:
    """Heat into all lumps from the sources at an instant [W], by cause: (N, causes)."""
    groups = (*run.network.heats, *run.network.relays)
    heat = np.zeros((run.network.size, len(causes)))
    for i, cause in enumerate(causes):
        if cause.source is not None:
            group, column = cause.source
            heat[:, i] = groups[group].into[:, column] * run.heats[group][m, column]
    return heat


def _settle_junctions(run: FrozenRun, causes: Sequence[Cause], rise: Array) -> None:
    """Puts massless junctions where no heat stays in them at the start."""
    massless, K = run.network.massless, run.matrix(0)
    if len(massless):
        others = np.flatnonzero(run.network.capacity > 0)
        given = K[massless][:, others] @ rise[others] + _source_heat(run, causes, 0)[massless]
        inner = K[massless][:, massless]
        rise[massless] = -np.linalg.solve(inner if isinstance(inner, np.ndarray) else inner.toarray(), given)


def _step(capacity: Array, h: float, stages: Sequence[tuple[Any, Array]], rise: Array) -> Array:
    """One step of Radau IIA: C (Y_i − x) = h Σ a_ij (K_j Y_j + q_j); the second stage is its end."""
    n = len(capacity)
    right = np.concatenate(
        [capacity[:, None] * rise + h * sum(RADAU[i, j] * stages[j][1] for j in (0, 1)) for i in (0, 1)]
    )
    blocks = [[-h * RADAU[i, j] * stages[j][0] for j in (0, 1)] for i in (0, 1)]
    held = np.concatenate([capacity, capacity])
    if isinstance(stages[0][0], np.ndarray):
        A = np.block(blocks)
        A[np.arange(2 * n), np.arange(2 * n)] += held
        return np.asarray(np.linalg.solve(A, right)[n:])
    from scipy.sparse import bmat, diags
    from scipy.sparse.linalg import splu

    return np.asarray(splu((bmat(blocks) + diags(held)).tocsc()).solve(right)[n:])
