"""What the relays of a run watch, and their guards, from the modal states of its reduced problem."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.balance import relay_slices, source_series
from network.engine.solvers.ahead import Ahead
from network.engine.solvers.crossing import NEVER
from network.engine.solvers.linear import LinearProblem
from network.engine.solvers.modal import Modes


class Watch:
    """The guards of all relays. Readings are rows: place by place of a law, relay by relay; heat: of every relay while
    on, just after the beginning of every interval, change: over it (K, relays) [W]; into: lumps by relays."""

    def __init__(self, problem: LinearProblem, modes: list[Modes]) -> None:
        plan, network = problem.plan, problem.plan.network
        self.plan, self.groups = plan, list(relay_slices(network))
        self.count = self.groups[-1][1].stop
        self.into = np.concatenate([group.into for group, _ in self.groups], axis=1)
        self.heat, end = (self._heat(problem, side) for side in (0, 1))
        self.change = end - self.heat
        reads = np.vstack([R for group, _ in self.groups for R in group.reads])
        self.rows = [(reads @ regime.P @ m.V).T for regime, m in zip(problem.regimes, modes, strict=True)]
        self.sizes = [self._by_relay(np.abs(rows)) for rows in self.rows]
        self.direct, end = (self._direct(problem, reads, side) for side in (0, 1))
        self.rise = end - self.direct
        self.own = [(reads @ regime.P_heat @ self.into).T for regime in problem.regimes]
        self.inputs = {n: (a, plan.right[n] - a) for n, a in plan.left.items()}
        self.sees_heat, self.sees_more = any(own.any() for own in self.own), bool(self.direct.any() or end.any())

    def _heat(self, problem: LinearProblem, side: int) -> Array:
        u, K = problem.plan.just_inside[side], len(problem.plan.steps)
        return np.concatenate([source_series(group, u, None, K) for group, _ in self.groups], axis=1)

    def _by_relay(self, columns: Array) -> Array:
        """Columns of all readings added up by relay."""
        total, first = np.zeros((len(columns), self.count)), 0
        for group, part in self.groups:
            width = part.stop - part.start
            for _ in group.reads:
                total[:, part] += columns[:, first : first + width]
                first += width
        return total

    @staticmethod
    def _direct(problem: LinearProblem, reads: Array, side: int) -> Array:
        """What held nodes and heated junctions add to the readings at one side of every interval, relays off."""
        held, heat = problem.forcing.held[side], problem.forcing.heat[side]
        direct = np.empty((len(held), len(reads)))
        for r, regime in enumerate(problem.regimes):
            mine = problem.regime_of == r
            direct[mine] = held[mine] @ (reads @ regime.P_held).T + heat[mine] @ (reads @ regime.P_heat).T
        return direct

    def curvature(self, regime: int, bends: Array) -> Array:
        """Bound on |d²T/dt²| of what each relay watches, from those of the modes."""
        return np.asarray(bends @ self.sizes[regime])

    def guards(self, s: Ahead, k: Indices | int, t: Array, m: Array, on: Array, pending: Collection[int]) -> Array:
        """All guards at t in the intervals k of the run, where the modes are m: (points, relays)."""
        inputs, T = _Inputs(self, k, t), (m @ self.rows[s.window.regime]).real
        if self.sees_more:
            T = T + self.direct[k] + inputs.share * self.rise[k]
        if self.sees_heat:
            T = T + ((self.heat[k] + inputs.share * self.change[k]) * on) @ self.own[s.window.regime]
        values, first = np.empty((len(t), self.count)), 0
        for group, part in self.groups:
            width = part.stop - part.start
            readings = [T[:, first + f * width : first + (f + 1) * width] for f in range(len(group.reads))]
            values[:, part], first = group.law.guard(on[part], inputs, *readings), first + len(group.reads) * width
        if pending:
            values[:, list(pending)] = NEVER
        return values


class _Inputs(Mapping[str, Array]):
    """The inputs (points, 1) at t in the intervals k of a run, each worked out as it is asked for."""

    def __init__(self, watch: Watch, k: Indices | int, t: Array) -> None:
        self.watch, self.k, self.t = watch, k, t

    @property
    def share(self) -> Array:
        plan = self.watch.plan
        return np.asarray((self.t - plan.edges[self.k]) / plan.steps[self.k])[:, None]

    def __getitem__(self, name: str) -> Array:
        first, change = (np.reshape(values[self.k], (-1, 1)) for values in self.watch.inputs[name])
        return np.asarray(first + self.share * change)

    def __iter__(self) -> Iterator[str]:
        return iter(self.watch.inputs)

    def __len__(self) -> int:
        return len(self.watch.inputs)


@dataclass(frozen=True)
class Within:
    """The guards in interval i of those ahead, with some relays on and some about to switch."""

    watch: Watch
    s: Ahead
    i: int
    on: Array
    pending: Collection[int]

    def values(self, tau: Array) -> Array:
        s, i = self.s, self.i
        return self.watch.guards(s, s.k + i, s.edges[i] + tau, s.within(i, tau), self.on, self.pending)

    def curvature(self, tau: Array) -> Array:
        return self.watch.curvature(self.s.window.regime, self.s.bends(self.i, tau))
