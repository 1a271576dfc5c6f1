"""Affine networks reduced to their states: dx/dt = A x + f(t) in each regime, x = free lumps and sensor states.

Massless junctions are eliminated exactly (Schur complement), held nodes become inputs. Inside every interval f runs
straight from f0 to f1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.balance import affine_matrix, source_series, with_modes
from network.engine.channels import Readouts
from network.engine.network import Network
from network.engine.solvers.courses import Courses
from network.engine.solvers.plan import Plan
from network.engine.solvers.regimes import matrix_inputs
from network.engine.solvers.regimes import regimes as regimes_of
from network.platform.refusal import Failed

CHUNK = 2_000_000
"""Numbers in one operand, so that long runs of large networks stay in memory."""


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


KnownRegimes = dict[tuple[float, ...], Regime]


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


@dataclass(frozen=True)
class LinearProblem:
    """Everything an exact solver needs. regime_of: regime of each interval; f0, f1: forcing of the states (K, n);
    basis: of the free lumps, orthonormal by their heat capacities, where the states are amounts of its columns."""

    plan: Plan
    readouts: Readouts
    regimes: tuple[Regime, ...]
    regime_of: Indices
    forcing: Forcing
    f0: Array
    f1: Array
    x0: Array
    scale: Array
    basis: Array | None = None

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.x0)

    def temperatures(self, x: Array, k: int) -> Array:
        """All lumps at the start (k = 0) or the end (k = −1) of the run, whose states are x."""
        regime, side = self.regimes[int(self.regime_of[k])], 0 if k == 0 else 1
        at = slice(0, 1) if k == 0 else slice(len(self.regime_of) - 1, None)
        heat = self.forcing.push(side, at=at)[0] if len(self.plan.network.massless) else np.zeros(len(regime.P))
        return np.asarray(regime.P @ x + regime.P_held @ self.forcing.held[side][k] + regime.P_heat @ heat)

    def begin(self, T: Array) -> Array:
        """States at temperatures of all lumps, those of sensors in equilibrium with what they see."""
        free = self.plan.network.free
        own = T[free] if self.basis is None else self.basis.T @ (self.plan.network.capacity[free] * T[free])
        x0 = np.concatenate([own, np.zeros(self.readouts.states)])
        if self.readouts.states:
            x0[len(own) :] = self.readouts.start_states(self.temperatures(x0, 0))
        return x0

    def outputs(self, regime: Regime, which: Indices | None = None) -> Array:
        """Readings, then sensor states, as rows over the states x; all, or some of them."""
        network, rows, own = self.plan.network, self._rows(which), self._states(which)
        over = np.zeros((len(rows) + len(own), self.order))
        free, massless, n = network.free, network.massless, self.order - self.readouts.states
        over[: len(rows), :n] = rows[:, free] if self.basis is None else rows @ regime.P[:, :n]
        if len(massless) and self.basis is None:
            over[: len(rows), :n] += rows[:, massless] @ regime.P[massless, :n]
        over[np.arange(len(rows), len(over)), n + own] = 1.0
        return over

    def _rows(self, which: Indices | None) -> Array:
        rows = self.readouts.rows
        return rows if which is None else rows[which[which < len(rows)]]

    def _states(self, which: Indices | None) -> Indices:
        if which is None:
            return np.arange(self.readouts.states)
        return which[which >= len(self.readouts.rows)] - len(self.readouts.rows)

    def see_at_once(self, r: int, which: Indices | None = None) -> tuple[Indices, Array, Array]:
        """Readings that see held nodes or heats of massless junctions at once in regime r: which of those asked for,
        and what they see just after and just before the edges of its intervals, (intervals, readings)."""
        network, regime, rows = self.plan.network, self.regimes[r], self._rows(which)
        mine = np.flatnonzero(self.regime_of == r)
        by_held, seen = rows @ regime.P_held, np.any(rows[:, network.massless], axis=1)
        lines = np.flatnonzero(by_held.any(axis=1) | seen)
        first, last = (held[mine] @ by_held[lines].T for held in self.forcing.held)
        if seen.any():
            by_heat = rows[lines] @ regime.P_heat
            first, last = first + self.forcing.push(0, by_heat, mine), last + self.forcing.push(1, by_heat, mine)
        return lines, first, last

    def add_direct(self, y: Array, which: Indices | None = None) -> None:
        """Adds to the readings y (rows × instants; all, or some) what they see at once; the others are left alone."""
        plan = self.plan
        for r in range(len(self.regimes)):
            lines, first, last = self.see_at_once(r, which)
            if not len(lines):
                continue
            mine = np.flatnonzero(self.regime_of == r)
            at = np.flatnonzero(self.regime_of[plan.interval_of] == r)
            for some in np.array_split(at, max(1, len(at) * len(lines) // CHUNK)):
                k = plan.interval_of[some]
                place, share = np.searchsorted(mine, k), ((plan.t[some] - plan.edges[k]) / plan.steps[k])[:, None]
                y[np.ix_(lines, some)] += (first[place] + share * (last - first)[place]).T


@dataclass(frozen=True)
class LinearSolution:
    """courses: readings and sensor states over the instants of output; x_end: states at the end; x_integral: ∫x dt, one
    row for each interval or, where these were not asked for, for each regime; error: estimate of the rounding [K]."""

    courses: Courses
    x_end: Array
    x_integral: Array
    by_interval: bool
    error: float


def reduce(plan: Plan, readouts: Readouts, known: KnownRegimes | None = None) -> LinearProblem:
    """The reduced problem of a plan. known: regimes of the same network and readouts, by the inputs that make them."""
    network, known = plan.network, {} if known is None else known
    names, (distinct, regime_of) = matrix_inputs(network), regimes_of(network, plan.left)
    regimes = []
    for k in distinct:
        key = tuple(float(plan.left[name][k]) for name in names)
        if key not in known:
            known[key] = _find_regime(plan, int(k), readouts)
        regimes.append(known[key])
    forcing = force_sources(plan)
    f0, f1 = force_states(regimes, regime_of, forcing, readouts)
    scale = np.concatenate([np.sqrt(network.capacity[network.free]), np.ones(readouts.states)])
    problem = LinearProblem(plan, readouts, tuple(regimes), regime_of, forcing, f0, f1, np.zeros(len(scale)), scale)
    return replace(problem, x0=problem.begin(plan.T0))


def _find_regime(plan: Plan, k: int, readouts: Readouts) -> Regime:
    """The regime of interval k, all relays off."""
    network = plan.network
    modes = np.zeros(sum(relays.into.shape[1] for relays in network.relays))
    u = {name: values[k] for name, values in plan.left.items()}
    return regime_from(network, affine_matrix(network, u, modes), readouts)


def force_states(
    regimes: Sequence[Regime], regime_of: Indices, forcing: Forcing, readouts: Readouts
) -> tuple[Array, Array]:
    """What drives the states just after and just before the edges of every interval: (K, n) each."""
    n = len(regimes[0].A)
    f0, f1 = (np.empty((len(regime_of), n)) for _ in range(2))
    for r, regime in enumerate(regimes):
        at = np.flatnonzero(regime_of == r) if len(regimes) > 1 else slice(None)
        for side, f in enumerate((f0, f1)):
            f[at] = forcing.held[side][at] @ regime.F_held.T
            f[at, n - readouts.states :] += readouts.state_constant
        if forcing.into or forcing.lumped is not None:
            for f, heat in zip((f0, f1), forcing.push_both(regime.F_heat, at), strict=True):
                f[at] += heat
    return f0, f1


def force_sources(plan: Plan) -> Forcing:
    """What drives a plan, a hair inside its intervals, so that a source that starts with a ramp is on at once."""
    network, count = plan.network, len(plan.edges) - 1
    begin, end = plan.just_inside
    groups = [*network.heats, *network.relays]
    modes = plan.modes if plan.modes is not None else np.zeros(sum(relays.into.shape[1] for relays in network.relays))
    first = [source_series(heats, begin, mode, count) for heats, mode in with_modes(network, modes)]
    last = [
        source_series(heats, end, mode, count) if plan.is_ramped(heats.law) else same
        for same, (heats, mode) in zip(first, with_modes(network, modes), strict=True)
    ]
    held = plan.evaluate_held(plan.left), plan.evaluate_held(plan.right)
    none = None if groups else (np.zeros((count, network.size)), np.zeros((count, network.size)))
    return Forcing(held, none, tuple(zip(first, last, strict=True)), tuple(heats.into for heats in groups))


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
