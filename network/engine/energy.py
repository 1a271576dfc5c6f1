"""The energy account of a run: what every mechanism brought in or took out, what every part absorbed, and the gap."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.balance import heat_balance, inward
from network.engine.network import Network
from network.engine.solvers.elimination import Regime
from network.engine.solvers.linear import LinearProblem, LinearSolution
from network.engine.solvers.plan import Plan
from network.platform.printing import Brief

NO_HEAT = 3e-5
"""K: what does not warm a machine by more is nothing that an account is closed to, for steps keep its temperatures to
1e-7 of some 300 K."""


@dataclass(frozen=True, eq=False, repr=False)
class EnergyAccount(Brief):
    """All in joules, over the whole run.

    by_mechanism: net heat brought into the parts by every entry (negative: taken out); links between two parts carry
    heat and bring none: `carried`, from their first place to their second. absorbed: by every part, summed from heat
    flows. stored: heat capacity times temperature change. in_: what the bringing mechanisms brought, out: what the
    taking ones took.
    """

    network: Network
    heat_into: Array
    heat_by_mechanism: Array
    heat_stored: Array

    @cached_property
    def by_mechanism(self) -> dict[str, float]:
        return self._mechanisms(inner=False)

    @cached_property
    def carried(self) -> dict[str, float]:
        return self._mechanisms(inner=True)

    @cached_property
    def absorbed(self) -> dict[str, float]:
        return self._by_part(self.heat_into)

    @cached_property
    def stored(self) -> dict[str, float]:
        return self._by_part(self.heat_stored)

    @property
    def in_(self) -> float:
        return sum(e for e in self.by_mechanism.values() if e > 0)

    @property
    def out(self) -> float:
        return -sum(e for e in self.by_mechanism.values() if e < 0)

    @property
    def total_stored(self) -> float:
        return float(self.heat_stored.sum())

    @property
    def closure(self) -> float:
        """(in − out − stored)/max(in, out, |stored|), where any of these is more than rounding."""
        warmed = np.where(self.network.is_state, 0.0, self.network.capacity)[self.network.free]
        size = max(self.in_, self.out, abs(self.total_stored), NO_HEAT * float(warmed.sum()))
        return (self.in_ - self.out - self.total_stored) / size if size else 0.0

    def _mechanisms(self, inner: bool) -> dict[str, float]:
        among = _inner_links(self.network)
        named = zip(self.network.mechanisms, self.heat_by_mechanism.tolist(), strict=True)
        return {name: energy for name, energy in named if (name in among) == inner}

    def _by_part(self, heat: Array) -> dict[str, float]:
        bound = np.isinf(self.network.capacity)
        return {name: float(heat[part].sum()) for name, part in self.network.bodies.items() if not bound[part].any()}


def sum_stored_heat(network: Network, T: Array) -> Array:
    """Heat in every lump above 0 °C [J], latent heat included; zero for held and massless lumps and states."""
    finite = network.heat_capacity
    heat = np.where(finite > 0, finite * np.where(np.isfinite(T), T, 0.0), 0.0)
    for name in network.melting:
        part, melting = network.parts[name], network.machine.nodes[name].stored
        assert melting is not None
        share = 1 / (part.stop - part.start)
        heat[..., part] += share * melting.compute_latent_heat(T[..., part])
    if network.states:
        heat[..., network.is_state] = 0.0
    return np.asarray(heat)


def _account(network: Network, into: Array, by_mechanism: Array, T0: Array, T1: Array) -> EnergyAccount:
    return EnergyAccount(network, into, by_mechanism, sum_stored_heat(network, T1) - sum_stored_heat(network, T0))


def _inner_links(network: Network) -> set[str]:
    """Links whose ends are all parts or junctions: what one end gives, the other gets."""
    bound = np.isinf(network.capacity)
    outer: set[str] = set()
    inner: set[str] = set()
    for flows in network.flows:
        for e, entry in enumerate(flows.entry):
            is_outer = flows.one_way or bound[flows.a[e]] or bound[flows.b[e]]
            (outer if is_outer else inner).add(network.mechanisms[entry])
    return inner - outer


def linear_account(problem: LinearProblem, solution: LinearSolution) -> EnergyAccount:
    """The account of an exact run: integrals of heat flows from the closed integrals of the temperatures."""
    network = problem.plan.network
    into, by_mechanism = np.zeros(network.size), np.zeros(len(network.mechanisms))
    for r, regime in enumerate(problem.regimes):
        mine = np.flatnonzero(problem.regime_of == r)
        x_integral = solution.x_integral[mine].sum(axis=0) if solution.by_interval else solution.x_integral[r]
        T_integral = _temperature_integral(problem, regime, mine, x_integral)
        _add_flows(problem, mine, T_integral, into, by_mechanism)
        _add_sources(problem, mine, T_integral, into, by_mechanism)
    return _account(
        network, into, by_mechanism, problem.temperatures(problem.x0, 0), problem.temperatures(solution.x_end, -1)
    )


def _temperature_integral(problem: LinearProblem, regime: Regime, mine: Indices, x_integral: Array) -> Array:
    """∫T dt of all lumps over the intervals `mine`."""
    h = problem.plan.steps[mine, None] / 2
    h0, h1 = problem.forcing.held
    T = regime.P @ x_integral + regime.P_held @ ((h0[mine] + h1[mine]) * h).sum(axis=0)
    if len(problem.plan.network.massless):
        q0, q1 = (problem.forcing.push(side, at=mine) for side in (0, 1))
        T += regime.P_heat @ ((q0 + q1) * h).sum(axis=0)
    return np.asarray(T)


def _inputs(plan: Plan, mine: Indices) -> dict[str, Array]:
    """Inputs at the first of some intervals, which have their conductances in common."""
    return {name: values[mine[0]] for name, values in plan.left.items()}


def _add_flows(problem: LinearProblem, mine: Indices, T: Array, into: Array, by_mechanism: Array) -> None:
    """Flows are linear: their integral is the flow of the integrated temperatures."""
    network = problem.plan.network
    bound = np.isinf(network.capacity)
    u = _inputs(problem.plan, mine)
    for flows in network.flows:
        Q = flows.w * flows.heat_flow(T, u)
        into += np.bincount(flows.b, Q, network.size)
        if not flows.one_way:
            into -= np.bincount(flows.a, Q, network.size)
        np.add.at(by_mechanism, flows.entry, Q * inward(flows, bound))


def _add_sources(problem: LinearProblem, mine: Indices, T: Array, into: Array, by_mechanism: Array) -> None:
    network, plan = problem.plan.network, problem.plan
    half = plan.steps[mine, None] / 2
    for heats, (first, last) in zip((*network.heats, *network.relays), problem.forcing.sources, strict=True):
        energy = ((first + last)[mine] * half).sum(axis=0)
        if heats.reads:
            u = _inputs(plan, mine)
            zeros = [np.zeros(len(R)) for R in heats.reads]
            for R, slope in zip(heats.reads, heats.slopes(u, *zeros), strict=True):
                energy = energy + slope * (R @ T)
        into += heats.into @ energy
        if heats.is_heat:
            by_mechanism[heats.entry] += energy


def heat_over_time(problem: LinearProblem, solution: LinearSolution) -> Array:
    """Heat absorbed by every lump since the start at every edge [J], (K+1, N), summed from heat flows alone.

    The solution must have been made with each_interval.
    """
    network, plan = problem.plan.network, problem.plan
    steps = np.empty((len(plan.steps), network.size))
    for r, regime in enumerate(problem.regimes):
        mine = np.flatnonzero(problem.regime_of == r)
        (h0, h1), (q0, q1) = problem.forcing.held, problem.forcing.heat
        half = plan.steps[mine, None] / 2
        T = solution.x_integral[mine] @ regime.P.T + ((h0 + h1)[mine] * half) @ regime.P_held.T
        T += ((q0 + q1)[mine] * half) @ regime.P_heat.T
        steps[mine] = T @ regime.K.T + (q0 + q1)[mine] * half
    return np.concatenate([np.zeros((1, network.size)), np.cumsum(steps, axis=0)])


@dataclass
class Quadrature:
    """Sums heat flows over the steps of a numerical integration."""

    network: Network
    into: Array
    by_mechanism: Array

    @classmethod
    def empty(cls, network: Network) -> Quadrature:
        return cls(network, np.zeros(network.size), np.zeros(len(network.mechanisms)))

    def add(self, T: Array, u: dict[str, Array], modes: Array, weights: Array) -> None:
        """Heat at M instants with temperatures T (M, N), inputs (M, 1) and quadrature weights [s]."""
        heat = heat_balance(self.network, T, u, modes)
        self.into += weights @ heat.into
        self.by_mechanism += weights @ heat.by_mechanism

    def account(self, T0: Array, T1: Array) -> EnergyAccount:
        return _account(self.network, self.into, self.by_mechanism, T0, T1)
