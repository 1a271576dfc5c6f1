"""Relays in affine networks: where they switch, from the closed form of the modes.

Between two switchings everything is linear, so temperatures at the edges ahead come from one scan, and a bound on the
curvature of the mode sum tells which intervals cannot hold a crossing. The others are searched ever finer until the
bound clears them or a root is bracketed, so no crossing is missed, however short. What comes out is a plan whose
intervals end at the switchings and know their modes: the modal path then does the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.channels import Readouts
from network.engine.solvers.ahead import Ahead, Window
from network.engine.solvers.crossing import first_crossing
from network.engine.solvers.elimination import KnownRegimes
from network.engine.solvers.guards import Watch, Within
from network.engine.solvers.linear import LinearProblem, reduce
from network.engine.solvers.modal import WORST_CONDITION, Modes, modes_of
from network.engine.solvers.plan import SAME_INSTANT, Plan
from network.engine.solvers.relay_modes import MOST_SWITCHES, RelayModes

LEAST_AHEAD, MOST_AHEAD = 8, 256
"""Intervals looked at in one scan: as many as the last switching took twice, then ever more."""


@dataclass(frozen=True)
class Switching:
    """A plan whose intervals know their relay modes, and the switchings found: (instant, relay, new mode)."""

    plan: Plan
    switches: tuple[tuple[float, int, int], ...]


def find(
    plan: Plan, readouts: Readouts, progress: Callable[[float], None] | None = None,
    known: dict[bytes, Modes] | None = None, most: int = MOST_SWITCHES, regimes: KnownRegimes | None = None,
) -> Switching | None:  # fmt: skip
    """The switchings of a plan; None where its modes are too badly conditioned for the closed form. known: modes found
    before, by the matrix of their regime, regimes: by the inputs that make them; those found here come in. Raises
    Failed from more than `most` switchings."""
    known = {} if known is None else known
    relays = plan.network.relay_count
    problem = reduce(replace(plan, modes=np.zeros((len(plan.steps), relays))), readouts, regimes)
    keys = [regime.A.tobytes() for regime in problem.regimes]
    for key, regime in zip(keys, problem.regimes, strict=True):
        known[key] = known.get(key) or modes_of(regime, problem.scale)
    modes = [known[key] for key in keys]
    if max(m.condition for m in modes) > WORST_CONDITION:
        return None
    return _Search(problem, modes, most).run(progress)


class _Search:
    """Walks through the run from switching to switching."""

    def __init__(self, problem: LinearProblem, modes: list[Modes], most: int) -> None:
        self.problem, self.plan, self.modes = problem, problem.plan, modes
        self.watch, self.relays = Watch(problem, modes), RelayModes(problem.plan, most)
        self.reach = LEAST_AHEAD
        self.edges: list[float] = []
        self.history: list[Array] = []

    def run(self, progress: Callable[[float], None] | None) -> Switching:
        t, k, end, x = float(self.plan.edges[0]), 0, float(self.plan.edges[-1]), self.problem.x0
        for window in self._windows():
            m = window.modes.W @ x
            if k == 0:
                self._switch_on_at_start(window, m)
            while k < window.last and t < end - SAME_INSTANT:
                due = min(self.relays.pending.values(), default=np.inf)
                k, t, m = self._until_crossing(window.ahead(k, t, m, self.relays.on, self.reach, due))
                self.relays.switch_due(t)
                if progress:
                    progress(t)
            x = np.real(window.modes.V @ m)
        self.edges.append(end)
        edges, modes = np.array(self.edges), np.array(self.history)
        return Switching(replace(with_edges(self.plan, edges), modes=modes), tuple(self.relays.switches))

    def _windows(self) -> Iterator[Window]:
        """All intervals of the run, some of one regime at a time."""
        regime_of, watch, first = self.problem.regime_of, self.watch, 0
        cuts = [*(np.flatnonzero(np.diff(regime_of)) + 1).tolist(), len(regime_of)]
        for cut in cuts:
            modes = self.modes[int(regime_of[first])]
            while first < cut:
                last = min(first + MOST_AHEAD, cut)
                yield Window(self.problem, modes, first, last, watch.heat, watch.change, watch.into)
                first = last

    def _until_crossing(self, s: Ahead) -> tuple[int, float, Array]:
        """Walks up to the first crossing or the last edge ahead: interval, instant, and modes there."""
        i, tau = self._first_crossing(s)
        n, m = (len(s), s.states[-1]) if tau is None else (i + 1, s.within(i, np.array([tau]))[0])
        t = float(s.edges[n] if tau is None else s.edges[i] + tau)
        self._note(s.edges[:n], t)
        if tau is not None:
            for j in self._find_crossed(s, i, tau):
                self.relays.pending[j] = t + float(self.relays.pauses[j])
        self.reach = max(2 * n, LEAST_AHEAD)
        return s.k + n - (0 if t >= self.plan.edges[s.k + n] - SAME_INSTANT else 1), t, m

    def _first_crossing(self, s: Ahead) -> tuple[int, float | None]:
        """The first interval ahead in which a guard rises above zero, and when in it; None if there is none."""
        left, right = self._at_edges(s)
        steps, curvature = s.edges[1:] - s.edges[:-1], self.watch.curvature(s.window.regime, s.first_bends)
        bound = np.maximum(left, right) + steps[:, None] ** 2 / 8 * curvature
        for i in np.flatnonzero((bound > 0).any(axis=1)).tolist():
            guards = Within(self.watch, s, i, self.relays.on, self.relays.pending)
            tau = first_crossing(guards, 0.0, float(steps[i]), curvature[i])
            if tau is not None:
                return i, tau
        return len(s) - 1, None

    def _at_edges(self, s: Ahead) -> tuple[Array, Array]:
        """Guards just after and just before the edges of all intervals ahead."""
        n, k = len(s), np.arange(s.k, s.k + len(s))
        both = np.concatenate([s.states[:-1], s.states[1:]])
        t = np.concatenate([s.edges[:-1], s.edges[1:]])
        values = self.watch.guards(s, np.concatenate([k, k]), t, both, self.relays.on, self.relays.pending)
        return values[:n], values[n:]

    def _find_crossed(self, s: Ahead, i: int, tau: float) -> list[int]:
        """The relays whose guards are crossed at tau in interval i."""
        if self.watch.count == 1:
            return [0]
        values = Within(self.watch, s, i, self.relays.on, self.relays.pending).values(np.array([tau]))[0]
        return np.flatnonzero(values >= min(0.0, values.max())).tolist()

    def _note(self, starts: Array, t: float) -> None:
        for start in starts.tolist():
            if start < t - SAME_INSTANT and (not self.edges or start > self.edges[-1] + SAME_INSTANT):
                self.edges.append(start)
                self.history.append(self.relays.on)

    def _switch_on_at_start(self, window: Window, m: Array) -> None:
        """A relay whose guard is already crossed begins switched on."""
        s = window.ahead(0, float(self.plan.edges[0]), m, self.relays.on, 1, np.inf)
        self.relays.on = (self._at_edges(s)[0][0] > 0).astype(float)


def with_edges(plan: Plan, edges: Array) -> Plan:
    """The plan with other edges, which lie between its own or on them; relay modes stay what they are."""
    at = np.clip(np.searchsorted(plan.edges, (edges[1:] + edges[:-1]) / 2) - 1, 0, len(plan.steps) - 1)
    share = [(side - plan.edges[at]) / plan.steps[at] for side in (edges[:-1], edges[1:])]
    left, right = ({n: a[at] + s * (plan.right[n] - a)[at] for n, a in plan.left.items()} for s in share)
    return replace(plan, edges=edges, left=left, right=right, modes=None if plan.modes is None else plan.modes[at])
