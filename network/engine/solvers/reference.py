"""solve_ivp on any network: always restarted at every input change; relays by events, massless junctions by Newton.

The skipped-pulse trap: over a whole schedule an adaptive step jumps across what happens between its steps, so each
interval between input changes is a solve of its own. For the same reason the state of a lump that melts is the heat
in it (over its capacity, so that it is a temperature while nothing melts): a narrow melting range cannot be missed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.balance import heat_into, jacobian
from network.engine.channels import Readouts
from network.engine.energy import EnergyAccount, Quadrature, sum_stored_heat
from network.engine.solvers.latent_state import LatentState
from network.engine.solvers.plan import Plan
from network.engine.solvers.relay_modes import LONGEST, RelayModes
from network.platform.refusal import Failed

if TYPE_CHECKING:
    from scipy.integrate import OdeSolution

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)
NEWTON_STEPS = 50
MOST_EVALUATIONS = 200_000
"""Of the rate, from one switching or change of an input to the next: 10 to 20 s. An explicit method takes as many in a
hundred thousand of the shortest time constants, however little happens."""


@dataclass
class ReferenceSolution:
    """y: readings and sensor states (rows) at the instants of output; heat: heat absorbed by every lump since the start
    at the instants of output [J]; switches: (instant, relay, new mode)."""

    y: Array
    T_start: Array
    T_end: Array
    account: EnergyAccount
    switches: list[tuple[float, int, int]]
    heat: Array


def solve(
    plan: Plan, readouts: Readouts, method: str = "LSODA", rtol: float = 1e-8, atol: float = 1e-8,
    progress: Callable[[float], None] | None = None,
) -> ReferenceSolution:  # fmt: skip
    """Integrates a plan. Raises Failed where the integration breaks down."""
    return _Run(plan, readouts, method, rtol, atol).run(progress)


@dataclass
class _Run:
    plan: Plan
    readouts: Readouts
    method: str
    rtol: float
    atol: float
    evaluations: int = 0

    def __post_init__(self) -> None:
        network = self.plan.network
        self.network, self.n = network, len(network.free)
        self.latest = self.plan.T0.copy()
        self.latent, self.relays = LatentState(network, np.ones(network.size, bool)), RelayModes(self.plan)
        self.quadrature = Quadrature.empty(network)

    def run(self, progress: Callable[[float], None] | None) -> ReferenceSolution:
        plan, outputs = self.plan, self.readouts.width
        y, heat = np.empty((outputs, len(plan.t))), np.empty((len(plan.t), self.network.size))
        x = self._start()
        T0 = self.temperatures(0, float(plan.edges[0]), x)
        bounds = plan.bounds
        for k in range(len(plan.steps)):
            here = slice(bounds[k], bounds[k + 1])
            x = self._interval(k, x, plan.t[here], y[:, here], heat[here])
            if progress:
                progress(float(plan.edges[k + 1]))
        T_end = self.temperatures(len(plan.steps) - 1, float(plan.edges[-1]), x)
        heat = sum_stored_heat(self.network, heat) - sum_stored_heat(self.network, T0.copy())
        account = self.quadrature.account(T0, T_end)
        return ReferenceSolution(y, T0, T_end, account, self.relays.switches, heat)

    # -- temperatures and rates -------------------------------------------------------------------------------------
    def temperatures(self, k: int, t: float, x: Array) -> Array:
        """All lumps: free ones from the state, held ones from the inputs, massless ones where their heat is zero."""
        u = self.plan.inputs_in(k, t)
        self.latest[self.network.free] = x[: self.n]
        self.latest = T = self.latent.temperature(self.latest)
        for i, held in self.network.held.items():
            T[i] = held.at(u)
        if len(self.network.massless):
            self._settle(T, u)
        return T.copy()

    def _settle(self, T: Array, u: Inputs) -> None:
        """Newton on the massless junctions: no heat stays in them."""
        at = self.network.massless
        for _ in range(NEWTON_STEPS):
            left_over = heat_into(self.network, T, u, self.relays.on)[at]
            step = np.linalg.solve(jacobian(self.network, T, u, self.relays.on)[np.ix_(at, at)], left_over)
            T[at] -= step
            if np.abs(step).max() < 1e-11 * (1 + np.abs(T[at]).max()):
                return
        raise Failed(f"the temperature of a massless junction did not settle (last step {np.abs(step).max():.2g} K)")

    def rate(self, k: int, t: float, x: Array) -> Array:
        T = self.temperatures(k, t, x)
        into = heat_into(self.network, T, self.plan.inputs_in(k, t), self.relays.on)
        slow = into[self.network.free] / self.network.capacity[self.network.free]
        r = self.readouts
        if not r.states:
            return np.asarray(slow)
        return np.concatenate([slow, r.state_T @ T + r.state_z @ x[self.n :] + r.state_constant])

    def slope(self, k: int, t: float, x: Array) -> Array:
        T, network, r = self.temperatures(k, t, x), self.network, self.readouts
        free, massless = network.free, network.massless
        J, soft = jacobian(network, T, self.plan.inputs_in(k, t), self.relays.on), self.latent.softening(T)
        P = np.zeros((network.size, self.n))
        P[free, np.arange(self.n)] = 1.0
        if len(massless):
            P[massless] = -np.linalg.solve(J[np.ix_(massless, massless)], J[np.ix_(massless, free)])
        if soft is not None:
            P *= soft[free]
        upper = J[free] @ P / network.capacity[free][:, None]
        lower = np.hstack([r.state_T @ P, r.state_z])
        return np.vstack([np.hstack([upper, np.zeros((self.n, r.states))]), lower])

    def _start(self) -> Array:
        theta, t0 = self.latent.state(self.plan.T0), float(self.plan.edges[0])
        x = np.concatenate([theta[self.network.free], np.zeros(self.readouts.states)])
        T = self.temperatures(0, t0, x)
        self.relays.begin(T, self.plan.inputs_in(0, t0))
        if self.readouts.states:
            x[self.n :] = self.readouts.start_states(T)
        return x

    # -- one interval -----------------------------------------------------------------------------------------------
    def _interval(self, k: int, x: Array, t_out: Array, y: Array, heat: Array) -> Array:
        """From edge to edge, restarted at every switching of a relay."""
        t, end = float(self.plan.edges[k]), float(self.plan.edges[k + 1])
        done = 0
        while t < end:
            self.relays.note(t, self.temperatures(k, t, x), self.plan.inputs_in(k, t))
            self.relays.switch_due(t)
            first = t
            dense, t, x = self._solve(k, t, self.relays.next_due(t, end), x)
            last = len(t_out) if t >= end else int(np.searchsorted(t_out, t, side="left"))
            self._deliver(k, dense, t_out[done:last], y[:, done:last], heat[done:last], first)
            done = max(done, last)
            self._sum_heat(k, dense)
        return x

    def _solve(self, k: int, t: float, stop: float, x: Array) -> tuple[OdeSolution, float, Array]:
        from scipy.integrate import solve_ivp  # 0.2 s to load

        guards, until = list(self._events(k)), self.evaluations + MOST_EVALUATIONS
        with np.errstate(over="ignore", invalid="ignore"):
            result = solve_ivp(
                lambda s, z: self._count(k, s, z, until), (t, stop), x, method=self.method, rtol=self.rtol,
                atol=self.atol, dense_output=True, events=guards or None,
                max_step=LONGEST if len(self.relays) else np.inf,
                **({} if self.method == "RK45" else {"jac": lambda s, z: self.slope(k, s, z)}),
            )  # fmt: skip
        if not result.success or not np.isfinite(result.y[:, -1]).all():
            hot = float(np.nanmax(np.abs(result.y)))
            raise Failed(f"the integration stopped at {result.t[-1]:.6g} s with {hot:.3g} degC ({result.message}); "
                         "a heat source that grows with its own temperature runs away like this")  # fmt: skip
        return result.sol, float(result.t[-1]), np.asarray(result.y[:, -1])

    def _count(self, k: int, t: float, x: Array, until: int) -> Array:
        """The rate. Raises Failed where it has been asked for too often since the inputs changed."""
        self.evaluations += 1
        if not self.evaluations <= until:
            far = f"{MOST_EVALUATIONS} evaluations from {float(self.plan.edges[k]):.6g} s on and is at {t:.6g} s"
            right = "take --method auto, which takes long steps where nothing happens"
            raise Failed(f"solve_ivp:{self.method} has taken {far}; {right}")
        return self.rate(k, t, x)

    def _deliver(self, k: int, dense: OdeSolution, t: Array, y: Array, temperatures: Array, first: float) -> None:
        for i, instant in enumerate(t):
            x = dense(max(float(instant), first))
            T = self.temperatures(k, float(instant), x)
            y[:, i], temperatures[i] = np.concatenate([self.readouts.rows @ T, x[self.n :]]), T

    def _sum_heat(self, k: int, dense: OdeSolution) -> None:
        """Gauss–Legendre over every step that the solver took."""
        steps = dense.ts
        half, middle = np.diff(steps)[:, None] / 2, (steps[1:] + steps[:-1])[:, None] / 2
        instants, weights = (middle + half * NODES).ravel(), (half * WEIGHTS).ravel()
        x = dense(instants).T
        T = np.array([self.temperatures(k, s, z) for s, z in zip(instants, x, strict=True)])
        u = {name: np.asarray(value)[:, None] for name, value in self.plan.inputs_in(k, instants).items()}
        self.quadrature.add(T, u, self.relays.on, weights)

    # -- relays -----------------------------------------------------------------------------------------------------
    def _events(self, k: int) -> Iterator[Callable[[float, Array], float]]:
        for j in range(len(self.relays)):
            if j not in self.relays.pending:

                def guard(t: float, x: Array, j: int = j) -> float:
                    return float(self.relays.guards(self.temperatures(k, t, x), self.plan.inputs_in(k, t))[j])

                guard.terminal, guard.direction = True, 1.0  # type: ignore[attr-defined]
                yield guard
