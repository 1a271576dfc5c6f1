"""Massless junctions eliminated exactly (Schur complement), held nodes as inputs: one regime of an affine network."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.channels import Readouts
from network.engine.network import Network
from network.platform.refusal import Failed


@dataclass(frozen=True)
class Regime:
    """One set of conductances. All lumps: T = P x + P_held T_held + P_heat q."""

    A: Array
    P: Array
    P_held: Array
    P_heat: Array
    F_held: Array
    F_heat: Array
    is_symmetric: bool
    K: Array

    def drive(self, heat: Array) -> Array:
        """What heats of all lumps (·, N) do to the states: (·, n)."""
        if self._driven is None:
            return np.asarray(heat @ self.F_heat.T)
        states, lumps, by = self._driven
        out = np.zeros((len(heat), len(self.F_heat)))
        out[:, states] = heat[:, lumps] * by
        return out

    def see_driven(self, rows: Array) -> Array:
        """Rows over the states (·, n) as rows over the heat that drives these (·, N)."""
        if self._driven is None:
            return np.asarray(rows @ self.F_heat)
        states, lumps, by = self._driven
        out = np.zeros((len(rows), self.F_heat.shape[1]), rows.dtype)
        out[:, lumps] = rows[:, states] * by
        return out

    @cached_property
    def _driven(self) -> tuple[Indices, Indices, Array] | None:
        """States, the one lump whose heat drives each, and by how much; None where it is not one to one."""
        states, lumps = np.nonzero(self.F_heat)
        one_to_one = all((np.bincount(which, minlength=1) <= 1).all() for which in (states, lumps))
        return (states, lumps, self.F_heat[states, lumps]) if one_to_one else None


KnownRegimes = dict[tuple[float, ...], Regime]


def regime_from(network: Network, K: Array, readouts: Readouts) -> Regime:
    """Eliminates massless lumps and appends the sensors' states."""
    free, massless, bound = network.free, network.massless, network.bound
    N, n, nz = network.size, len(free), readouts.states
    P, P_held, P_heat = np.zeros((N, n + nz)), np.zeros((N, len(bound))), np.zeros((N, N))
    P[free, np.arange(n)] = 1.0
    P_held[bound, np.arange(len(bound))] = 1.0
    if len(massless):
        inner = _junction_matrix(network, K)
        P[massless, :n] = -np.linalg.solve(inner, K[np.ix_(massless, free)])
        P_held[massless] = -np.linalg.solve(inner, K[np.ix_(massless, bound)])
        P_heat[np.ix_(massless, massless)] = -np.linalg.inv(inner)
    per_capacity = 1 / network.capacity[free][:, None]
    A, F_held, F_heat = np.zeros((n + nz, n + nz)), np.zeros((n + nz, len(bound))), np.zeros((n + nz, N))
    into = K[free]
    S = into @ P[:, :n] if len(massless) else into[:, free]
    A[:n, :n], F_held[:n] = S * per_capacity, into @ P_held * per_capacity
    if len(massless):
        F_heat[:n] = into @ P_heat * per_capacity
    F_heat[np.arange(n), free] += per_capacity[:, 0]
    if nz:
        A[n:] = readouts.state_T @ P
        A[n:, n:] += readouts.state_z
        F_held[n:], F_heat[n:] = readouts.state_T @ P_held, readouts.state_T @ P_heat
    is_symmetric = not nz and bool(np.abs(S - S.T).max() <= 1e-12 * np.abs(S).max())
    return Regime(A, P, P_held, P_heat, F_held, F_heat, is_symmetric, K)


def _junction_matrix(network: Network, K: Array) -> Array:
    inner = K[np.ix_(network.massless, network.massless)]
    if not np.linalg.cond(inner) <= 1e14:
        raise Failed("a massless junction has no conductance to the rest; give its links a conductance above zero")
    return np.asarray(inner)
