"""solve_ivp on any network: always restarted at every input change; relays by events, massless junctions by Newton.

The skipped-pulse trap: over a whole schedule an adaptive step jumps across what happens between its steps, so each
interval between input changes is a solve of its own. For the same reason the state of a lump that melts is the heat
in it (over its capacity, so that it is a temperature while nothing melts): a narrow melting range cannot be missed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.base import Inputs
from network.engine.balance import heat_into, jacobian, relay_slices
from network.engine.channels import Readouts
from network.engine.energy import EnergyAccount, Quadrature, sum_stored_heat
from network.engine.solvers.plan import Plan
from network.engine.solvers.switch_count import check_count
from network.platform.refusal import Failed

if TYPE_CHECKING:
    from scipy.integrate import OdeSolution

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)
RELAY_STEP = 30.0
"""s: longest step while a relay waits, so that two crossings in one step are not missed."""
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
    evaluations: int
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
    switches: list[tuple[float, int, int]] = field(default_factory=list)
    evaluations: int = 0

    def __post_init__(self) -> None:
        network = self.plan.network
        self.network, self.n = network, len(network.free)
        self.latest = self.plan.T0.copy()
        self.melting = [
            (network.parts[name], stored, node.capacity)
            for name, node in network.machine.nodes.items() if (stored := node.stored) is not None
        ]  # fmt: skip
        self.modes = np.zeros(sum(relays.into.shape[1] for relays in network.relays))
        self.pauses = [float(p) for g in network.relays for p in np.broadcast_to(g.law.pause(), g.into.shape[1])]
        self.pending: dict[int, float] = {}
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
        return ReferenceSolution(y, T0, T_end, account, self.switches, self.evaluations, heat)

    # -- temperatures and rates -------------------------------------------------------------------------------------
    def temperatures(self, k: int, t: float, x: Array) -> Array:
        """All lumps: free ones from the state, held ones from the inputs, massless ones where their heat is zero."""
        u = self.plan.inputs_in(k, t)
        T = self.latest
        T[self.network.free] = x[: self.n]
        for part, melting, capacity in self.melting:
            T[part] = melting.temperature(T[part], capacity)
        for i, held in self.network.held.items():
            T[i] = held.at(u)
        if len(self.network.massless):
            self._settle(T, u)
        return T.copy()

    def _settle(self, T: Array, u: Inputs) -> None:
        """Newton on the massless junctions: no heat stays in them."""
        at = self.network.massless
        for _ in range(NEWTON_STEPS):
            left_over = heat_into(self.network, T, u, self.modes)[at]
            step = np.linalg.solve(jacobian(self.network, T, u, self.modes)[np.ix_(at, at)], left_over)
            T[at] -= step
            if np.abs(step).max() < 1e-11 * (1 + np.abs(T[at]).max()):
                return
        raise Failed(f"the temperature of a massless junction did not settle (last step {np.abs(step).max():.2g} K)")

    def _softening(self, T: Array) -> Array:
        """∂T/∂state of the free lumps: 1, and less where heat goes into melting."""
        slope = np.ones(self.network.size)
        for part, melting, capacity in self.melting:
            slope[part] = capacity / (capacity + melting.apparent_capacity(T[part]))
        return slope[self.network.free]

    def rate(self, k: int, t: float, x: Array) -> Array:
        T = self.temperatures(k, t, x)
        into = heat_into(self.network, T, self.plan.inputs_in(k, t), self.modes)
        slow = into[self.network.free] / self.network.capacity[self.network.free]
        r = self.readouts
        if not r.states:
            return np.asarray(slow)
        return np.concatenate([slow, r.state_T @ T + r.state_z @ x[self.n :] + r.state_constant])

    def slope(self, k: int, t: float, x: Array) -> Array:
        T, network, r = self.temperatures(k, t, x), self.network, self.readouts
        free, massless = network.free, network.massless
        J = jacobian(network, T, self.plan.inputs_in(k, t), self.modes)
        P = np.zeros((network.size, self.n))
        P[free, np.arange(self.n)] = 1.0
        if len(massless):
            P[massless] = -np.linalg.solve(J[np.ix_(massless, massless)], J[np.ix_(massless, free)])
        P *= self._softening(T)
        upper = J[free] @ P / network.capacity[free][:, None]
        lower = np.hstack([r.state_T @ P, r.state_z])
        return np.vstack([np.hstack([upper, np.zeros((self.n, r.states))]), lower])

    def _start(self) -> Array:
        theta = self.plan.T0.copy()
        for part, melting, capacity in self.melting:
            theta[part] += melting.compute_latent_heat(theta[part]) / capacity
        x = np.concatenate([theta[self.network.free], np.zeros(self.readouts.states)])
        T = self.temperatures(0, float(self.plan.edges[0]), x)
        for j, guard in enumerate(self._guards(0, float(self.plan.edges[0]), x)):
            self.modes[j] = 1.0 if guard > 0 else 0.0
        if self.readouts.states:
            x[self.n :] = self.readouts.start_states(T)
        return x

    # -- one interval -----------------------------------------------------------------------------------------------
    def _interval(self, k: int, x: Array, t_out: Array, y: Array, heat: Array) -> Array:
        """From edge to edge, restarted at every switching of a relay."""
        t, end = float(self.plan.edges[k]), float(self.plan.edges[k + 1])
        done = 0
        while t < end:
            self._note_crossings(k, t, x)
            t = self._switch_due(k, t, x)
            stop = min([end, *(due for due in self.pending.values() if due > t)])
            first = t
            dense, t, x = self._solve(k, t, stop, x)
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
                max_step=RELAY_STEP if len(self.modes) else np.inf,
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
        self.quadrature.add(T, u, self.modes, weights)

    # -- relays -----------------------------------------------------------------------------------------------------
    def _guards(self, k: int, t: float, x: Array) -> Array:
        T, u = self.temperatures(k, t, x), self.plan.inputs_in(k, t)
        values = [
            np.broadcast_to(
                relays.law.guard(self.modes[part], u, *(R @ T for R in relays.reads)), part.stop - part.start
            )
            for relays, part in relay_slices(self.network)
        ]
        return np.concatenate(values) if values else np.zeros(0)

    def _events(self, k: int) -> Iterator[Callable[[float, Array], float]]:
        for j in range(len(self.modes)):
            if j not in self.pending:

                def guard(t: float, x: Array, j: int = j) -> float:
                    return float(self._guards(k, t, x)[j])

                guard.terminal, guard.direction = True, 1.0  # type: ignore[attr-defined]
                yield guard

    def _note_crossings(self, k: int, t: float, x: Array) -> None:
        """Relays whose guard has been crossed will switch after their pause."""
        for j, value in enumerate(self._guards(k, t, x)):
            if value >= -1e-9 and j not in self.pending:
                self.pending[j] = t + self.pauses[j]

    def _switch_due(self, k: int, t: float, x: Array) -> float:
        for j, due in list(self.pending.items()):
            if due <= t + 1e-9:
                self.modes[j] = 1.0 - self.modes[j]
                self.switches.append((t, j, int(self.modes[j])))
                del self.pending[j]
        check_count(self.plan, self.switches)
        return t
