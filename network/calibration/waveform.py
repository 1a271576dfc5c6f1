"""Networks that are not linear in temperature, as linear ones with a heat that is corrected until it agrees.

In windows of time the heat balance is linearised about the run itself; what the straight law leaves out is a heat over
time, taken from the run before: T ← answer to K_w T + [Q(T_before) − K_w T_before]. Each round shrinks the error by the
ratio of what a slope varies within its window to the conductances around it. Source: waveform relaxation (Picard
iteration on whole courses), Burrage, Parallel and Sequential Methods for ODEs (1995), ch. 7; unverified.
"""

from __future__ import annotations

import numpy as np

from network.balance import heat_balance, jacobian
from network.calibration.bends import Bends, BentCourse, bends_of
from network.calibration.course import Course, solve
from network.calibration.partials import inputs_at_ends
from network.channels import Readouts
from network.declare import Array, Indices
from network.graph import Flows, Heats, Network
from network.mechanisms.base import Source
from network.refusal import Failed
from network.solvers.linear import Forcing, LinearProblem, Regime, reduce, regime_from
from network.solvers.modal import Modes
from network.solvers.plan import Plan

BEND = 0.15
"""Of a slope's largest value: how far it may move within a window."""
ROUNDS, CLOSE = 60, 2e-6
"""Rounds at most, and the change [K] at which a run agrees with itself."""
MOST_WINDOWS = 60


def course_of(
    plan: Plan, readouts: Readouts, guess: tuple[Array, Array] | None = None, known: dict[bytes, Modes] | None = None
) -> Course:
    """The run of a plan without relays, or whose relay modes are known; `guess`: temperatures at both ends of the
    intervals from a run nearby. Raises Failed where the rounds do not come together."""
    if plan.network.is_affine():
        return solve(reduce(plan, readouts), known)
    return _Rounds(plan, readouts, guess).course()


