"""The steps of a step by step solution, and what a run delivers from them: courses, heat, the energy account."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.channels import Readouts
from network.engine.energy import EnergyAccount, Quadrature, sum_stored_heat
from network.engine.network import Network
from network.engine.solvers import rodas
from network.engine.solvers.latent_state import LatentState
from network.engine.solvers.plan import Plan
from network.engine.solvers.step_heat import StepHeat

NODES, WEIGHTS = np.polynomial.legendre.leggauss(3)


AT_A_TIME = 2_000_000
"""Numbers in the temperatures of all lumps that are held at once."""


@dataclass(frozen=True)
class RosenbrockSolution:
    """As from the reference: readings and sensor states (rows) at the instants of output, the account; switches:
    (instant, relay, new mode)."""

    y: Array
    T_start: Array
    T_end: Array
    account: EnergyAccount
    switches: list[tuple[float, int, int]]
    steps: Steps
    network: Network
    by: tuple[StepHeat, LatentState]

    @cached_property
    def heat(self) -> Array:
        """Heat absorbed by every lump since the start at the instants of output [J]."""
        stored = [sum_stored_heat(self.network, T) for T, _ in self.steps.over_output(*self.by)]
        return np.asarray(np.concatenate(stored) - stored[0][0])


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

    def _dense(self, t: Array, step: Indices, over: Array | None = None) -> Array:
        """States at instants t within the given steps, or rows over them: (M, n or rows)."""
        ends = np.array(self.t)
        x, first, second = (np.array(part) for part in (self.x, *zip(*self.bend, strict=True)))
        if over is not None:
            x, first, second = (part @ over.T for part in (x, first, second))
        s = ((t - ends[step]) / (ends[step + 1] - ends[step]))[:, None]
        return rodas.between(s, x[step], x[step + 1], (first[step], second[step]))

    @cached_property
    def step_of(self) -> Indices:
        """The step in which each instant of output lies."""
        ends = np.array(self.t)
        return np.clip(np.searchsorted(ends, self.plan.t + 1e-9, side="right") - 1, 0, len(ends) - 2)

    def over_output(self, heat: StepHeat, latent: LatentState) -> Iterator[tuple[Array, Array]]:
        """All lumps, and the states, at the instants of output, some at a time."""
        t, k = self.plan.t, np.array(self.interval)[self.step_of]
        for some in np.array_split(np.arange(len(t)), max(1, len(t) * heat.network.size // AT_A_TIME)):
            x = self._dense(t[some], self.step_of[some])
            yield self.lumps(heat, latent, t[some], k[some], x)[0], x

    def solution(
        self, heat: StepHeat, latent: LatentState, readouts: Readouts, switches: list[tuple[float, int, int]]
    ) -> RosenbrockSolution:
        y, ends = self._read(heat, latent, readouts), np.array([0, len(self.x) - 1])
        k = np.array([self.interval[0], self.interval[-1]])
        T, _ = self.lumps(heat, latent, np.array(self.t)[ends], k, np.array([self.x[i] for i in ends]))
        account = self._account(heat, latent, T[0], T[-1])
        return RosenbrockSolution(y, T[0], T[-1], account, switches, self, self.plan.network, (heat, latent))

    def _read(self, heat: StepHeat, latent: LatentState, readouts: Readouts) -> Array:
        """Readings and sensor states at the instants of output. Where nothing melts they are straight in the states, so
        that only they are followed over the steps, and not all lumps."""
        n, rows = len(heat.solved), readouts.rows
        if latent.melting:
            parts = [np.vstack([rows @ T.T, x[:, n:].T]) for T, x in self.over_output(heat, latent)]
            return np.concatenate(parts, axis=1)
        over = np.zeros((readouts.width, n + readouts.states))
        over[: len(rows), :n] = rows[:, heat.solved]
        over[np.arange(len(rows), len(over)), np.arange(n, over.shape[1])] = 1.0
        y = self._dense(self.plan.t, self.step_of, over).T
        by_held = rows[:, heat.network.bound]
        seen = np.flatnonzero(by_held.any(axis=1))
        if len(seen):
            k = np.array(self.interval)[self.step_of]
            share = ((self.plan.t - self.plan.edges[k]) / self.plan.steps[k])[:, None]
            first, last = heat.h0 @ by_held[seen].T, heat.h1 @ by_held[seen].T
            y[seen] += (first[k] + share * (last - first)[k]).T
        return y

    def _account(self, heat: StepHeat, latent: LatentState, T0: Array, T1: Array) -> EnergyAccount:
        """Gauss–Legendre over every step."""
        ends, quadrature = np.array(self.t), Quadrature.empty(self.plan.network)
        half, middle = np.diff(ends)[:, None] / 2, (ends[1:] + ends[:-1])[:, None] / 2
        t, step = (middle + half * NODES).ravel(), np.repeat(np.arange(len(ends) - 1), len(NODES))
        T, u = self.lumps(heat, latent, t, np.array(self.interval)[step], self._dense(t, step))
        quadrature.add(T, u, np.array(self.modes)[step], (half * WEIGHTS).ravel())
        return quadrature.account(T0, T1)
