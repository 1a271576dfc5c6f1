"""Affine networks reduced to their states: dx/dt = A x + f(t) in each regime, x = free lumps and sensor states.

Massless junctions are eliminated exactly (Schur complement), held nodes become inputs. Inside every interval f runs
straight from f0 to f1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.balance import affine_matrix, list_tangent_offsets
from network.engine.channels import Readouts
from network.engine.solvers.courses import Courses
from network.engine.solvers.elimination import KnownRegimes, Regime, regime_from
from network.engine.solvers.forcing import Forcing, force_sources
from network.engine.solvers.plan import Plan
from network.engine.solvers.regimes import matrix_inputs
from network.engine.solvers.regimes import regimes as regimes_of

CHUNK = 2_000_000
"""Numbers in one operand, so that long runs of large networks stay in memory."""


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
    """The reduced problem of a plan; laws that are not straight by their tangents about its temperatures. known:
    regimes of the same network and readouts, by the inputs and temperatures that make them."""
    network, known = plan.network, {} if known is None else known
    if plan.about is None and not network.is_affine():
        plan = replace(plan, about=np.full(network.size, network.machine.reference))
    about = () if plan.about is None else tuple(plan.about.tolist())
    names, (distinct, regime_of) = matrix_inputs(network), regimes_of(network, plan.left, plan.about)
    regimes = []
    for k in distinct:
        key = (*(float(plan.left[name][k]) for name in names), *about)
        if key not in known:
            known[key] = _find_regime(plan, int(k), readouts)
        regimes.append(known[key])
    forcing = force_sources(plan)
    if not network.is_affine():
        forcing = forcing.beside(*_find_offsets(plan))
    f0, f1 = force_states(regimes, regime_of, forcing, readouts)
    scale = np.concatenate([np.sqrt(network.capacity[network.free]), np.ones(readouts.states)])
    problem = LinearProblem(plan, readouts, tuple(regimes), regime_of, forcing, f0, f1, np.zeros(len(scale)), scale)
    return replace(problem, x0=problem.begin(plan.T0))


def begin_runs(whole: LinearProblem, plans: Sequence[Plan], runs: Sequence[slice]) -> dict[int, Array]:
    """States at the first intervals of runs that follow each other, by interval."""
    return {run.start: part_of(whole, plan, run).x0 for plan, run in zip(plans, runs, strict=True)}


def part_of(whole: LinearProblem, plan: Plan, run: slice) -> LinearProblem:
    """The problem of one of several runs that follow each other: its plan, and its intervals."""
    forcing, lumped = whole.forcing, whole.forcing.lumped
    own = replace(
        forcing, held=(forcing.held[0][run], forcing.held[1][run]),
        lumped=lumped and (lumped[0][run], lumped[1][run]),
        sources=tuple((first[run], last[run]) for first, last in forcing.sources),
    )  # fmt: skip
    part = replace(
        whole, plan=plan, regime_of=whole.regime_of[run], forcing=own, f0=whole.f0[run], f1=whole.f1[run]
    )  # fmt: skip
    return replace(part, x0=part.begin(plan.T0))


def _find_regime(plan: Plan, k: int, readouts: Readouts) -> Regime:
    """The regime of interval k, all relays off."""
    network = plan.network
    modes = np.zeros(network.relay_count)
    u = {name: values[k] for name, values in plan.left.items()}
    return regime_from(network, affine_matrix(network, u, modes, plan.about), readouts)


def _find_offsets(plan: Plan) -> Iterator[Array]:
    """Heats into all lumps with which tangents touch their laws, just after and just before the edges (K, N): Q(T̄, u) −
    K T̄ − q(u), q what sources bring at readings of zero; all relays off."""
    network, K, about = plan.network, len(plan.steps), plan.about
    assert about is not None
    held = {name: values[:, None] for name, values in plan.left.items()}
    for u in plan.just_inside:
        heat = np.zeros((K, network.size))
        for own, spread in list_tangent_offsets(network, about, u, held):
            heat += np.atleast_2d(own) @ spread
        heat[:, network.bound] = 0.0
        yield heat


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