class _Rounds:
    def __init__(self, plan: Plan, readouts: Readouts, guess: tuple[Array, Array] | None) -> None:
        self.plan, self.readouts, self.network = plan, readouts, plan.network
        self.u = inputs_at_ends(plan)
        K = len(plan.steps)
        self.held = plan.held_at(plan.left), plan.held_at(plan.right)
        if guess is not None and len(guess[0]) == K:
            self.T = np.concatenate(guess)
        else:
            self.T = np.tile(np.where(np.isfinite(plan.T0), plan.T0, 0.0), (2 * K, 1))
        self.T[:, self.network.bound] = np.concatenate(self.held)
        self.modes = np.zeros((2 * K, sum(r.into.shape[1] for r in self.network.relays)))
        if plan.modes is not None:
            self.modes = np.concatenate([plan.modes] * 2)

    def course(self) -> Course:
        change = np.inf
        for k in range(ROUNDS):
            if k < 3 or k % 6 == 0:
                bent = bent_slopes(self.network, self.T, self.u)
                of = _windows(bent, len(self.plan.steps))
                regimes = [self._regime(np.flatnonzero(of == w)) for w in range(int(of.max()) + 1)]
            course = solve(self._problem(regimes, of))
            T = np.concatenate(course.T)
            before, change = change, float(np.abs(T - self.T).max())
            if not np.isfinite(change) or change > 1e6:
                break
            self.T = T if change < before or k < 3 else (T + self.T) / 2
            if change < CLOSE and k:
                return BentCourse(course.problem, course.modes, course.x0, course.x1, self._bends(of))
        off = f"still {change:.2g} K off"
        raise Failed(f"the run does not come to agree with itself ({off}): a heat source may run away")

    def _regime(self, mine: Indices) -> Regime:
        """The balance linearised at the middle of a window."""
        both = np.concatenate([mine, mine + len(self.plan.steps)])
        T = self.T[both].mean(axis=0)
        u = {name: values[mine[len(mine) // 2], 0] for name, values in self.u.items()}
        return regime_from(self.network, jacobian(self.network, T, u, self.modes[mine[0]]), self.readouts)

    def _problem(self, regimes: list[Regime], of: Indices) -> LinearProblem:
        plan, network, K = self.plan, self.network, len(self.plan.steps)
        heat = heat_balance(network, self.T, self.u, self.modes).into
        for w, regime in enumerate(regimes):
            mine = np.flatnonzero(of == w)
            for at in (mine, mine + K):
                heat[at] -= self.T[at] @ regime.K.T
        heat[:, network.bound] = 0.0
        n = len(network.free) + self.readouts.states
        f0, f1 = np.empty((K, n)), np.empty((K, n))
        for w, regime in enumerate(regimes):
            mine = np.flatnonzero(of == w)
            for f, held, at in ((f0, self.held[0], mine), (f1, self.held[1], mine + K)):
                f[mine] = held[mine] @ regime.F_held.T + heat[at] @ regime.F_heat.T
                f[mine, len(network.free) :] += self.readouts.state_constant
        forcing = Forcing(self.held, (heat[:K], heat[K:]), ())
        first = regimes[int(of[0])]
        x0 = np.concatenate([plan.T0[network.free], np.zeros(self.readouts.states)])
        if self.readouts.states:
            T = first.P @ x0 + first.P_held @ self.held[0][0] + first.P_heat @ heat[0]
            x0[len(network.free) :] = self.readouts.start_states(T)
        scale = np.concatenate([np.sqrt(network.capacity[network.free]), np.ones(self.readouts.states)])
        return LinearProblem(plan, self.readouts, tuple(regimes), of, forcing, f0, f1, x0, scale)

    def _bends(self, of: Indices) -> Bends:
        """Slopes at both ends less those at which the windows were linearised."""
        now = bent_slopes(self.network, self.T, self.u)
        off = [(g, tuple(s - self._in_windows(g, i, of, s) for i, s in enumerate(slopes))) for g, slopes in now]
        return bends_of(self.network, off)

    def _in_windows(self, group: Flows | Heats[Source], i: int, of: Indices, like: Array) -> Array:
        """The slopes by reading i at the middle of every window, laid out over the ends of the intervals."""
        K, out = len(of), np.empty_like(like)
        for w in range(int(of.max()) + 1):
            mine = np.flatnonzero(of == w)
            T = self.T[np.concatenate([mine, mine + K])].mean(axis=0)
            u = {name: values[mine[len(mine) // 2]] for name, values in self.u.items()}
            slope = _slopes(group, T[None], u)[i]
            out[mine], out[mine + K] = slope, slope
        return out


def _slopes(group: Flows | Heats[Source], T: Array, u: dict[str, Array]) -> tuple[Array, ...]:
    """Slopes of a group at many instants, each (instants, members)."""
    if isinstance(group, Flows):
        slopes: tuple[Array, ...] = group.law.slopes(T[:, group.a], T[:, group.b], u)
    else:
        slopes = group.law.slopes(u, *(T @ R.T for R in group.reads))
    return tuple(np.broadcast_to(s, (len(T), len(group.entry))) for s in slopes)


def bent_slopes(
    network: Network, T: Array, u: dict[str, Array]
) -> list[tuple[Flows | Heats[Source], tuple[Array, ...]]]:
    """The slopes of all laws that are not the same in the whole run: bent ones, and those that follow an input."""
    groups = [g for g in network.groups if not g.law.is_affine() or g.law.needs()]
    with_slopes = [g for g in groups if isinstance(g, Flows) or g.reads]
    return [(g, _slopes(g, T, u)) for g in with_slopes]


def _windows(bent: list[tuple[Flows | Heats[Source], tuple[Array, ...]]], K: int) -> Indices:
    """The window of each interval: a new one begins where a slope has moved by more than BEND of its largest."""
    parts = [slope for _, slopes in bent for slope in slopes]
    if not parts:
        return np.zeros(K, int)
    both = np.hstack(parts)
    middle = (both[:K] + both[K:]) / 2
    size = np.maximum(np.abs(middle).max(axis=0), 1e-30)
    relative = middle / size
    bend = BEND
    while True:
        of, start = np.empty(K, int), relative[0]
        w = 0
        for k in range(K):
            if np.abs(relative[k] - start).max() > bend:
                w, start = w + 1, relative[k]
            of[k] = w
        if w < MOST_WINDOWS:
            return of
        bend *= 1.5
