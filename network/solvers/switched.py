"""Relays in affine networks: where they switch, from the closed form of the modes.

Between two switchings everything is linear, so temperatures at all edges ahead come from one scan, and a bound on the
curvature of the mode sum tells which intervals cannot hold a crossing. The others are searched ever finer until the
bound clears them or a root is bracketed, so no crossing is missed, however short. What comes out is a plan whose
intervals end at the switchings and know their modes: the modal path then does the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import brentq

from network.balance import relay_slices, source_series
from network.channels import Readouts
from network.declare import Array, Indices
from network.mechanisms.base import Inputs
from network.refusal import Failed
from network.solvers.linear import LinearProblem, reduce
from network.solvers.modal import WORST_CONDITION, Modes, modes_of, phi, scan
from network.solvers.plan import SAME_INSTANT, Plan

AHEAD = 256
"""Intervals looked at in one scan."""
POINTS = 16
"""Pieces that a suspect interval is cut into at each refinement."""
INSTANT = 1e-9
"""s: how exactly a crossing is found, and the shortest piece that is still searched."""
MOST_SWITCHES = 100_000


@dataclass(frozen=True)
class Switching:
    """A plan whose intervals know their relay modes, and the switchings found: (instant, relay, new mode)."""

    plan: Plan
    switches: tuple[tuple[float, int, int], ...]


def find(plan: Plan, readouts: Readouts, progress: Callable[[float], None] | None = None) -> Switching | None:
    """The switchings of a plan; None where its modes are too badly conditioned for the closed form."""
    relays = sum(group.into.shape[1] for group in plan.network.relays)
    problem = reduce(replace(plan, modes=np.zeros((len(plan.steps), relays))), readouts)
    modes = [modes_of(regime, problem.scale) for regime in problem.regimes]
    if max(m.condition for m in modes) > WORST_CONDITION:
        return None
    return _Search(problem, modes, relays).run(progress)


@dataclass
class _Stretch:
    """Some intervals ahead with one set of relay modes: edges, and modal state, forcing and slope at each left edge."""

    k: int
    edges: Array
    m: Array
    p: Array
    r: Array
    end: Array
    modes: Modes


@dataclass
class _Search:
    """Walks through the run from switching to switching."""

    problem: LinearProblem
    modes: list[Modes]
    count: int
    switches: list[tuple[float, int, int]] = field(default_factory=list)
    edges: list[float] = field(default_factory=list)
    history: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        plan, problem = self.problem.plan, self.problem
        self.plan, self.network = plan, plan.network
        self.pauses = np.concatenate(
            [np.broadcast_to(np.asarray(g.law.pause(), float), g.into.shape[1]) for g in self.network.relays]
        )
        self.on = np.zeros(self.count)
        self.pending: dict[int, float] = {}
        self.pushes = [self._pushes(u) for u in plan.just_inside]
        self.reads = [R for group in self.network.relays for R in group.reads]
        self.needs = sorted({name for group in self.network.relays for name in group.law.needs()} | {"time"})
        self.watch = [self._watch_rows(r) for r in range(len(problem.regimes))]
        self.direct = [self._direct(side) for side in (0, 1)]

    def _pushes(self, u: Inputs) -> Array:
        """What each relay adds to dx/dt while on, at one side of every interval: (K, relays, n)."""
        K = len(self.plan.steps)
        heat = np.concatenate([source_series(g, u, None, K) for g in self.network.relays], axis=1)
        into = np.concatenate([g.into for g in self.network.relays], axis=1)
        push = np.empty((K, self.count, self.problem.order))
        for r, regime in enumerate(self.problem.regimes):
            mine = self.problem.regime_of == r
            push[mine] = heat[mine][:, :, None] * (regime.F_heat @ into).T
        return push

    def _watch_rows(self, r: int) -> Array:
        """What the relays read, as rows over the modes of regime r: (fields · relays, modes)."""
        regime = self.problem.regimes[r]
        return np.vstack([R @ regime.P for R in self.reads]) @ self.modes[r].V

    def _direct(self, side: int) -> Array:
        """What held nodes and heated junctions add to the readings at one side of every interval."""
        forcing, rows = self.problem.forcing, np.vstack(self.reads)
        direct = np.empty((len(self.plan.steps), len(rows)))
        for r, regime in enumerate(self.problem.regimes):
            mine = self.problem.regime_of == r
            held, heat = forcing.held[side][mine], forcing.heat[side][mine]
            direct[mine] = held @ (rows @ regime.P_held).T + heat @ (rows @ regime.P_heat).T
        return direct

    def run(self, progress: Callable[[float], None] | None) -> Switching:
        x, k, t, end = self.problem.x0, 0, float(self.plan.edges[0]), float(self.plan.edges[-1])
        self._switch_on_at_start(x)
        while t < end - SAME_INSTANT:
            due = min(self.pending.values(), default=np.inf)
            stretch = self._ahead(x, k, t, due)
            k, t, x = self._until_crossing(stretch)
            self._switch_due(t)
            if progress:
                progress(t)
        self.edges.append(end)
        plan = self.plan
        edges, modes = np.array(self.edges), np.array(self.history)
        at = np.clip(np.searchsorted(plan.edges, (edges[1:] + edges[:-1]) / 2) - 1, 0, len(plan.steps) - 1)
        share = [(side - plan.edges[at]) / plan.steps[at] for side in (edges[:-1], edges[1:])]
        left, right = ({n: a[at] + s * (plan.right[n] - a)[at] for n, a in plan.left.items()} for s in share)
        return Switching(replace(plan, edges=edges, left=left, right=right, modes=modes), tuple(self.switches))

    # -- one stretch ------------------------------------------------------------------------------------------------
    def _ahead(self, x: Array, k: int, t: float, due: float) -> _Stretch:
        """The next intervals of one regime, up to a switching that is due."""
        problem, plan = self.problem, self.plan
        regime = int(problem.regime_of[k])
        others = np.flatnonzero(problem.regime_of[k : k + AHEAD] != regime)
        last = k + (int(others[0]) if len(others) else min(AHEAD, len(plan.steps) - k))
        edges = plan.edges[k : last + 1].copy()
        edges[0] = t
        if due < edges[-1]:
            edges = np.append(edges[: int(np.searchsorted(edges, due))], due)
        n, modes = len(edges) - 1, self.modes[regime]
        f0, f1 = (
            f[k : k + n] + np.tensordot(push[k : k + n], self.on, (1, 0))
            for f, push in zip((problem.f0, problem.f1), self.pushes, strict=True)
        )
        slope = (f1 - f0) / plan.steps[k : k + n, None]
        f0 = f0 + slope * (edges[:-1] - plan.edges[k : k + n])[:, None]
        h, p, r = np.diff(edges)[:, None], f0 @ modes.W.T, slope @ modes.W.T
        one, two, _ = phi(-modes.rates * h)
        m, end = scan(np.exp(-modes.rates * h), h * one * p + h * h * two * r, modes.W @ x)
        return _Stretch(k, edges, m, p, r, end, modes)

    def _until_crossing(self, s: _Stretch) -> tuple[int, float, Array]:
        """Walks the stretch up to the first crossing; notes its intervals. Gives interval, instant and states there."""
        n, crossed = len(s.edges) - 1, None
        for i in self._suspects(s):
            crossed = self._first_crossing(s, i)
            if crossed is not None:
                n = i + 1
                break
        t = float(s.edges[n]) if crossed is None else crossed[0]
        self._note(s.edges[:n], t)
        if crossed is not None:
            for j in crossed[1]:
                self.pending[j] = t + float(self.pauses[j])
            x = np.real(s.modes.V @ self._state(s, n - 1, np.array([t - s.edges[n - 1]]))[0])
        else:
            x = np.real(s.modes.V @ s.end)
        k = s.k + n - (0 if t >= self.plan.edges[s.k + n] - SAME_INSTANT else 1)
        return k, t, x

    def _note(self, starts: Array, t: float) -> None:
        for start in starts.tolist():
            if start < t - SAME_INSTANT and (not self.edges or start > self.edges[-1] + SAME_INSTANT):
                self.edges.append(start)
                self.history.append(self.on.copy())

    def _state(self, s: _Stretch, i: int, tau: Array) -> Array:
        z = -s.modes.rates * tau[:, None]
        one, two, _ = phi(z)
        return np.asarray(np.exp(z) * s.m[i] + tau[:, None] * one * s.p[i] + tau[:, None] ** 2 * two * s.r[i])

    def _guards(self, s: _Stretch, i: Indices, tau: Array, m: Array) -> Array:
        """Guards of all relays (points × relays) at tau within the intervals i of a stretch, where the modal states are
        m; a relay that is about to switch has none."""
        k = s.k + i
        share = ((s.edges[i] + tau - self.plan.edges[k]) / self.plan.steps[k])[:, None]
        u = {n: self._between(self.plan.left[n], self.plan.right[n], k, share[:, 0])[:, None] for n in self.needs}
        T = np.real(m @ self.watch[int(self.problem.regime_of[s.k])].T)
        T = T + self._between(self.direct[0], self.direct[1], k, share)
        values, first = np.empty((len(tau), self.count)), 0
        for group, part in relay_slices(self.network):
            fields, width = len(group.reads), part.stop - part.start
            readings = [T[:, first + f * width : first + (f + 1) * width] for f in range(fields)]
            values[:, part], first = group.law.guard(self.on[part], u, *readings), first + fields * width
        values[:, list(self.pending)] = -np.inf
        return values

    @staticmethod
    def _between(left: Array, right: Array, k: Indices, share: Array) -> Array:
        return np.asarray(left[k] + share * (right[k] - left[k]))

    def _suspects(self, s: _Stretch) -> Iterator[int]:
        """Intervals in which a guard may rise above zero."""
        n = len(s.edges) - 1
        all_of = np.arange(n)
        left = self._guards(s, all_of, np.zeros(n), s.m)
        right = self._guards(s, all_of, np.diff(s.edges), np.vstack([s.m[1:], s.end]))
        bound = np.maximum(left, right) + np.diff(s.edges)[:, None] ** 2 / 8 * self._curvature(s)
        return iter(np.flatnonzero((bound > 0).any(axis=1)).tolist())

    def _curvature(self, s: _Stretch) -> Array:
        """Bound on |d²T/dt²| of what each relay watches, over each interval: every mode's share at its start."""
        rates, rows = s.modes.rates, np.abs(self.watch[int(self.problem.regime_of[s.k])])
        sway = np.abs(rates**2 * s.m - rates * s.p + s.r) @ rows.T
        bound, first = np.zeros((len(sway), self.count)), 0
        for group, part in relay_slices(self.network):
            width = part.stop - part.start
            for _ in group.reads:
                bound[:, part] += sway[:, first : first + width]
                first += width
        return bound

    def _first_crossing(self, s: _Stretch, i: int) -> tuple[float, list[int]] | None:
        """The first instant in interval i at which a guard is above zero, and the relays; None if there is none."""
        curvature = self._curvature(s)[i]

        def at(tau: Array) -> Array:
            return self._guards(s, np.full(len(tau), i), tau, self._state(s, i, tau))

        tau = self._search(at, 0.0, float(s.edges[i + 1] - s.edges[i]), curvature)
        if tau is None:
            return None
        values = at(np.array([tau]))[0]
        return float(s.edges[i]) + tau, np.flatnonzero(values >= min(0.0, values.max())).tolist()

    def _search(self, at: Callable[[Array], Array], a: float, b: float, curvature: Array) -> float | None:
        tau = np.linspace(a, b, POINTS + 1)
        values = at(tau)
        if (values[0] > 0).any():
            return a
        spare = (tau[1] - tau[0]) ** 2 / 8 * curvature
        for j in range(POINTS):
            if (values[j + 1] > 0).any():
                return float(brentq(lambda x: float(at(np.array([x])).max()), tau[j], tau[j + 1], xtol=INSTANT))
            may = (np.maximum(values[j], values[j + 1]) + spare > 0).any()
            if may and tau[1] - tau[0] > INSTANT * POINTS:
                found = self._search(at, float(tau[j]), float(tau[j + 1]), curvature)
                if found is not None:
                    return found
        return None

    # -- switching --------------------------------------------------------------------------------------------------
    def _switch_on_at_start(self, x: Array) -> None:
        """A relay whose guard is already crossed begins switched on."""
        regime = int(self.problem.regime_of[0])
        modes = self.modes[regime]
        m = (modes.W @ x)[None]
        first = _Stretch(0, self.plan.edges[:2], m, np.zeros(1), np.zeros(1), m[0], modes)
        self.on = (self._guards(first, np.zeros(1, int), np.zeros(1), m)[0] > 0).astype(float)

    def _switch_due(self, t: float) -> None:
        for j, due in list(self.pending.items()):
            if due <= t + SAME_INSTANT:
                self.on[j] = 1.0 - self.on[j]
                self.switches.append((t, j, int(self.on[j])))
                del self.pending[j]
        if len(self.switches) > MOST_SWITCHES:
            raise Failed(f"a relay switched {MOST_SWITCHES} times by {t:.4g} s; give it a wider hysteresis or a delay")
