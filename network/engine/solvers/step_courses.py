"""The steps of a step by step solution, and what a run delivers from them: courses, heat, the energy account."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.channels import Readouts
from network.engine.energy import EnergyAccount, Quadrature, sum_stored_heat
from network.engine.solvers import rodas
from network.engine.solvers.latent_state import LatentState
from network.engine.solvers.plan import Plan
from network.engine.solvers.step_heat import StepHeat

NODES, WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class RosenbrockSolution:
    """As from the reference: readings and sensor states (rows) at the instants of output, the account, the steps;
    switches: (instant, relay, new mode)."""

    y: Array
    T_start: Array
    T_end: Array
    account: EnergyAccount
    heat: Array
    steps: int
    switches: list[tuple[float, int, int]]


@dataclass
class Steps:
    """Accepted steps: instants, states at their ends, the vectors of the dense output, interval and relays of each."""

    plan: Plan
    t: list[float] = field(default_factory=list)
    x: list[Array] = field(default_factory=list)
    bend: list[rodas.Bend] = field(default_factory=list)
    interval: list[int] = field(default_factory=list)
    modes: list[Array] = field(default_factory=list)

    def begin(self, t: float, x: Array) -> None:
        self.t.append(t)
        self.x.append(x)

    def keep(self, k: int, t: float, x: Array, bend: rodas.Bend, modes: Array) -> None:
        self.begin(t, x)
        self.bend.append(bend)
        self.interval.append(k)
        self.modes.append(modes)

    def lumps(
        self, heat: StepHeat, latent: LatentState, t: Array, k: Indices, x: Array
    ) -> tuple[Array, dict[str, Array]]:  # fmt: skip
        """All lumps and inputs at instants t in intervals k with states x: (M, N), each input (M, 1)."""
        share = ((t - self.plan.edges[k]) / self.plan.steps[k])[:, None]
        T = np.empty((len(t), heat.network.size))
        T[:, heat.network.bound] = heat.h0[k] + share * (heat.h1[k] - heat.h0[k])
        T[:, heat.solved] = latent.temperature(x[:, : len(heat.solved)])
        left, right = self.plan.left, self.plan.right
        return T, {n: a[k][:, None] + share * (right[n][k] - a[k])[:, None] for n, a in left.items()}

    def _dense(self, t: Array, step: Indices) -> Array:
        """States at instants t within the given steps, (M, n)."""
        ends, x = np.array(self.t), np.array(self.x)
        first, second = (np.array(part)[step] for part in zip(*self.bend, strict=True))
        s = ((t - ends[step]) / (ends[step + 1] - ends[step]))[:, None]
        return rodas.between(s, x[step], x[step + 1], (first, second))

    def solution(
        self, heat: StepHeat, latent: LatentState, readouts: Readouts, switches: list[tuple[float, int, int]]
    ) -> RosenbrockSolution:
        ends, plan = np.array(self.t), self.plan
        step = np.clip(np.searchsorted(ends, plan.t + 1e-9, side="right") - 1, 0, len(ends) - 2)
        x = self._dense(plan.t, step)
        T, _ = self.lumps(heat, latent, plan.t, np.array(self.interval)[step], x)
        y = np.vstack([readouts.rows @ T.T, x[:, len(heat.solved) :].T])
        stored = sum_stored_heat(plan.network, T)
        account = self._account(heat, latent, T[0], T[-1])
        return RosenbrockSolution(y, T[0], T[-1], account, stored - stored[0], len(ends) - 1, switches)

    def _account(self, heat: StepHeat, latent: LatentState, T0: Array, T1: Array) -> EnergyAccount:
        """Gauss–Legendre over every step."""
        ends, quadrature = np.array(self.t), Quadrature.empty(self.plan.network)
        half, middle = np.diff(ends)[:, None] / 2, (ends[1:] + ends[:-1])[:, None] / 2
        t, step = (middle + half * NODES).ravel(), np.repeat(np.arange(len(ends) - 1), len(NODES))
        T, u = self.lumps(heat, latent, t, np.array(self.interval)[step], self._dense(t, step))
        quadrature.add(T, u, np.array(self.modes)[step], (half * WEIGHTS).ravel())
        return quadrature.account(T0, T1)
