"""RODAS: a Rosenbrock method of order 4(3) for networks that are not linear in temperature.

Stiffly accurate and made for mass matrices that may be singular, so massless junctions are solved along with the rest.
What is linear in the network is one matrix and one heat series; only the other heat flows are evaluated at every
stage, with the catalogue's own slopes as Jacobian. Restarts (keeping its step) at every input change. Source: Hairer &
Wanner, Solving Ordinary Differential Equations II, section VI.4, method RODAS; coefficients of its published code.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.base import Inputs, Mechanism
from network.engine.balance import affine_heat, affine_matrix, flow_heat, source_heat
from network.engine.channels import Readouts
from network.engine.energy import EnergyAccount, Quadrature, sum_stored_heat
from network.engine.entry_groups import Heats
from network.engine.solvers.plan import Plan
from network.engine.solvers.regimes import matrix_inputs
from network.platform.refusal import Failed

GAMMA = 0.25
# rows of a: arguments of stages 2 to 5; rows of c: what earlier stages add to stages 2 to 6, times mass over step
STAGES = tuple(map(np.array, (
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950),
)))  # fmt: skip
COUPLING = tuple(map(np.array, (
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
    (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054),
)))  # fmt: skip
TIMES = (0.0, 0.386, 0.21, 0.63, 1.0, 1.0)
DRIFT = (0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0)
DENSE = np.array([
    [10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823, 1.025137723295662, 0.0],
    [-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386, -6.594389125716872, 0.0],
])  # fmt: skip
SMALLEST_STEP = 1e-9
HAIR, BETWEEN, STRAIGHT = 1e-12, (0.25, 0.5), 1e-10
"""Shares of an interval at which a heat is looked at, and how close to straight it has to go (of the largest)."""
BLOCK = 8192
NODES, WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class RosenbrockSolution:
    """As from the reference: readings and sensor states (rows) at the instants of output, the account, the steps."""

    y: Array
    T_start: Array
    T_end: Array
    account: EnergyAccount
    heat: Array
    steps: int


@dataclass
class _Steps:
    """Accepted steps: instants, states at their ends, and the two vectors of the dense output."""

    t: list[float] = field(default_factory=list)
    x: list[Array] = field(default_factory=list)
    first: list[Array] = field(default_factory=list)
    second: list[Array] = field(default_factory=list)
    interval: list[int] = field(default_factory=list)


class _Heat:
    """Heat into the solved lumps, and its slopes: the affine part as a matrix, the rest by its equations."""

    def __init__(self, plan: Plan) -> None:
        network = plan.network
        self.plan, self.network = plan, network
        self.solved = np.flatnonzero(np.isfinite(network.capacity))
        straight = replace(
            network,
            flows=tuple(f for f in network.flows if self._is_straight(f.law)),
            heats=tuple(h for h in network.heats if self._is_straight(h.law)),
        )
        self.flows = [f for f in network.flows if not self._is_straight(f.law)]
        bent = [h for h in network.heats if not self._is_straight(h.law)]
        along = [h for h in bent if self._goes_straight(h)]
        self.heats = [h for h in bent if not any(h is other for other in along)]
        self.straight, self.keys = straight, matrix_inputs(straight)
        self.matrices: dict[tuple[float, ...], Array] = {}
        count = len(plan.steps)
        given = replace(straight, heats=(*straight.heats, *along))
        self.q0, self.q1 = (affine_heat(given, u, np.zeros(0), count) for u in plan.just_inside)
        self.h0, self.h1 = plan.evaluate_held(plan.left), plan.evaluate_held(plan.right)

    def _is_straight(self, law: Mechanism) -> bool:
        """Affine, with inputs that hold within every interval: one matrix and one heat each."""
        return law.is_affine() and not self.plan.is_ramped(law)

    def _goes_straight(self, heats: Heats[Mechanism]) -> bool:
        """Heat that depends on no temperature, and goes straight from the begin to the end of every interval."""
        plan, law = self.plan, heats.law
        if heats.reads or law.follows_time or not law.is_affine():
            return False
        alone = replace(self.network, flows=(), heats=(heats,))
        q0, q1, *between = (
            affine_heat(alone, {n: (a + s * (plan.right[n] - a))[:, None] for n, a in plan.left.items()}, np.zeros(0),
                        len(plan.steps))
            for s in (HAIR, 1 - HAIR, *BETWEEN)
        )  # fmt: skip
        close = STRAIGHT * float(np.abs(q1).max(initial=np.abs(q0).max(initial=0.0)))
        bends = (np.abs(q - q0 - s * (q1 - q0)).max(initial=0.0) for s, q in zip(BETWEEN, between, strict=True))
        return all(bend <= close for bend in bends)

    def enter(self, k: int) -> None:
        """Prepares interval k."""
        plan, self.k = self.plan, k
        self.begin, self.length = float(plan.edges[k]), float(plan.steps[k])
        self.u0 = u = {name: values[k] for name, values in plan.left.items()}
        self.grows = {name: plan.right[name][k] - value for name, value in u.items()}
        self.held, self.held_grows = self.h0[k], self.h1[k] - self.h0[k]
        self.heat, self.heat_grows = self.q0[k], self.q1[k] - self.q0[k]
        key = tuple(float(u[name]) for name in self.keys)
        if key not in self.matrices:
            self.matrices[key] = affine_matrix(self.straight, u, np.zeros(0))
        self.K = self.matrices[key]

    def inputs(self, t: float) -> Inputs:
        share = (t - self.begin) / self.length
        return {name: value + share * self.grows[name] for name, value in self.u0.items()}

    def lumps(self, t: float, x: Array) -> Array:
        """All lumps: solved ones from the state, held ones from the inputs."""
        T = np.empty(self.network.size)
        T[self.network.bound] = self.held + (t - self.begin) / self.length * self.held_grows
        T[self.solved] = x
        return T

    def into(self, t: float, x: Array) -> Array:
        """Heat into the solved lumps [W]."""
        T, u = self.lumps(t, x), self.inputs(t)
        heat = self.K @ T + self.heat + (t - self.begin) / self.length * self.heat_grows
        for flows in self.flows:
            heat += flow_heat(flows, T, u) @ flows.spread
        for heats in self.heats:
            heat += heats.into @ source_heat(heats, T, u)
        return np.asarray(heat[self.solved])

    def slopes(self, t: float, x: Array) -> Array:
        """∂(heat into)/∂T among the solved lumps [W/K]."""
        T, u = self.lumps(t, x), self.inputs(t)
        J = self.K.copy()
        for flows in self.flows:
            by_a, by_b, *by_own = flows.slopes(T, u)
            along = np.zeros_like(flows.spread)
            rows = np.arange(len(flows.a))
            along[rows, flows.a] = flows.w * by_a
            along[rows, flows.b] += flows.w * by_b
            for reads, slope in zip(flows.reads, by_own, strict=True):
                along += (flows.w * slope)[:, None] * reads
            J += flows.spread.T @ along
        for heats in self.heats:
            for R, slope in zip(heats.reads, heats.slopes(u, *(R @ T for R in heats.reads)), strict=True):
                J += heats.into @ ((slope * np.ones(len(R)))[:, None] * R)
        return np.asarray(J[np.ix_(self.solved, self.solved)])


def solve(
    plan: Plan, readouts: Readouts, rtol: float = 1e-7, progress: Callable[[float], None] | None = None
) -> RosenbrockSolution:
    """Integrates a plan without relays or melting. Raises Failed where a step gets too small."""
    run = _Run(plan, readouts, rtol)
    run.integrate(progress)
    return run.solution()


class _Run:
    def __init__(self, plan: Plan, readouts: Readouts, tolerance: float) -> None:
        self.plan, self.readouts, self.tolerance = plan, readouts, tolerance
        self.heat, self.network = _Heat(plan), plan.network
        self.mass = np.concatenate([self.network.capacity[self.heat.solved], np.ones(readouts.states)])
        self.n = len(self.heat.solved)
        self.steps = _Steps()

    # -- the system, sensor states included ---------------------------------------------------------------------------
    def _rate(self, t: float, x: Array) -> Array:
        into, r = self.heat.into(t, x[: self.n]), self.readouts
        if not r.states:
            return into
        T = self.heat.lumps(t, x[: self.n])
        return np.concatenate([into, r.state_T @ T + r.state_z @ x[self.n :] + r.state_constant])

    def _slopes(self, t: float, x: Array) -> Array:
        J, r = self.heat.slopes(t, x[: self.n]), self.readouts
        if not r.states:
            return J
        upper = np.hstack([J, np.zeros((self.n, r.states))])
        return np.vstack([upper, np.hstack([r.state_T[:, self.heat.solved], r.state_z])])

    def _start(self) -> Array:
        """Free lumps at T0, junctions where no heat stays in them, sensor states in equilibrium."""
        self.heat.enter(0)
        t0 = float(self.plan.edges[0])
        x = np.concatenate([self.plan.T0[self.heat.solved], np.zeros(self.readouts.states)])
        light = np.flatnonzero(self.mass == 0)
        for _ in range(50 if len(light) else 0):
            left_over = self.heat.into(t0, x[: self.n])[light]
            x[light] -= np.linalg.solve(self.heat.slopes(t0, x[: self.n])[np.ix_(light, light)], left_over)
        if self.readouts.states:
            x[self.n :] = self.readouts.start_states(self.heat.lumps(t0, x[: self.n]))
        return x

    # -- stepping -----------------------------------------------------------------------------------------------------
    def integrate(self, progress: Callable[[float], None] | None) -> None:
        x, plan = self._start(), self.plan
        h = float(min(plan.steps[0], 1.0))
        self.steps.t.append(float(plan.edges[0]))
        self.steps.x.append(x)
        for k, end in enumerate(plan.edges[1:].tolist()):
            self.heat.enter(k)
            t = float(plan.edges[k])
            while t < end:
                x, t, h = self._step(k, t, x, h, end)
            if progress:
                progress(t)

    def _step(self, k: int, t: float, x: Array, h: float, end: float) -> tuple[Array, float, float]:
        """One accepted step: new state, instant, and the step to try next."""
        rate, J = self._rate(t, x), self._slopes(t, x)
        sliver = 1e-4 * min(h, end - t)
        drift = (self._rate(t + sliver, x) - rate) / sliver
        while True:
            is_last = h >= (end - t) * (1 - 1e-10)
            step = end - t if is_last else h
            new, bend, error = self._trial(t, x, step, rate, J, drift)
            scale = self.tolerance * (1 + np.maximum(np.abs(x), np.abs(new)))
            size = float(np.sqrt(np.mean((error / scale) ** 2)))
            factor = float(np.clip(0.9 * size**-0.25, 0.2, 5.0)) if size > 0 else 5.0
            if size <= 1:
                break
            h = step * min(factor, 0.9) if np.isfinite(size) else step * 0.2
            if not h >= SMALLEST_STEP:
                hot = float(np.abs(x).max())
                raise Failed(
                    f"the integration stopped at {t:.6g} s with {hot:.3g} degC; "
                    "a heat source that grows with its own temperature runs away like this"
                )
        self._keep(k, end if is_last else t + step, new, bend)
        return new, end if is_last else t + step, max(h, step * factor) if is_last else step * factor

    def _keep(self, k: int, t: float, x: Array, bend: tuple[Array, Array]) -> None:
        self.steps.t.append(t)
        self.steps.x.append(x)
        self.steps.first.append(bend[0])
        self.steps.second.append(bend[1])
        self.steps.interval.append(k)

    def _trial(
        self, t: float, x: Array, h: float, rate: Array, J: Array, drift: Array
    ) -> tuple[Array, tuple[Array, Array], Array]:
        """State after a step, the vectors of the dense output, and the error estimate."""
        factor, pivots, _ = dgetrf(np.diag(self.mass / (h * GAMMA)) - J)
        U, per_step, argument = np.empty((6, len(x))), self.mass / h, x
        U[0] = dgetrs(factor, pivots, rate + h * DRIFT[0] * drift)[0]
        for stage in range(1, 6):
            argument = argument + U[4] if stage == 5 else x + STAGES[stage - 1] @ U[:stage]
            right = self._rate(t + TIMES[stage] * h, argument) + h * DRIFT[stage] * drift
            U[stage] = dgetrs(factor, pivots, right + per_step * (COUPLING[stage - 1] @ U[:stage]))[0]
        first, second = DENSE @ U
        return argument + U[5], (first, second), U[5]

    # -- results ------------------------------------------------------------------------------------------------------
    def _dense(self, t: Array, step: Indices) -> Array:
        """States at instants t within the given steps, (M, n): third order between the ends of a step."""
        ends, x, first, second = self._known
        s = ((t - ends[step]) / (ends[step + 1] - ends[step]))[:, None]
        return np.asarray((1 - s) * x[step] + s * (x[step + 1] + (1 - s) * (first[step] + s * second[step])))

    @cached_property
    def _known(self) -> tuple[Array, Array, Array, Array]:
        """Of all steps, when they are done: ends, states there, and what bends the way between them; used up, for long
        runs of large machines fill the memory."""
        steps = self.steps
        return np.array(steps.t), _use_up(steps.x), _use_up(steps.first), _use_up(steps.second)

    def _lumps(self, t: Array, step: Indices, x: Array) -> tuple[Array, dict[str, Array]]:
        """All lumps and inputs at instants t within steps: (M, N), each input (M, 1)."""
        k = np.array(self.steps.interval)[step]
        share = ((t - self.plan.edges[k]) / self.plan.steps[k])[:, None]
        T = np.empty((len(t), self.network.size))
        T[:, self.network.bound] = self.heat.h0[k] + share * (self.heat.h1[k] - self.heat.h0[k])
        T[:, self.heat.solved] = x[:, : self.n]
        u = {n: a[k][:, None] + share * (self.plan.right[n] - a)[k][:, None] for n, a in self.plan.left.items()}
        return T, u

    def solution(self) -> RosenbrockSolution:
        ends, t, r = self._known[0], self.plan.t, self.readouts
        step = np.clip(np.searchsorted(ends, t + 1e-9, side="right") - 1, 0, len(ends) - 2)
        y, heat = np.empty((r.width, len(t))), np.empty((len(t), self.network.size))
        first = last = np.empty(0)
        for some in _blocks(len(t)):
            x = self._dense(t[some], step[some])
            T, _ = self._lumps(t[some], step[some], x)
            y[:, some] = np.vstack([r.rows @ T.T, x[:, self.n :].T])
            heat[some] = sum_stored_heat(self.network, T)
            first, last = (T[0] if some.start == 0 else first), T[-1]
        heat -= heat[0].copy()
        return RosenbrockSolution(y, first, last, self._account(first, last), heat, len(ends) - 1)

    def _account(self, T0: Array, T1: Array) -> EnergyAccount:
        """Gauss–Legendre over every step."""
        ends, quadrature = self._known[0], Quadrature.empty(self.network)
        half, middle = np.diff(ends)[:, None] / 2, (ends[1:] + ends[:-1])[:, None] / 2
        t, weights = (middle + half * NODES).ravel(), (half * WEIGHTS).ravel()
        step = np.repeat(np.arange(len(ends) - 1), len(NODES))
        for some in _blocks(len(t)):
            T, u = self._lumps(t[some], step[some], self._dense(t[some], step[some]))
            quadrature.add(T, u, np.zeros(0), weights[some])
        return quadrature.account(T0, T1)


def _use_up(rows: list[Array]) -> Array:
    table = np.array(rows)
    rows.clear()
    return table


def _blocks(count: int) -> Iterator[slice]:
    """Of instants, as many as keep what is computed of them small beside what is kept."""
    return (slice(first, min(first + BLOCK, count)) for first in range(0, count, BLOCK))
