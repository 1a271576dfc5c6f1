"""Rounds of a bent course: the windows in which its laws are straight, and the heat beside these until it agrees."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.balance import heat_into, jacobian
from network.engine.channels import Readouts
from network.engine.entry_groups import Flows
from network.engine.response.bent_layout import Begun, lay_out
from network.engine.response.heat_sensitivity import inputs_at_ends
from network.engine.response.latent_heat import Latent
from network.engine.response.linear_run import LinearRun, solve
from network.engine.response.nonlinear_correction import Bends, BentCourse, bends_of
from network.engine.response.nonlinear_laws import (
    Group,
    Slopes,
    among,
    find_bent_groups,
    find_lumps_read,
    heat_along,
    heat_of,
    loosen,
    slopes_of_group,
    spread_of,
    windows,
)
from network.engine.response.output_map import map_outputs
from network.engine.response.segments import Push
from network.engine.solvers.elimination import Regime
from network.engine.solvers.modal import Modes
from network.engine.solvers.plan import Plan

ROUNDS, CLOSE = 25, 2e-6
"""Rounds at most, and the change [K] at which a run agrees with itself."""
COLDEST, HOTTEST = -200.0, 1500.0
"""°C between which laws are linearised, however far off the rounds may be."""

Guess = tuple[Array, Array]
"""Temperatures at both ends of the intervals from a run nearby (K, N)."""


class Rounds:
    """A course as it is found from a guess. begun: the runs in it; sources_too: whether what sources that read
    temperatures bring is straight in the windows, too."""

    def __init__(
        self, begun: Begun, plan: Plan, readouts: Readouts, guess: Guess | None, known: dict[bytes, Modes],
        sources_too: bool,
    ) -> None:  # fmt: skip
        self.begun, self.plan, self.readouts, self.network, self.known = begun, plan, readouts, plan.network, known
        self.u, K = inputs_at_ends(plan), len(plan.steps)
        self.held = plan.evaluate_held(plan.left), plan.evaluate_held(plan.right)
        if guess is not None and len(guess[0]) == K:
            self.T = np.concatenate(guess)
        else:
            self.T = np.nan_to_num(begun.temperatures)
        self.T[:, self.network.bound] = np.concatenate(self.held)
        self.modes = np.zeros((2 * K, sum(r.into.shape[1] for r in self.network.relays)))
        if plan.modes is not None:
            self.modes = np.concatenate([plan.modes] * 2)
        self.bent = find_bent_groups(self.network)
        out = [] if sources_too else [g for g in self.bent if not isinstance(g, Flows)]
        self.inside = [g for g in self.bent if not any(g is other for other in out)]
        self.straight = replace(self.network, heats=tuple(h for h in self.network.heats if not among(h, out)))
        self.latent = Latent.of(self.network)
        self.stretch = np.ones((2 * K, len(self.latent.lumps)))
        self.touched, self.change = find_lumps_read(self.network, self.bent), np.inf
        if self.network.melting:
            self.touched = np.flatnonzero(np.isfinite(self.network.capacity))

    def course(self, times: int) -> BentCourse | None:
        """The run; None where it does not settle."""
        for _ in range(times):
            T = np.nan_to_num(self.T, nan=self.network.machine.reference)
            self.T = np.where(self.network.is_state, T, np.clip(T, COLDEST, HOTTEST))
            stretch = np.log(self.latent.stretch(self.T))
            slopes = [slopes_of_group(g, self.T, self.u) for g in self.inside]
            melts = [stretch / np.maximum(np.abs(stretch).max(axis=0), 1e-30)] if self.network.melting else []
            loose = loosen(self.inside, slopes, self._find_hold())
            of = windows([loose, *melts], len(self.plan.steps), len(self.begun.runs))
            mine = [np.flatnonzero(of == w) for w in range(int(of.max()) + 1)]
            middles = [self._middle(at) for at in mine]
            wide = [np.exp(stretch[np.concatenate([at, at + len(of)])].mean(axis=0)) for at in mine]
            regimes = [self.latent.find_regime(s, jacobian(self.straight, *at), self.readouts)
                       for s, at in zip(wide, middles, strict=True)]  # fmt: skip
            self.stretch = np.array(wide)[np.concatenate([of, of])]
            reference = [self._reference(g, of, middles) for g in self.bent]
            heat = self._beside(regimes, of)
            course = self._solve(regimes, of, heat)
            if self._settle(course, reference, heat):
                course = self._solve(regimes, of, heat, course)
                heat += self._bulge(course, reference)
                bulged = self._solve(regimes, of, heat, course)
                if not self._settle(bulged, reference, heat):
                    continue
                course = self._solve(regimes, of, heat, course)
                self.T = np.concatenate(course.T)
                now = (slopes_of_group(g, self.T, self.u) for g in self.bent)
                off = [(g, tuple(s - r for s, r in zip(own, ref, strict=True)))
                       for g, own, ref in zip(self.bent, now, reference, strict=True)]  # fmt: skip
                return self._bend(course, bends_of(self.network, off), of)
        return None

    def _bend(self, course: LinearRun, bends: Bends, of: Indices) -> BentCourse:
        """The course with what laws and latent heat answer besides."""
        melts = None
        if self.network.melting:
            into, both = self._find_heat(), np.concatenate([of, of])
            bends = bends.beside(self.latent.bends(self.T, into, self.stretch, course.problem.regimes, both))
            melts = self.latent.lumps, self.latent.gain(self.T, self.stretch)
        bent = BentCourse(course.problem, course.modes, course.x0, course.x1, bends, melts, restarts=course.restarts)
        kept = ("stretches", "segments", "modal_ends", "T")
        bent.__dict__.update({name: course.__dict__[name] for name in kept if name in course.__dict__})
        return bent

    def _find_heat(self) -> Array:
        """Heat into all lumps at the temperatures assumed (2 K, N)."""
        return heat_into(self.network, self.T, self.u, self.modes)

    def _find_latent(self) -> Array:
        """What parts that melt get beside their windows, as a heat (2 K, m)."""
        return self.latent.heat(self.T, self._find_heat(), self.stretch) if self.network.melting else self.stretch

    def _settle(self, course: LinearRun, reference: list[Slopes], heat: Array) -> bool:
        """Corrects the heat, in place, until the touched lumps stay where they are; whether they do."""
        K, spread = len(self.plan.steps), np.vstack([*(spread_of(g) for g in self.bent), self.latent.spread])
        lumps = np.flatnonzero(spread.any(axis=0))
        output_map = map_outputs(course.problem, np.eye(self.network.size)[self.touched])
        before, latent = [self._heats(g) for g in self.bent], self._find_latent()
        T = np.concatenate(course.T)
        self.T, moved, last = T, T - self.T, np.inf
        for _ in range(ROUNDS):
            now, stored = [self._heats(g) for g in self.bent], self._find_latent()
            more = np.hstack([*(n - b - heat_along(g, r, moved) for g, n, b, r in
                                zip(self.bent, now, before, reference, strict=True)), stored - latent])  # fmt: skip
            heat += more @ np.where(np.isinf(self.network.capacity), 0.0, spread)
            push = Push(lumps, more[:K], more[K:], (), spread[:, lumps])
            moved = np.zeros_like(T)
            moved[:, self.touched] = course.ends([push], output_map)[0].T
            self.change, before, latent = float(np.abs(moved).max()), now, stored
            if not np.isfinite(self.change) or self.change > max(0.9 * last, 1e3):
                return False
            self.T, last = self.T + moved, self.change
            if self.change < CLOSE:
                return True
        return False

    def _bulge(self, course: LinearRun, reference: list[Slopes]) -> Array:
        """What bent laws give in the middle of an interval beside a straight line between its ends, as a heat with the
        same integral (2 K, N): temperatures go by cubics, from their rates at both ends."""
        K, free, network = len(self.plan.steps), self.network.free, self.network
        (T0, T1), (d0, d1) = course.T, (rate[:, : len(free)] for rate in course.rates)
        middle = (T0 + T1) / 2
        middle[:, free] += self.plan.steps[:, None] / 8 * (d0 - d1)
        u = {name: (values[:K] + values[K:]) / 2 for name, values in self.u.items()}
        total = np.zeros((K, network.size))
        for group, slopes in zip(self.bent, reference, strict=True):
            q0, q1 = (heat_of(group, T, {n: v[at] for n, v in self.u.items()})
                      for T, at in ((T0, slice(K)), (T1, slice(K, None))))  # fmt: skip
            off = 2 * heat_of(group, middle, u) - q0 - q1
            off -= heat_along(group, tuple(s[: len(off)] for s in slopes), 2 * middle - T0 - T1)
            total += off / 3 @ np.where(np.isinf(network.capacity), 0.0, spread_of(group))
        if network.melting:
            into = heat_into(network, middle, u, self.modes[:K])
            at, ends = self.latent.heat(middle, into, self.stretch[:K]), self._find_latent()
            total += (2 * at - ends[:K] - ends[K:]) / 3 @ self.latent.spread
        return np.concatenate([total, total])

    def _heats(self, group: Group) -> Array:
        return heat_of(group, self.T, self.u)

    def _find_hold(self) -> Array:
        """What holds every lump where it is, in the middle of all [W/K]; nothing moves one whose temperature is
        given."""
        everywhere = jacobian(self.straight, *self._middle(np.arange(len(self.plan.steps))))
        return np.where(np.isinf(self.network.capacity), np.inf, np.abs(np.diag(everywhere)))

    def _middle(self, mine: Indices) -> tuple[Array, dict[str, Array], Array]:
        """Temperatures, inputs and relay modes for which a window is linearised."""
        both = np.concatenate([mine, mine + len(self.plan.steps)])
        u = {name: values[mine[len(mine) // 2], 0] for name, values in self.u.items()}
        return self.T[both].mean(axis=0), u, self.modes[mine[0]]

    def _reference(self, group: Group, of: Indices, middles: list[tuple[Array, dict[str, Array], Array]]) -> Slopes:
        """The slopes of a group that are in the windows' matrices, at both ends of the intervals."""
        if not among(group, self.inside):
            count = 2 if isinstance(group, Flows) else len(group.reads)
            return tuple(np.zeros((1, len(group.entry))) for _ in range(count))
        each = [slopes_of_group(group, T[None], {n: np.atleast_1d(v) for n, v in u.items()}) for T, u, _ in middles]
        both = np.concatenate([of, of])
        return tuple(np.concatenate([slopes[i] for slopes in each])[both] for i in range(len(each[0])))

    def _beside(self, regimes: list[Regime], of: Indices) -> Array:
        """Heat into all lumps beside what the windows' matrices give, at the temperatures assumed (2 K, N)."""
        heat = self._find_heat()
        latent = self._find_latent() @ self.latent.spread
        for w, regime in enumerate(regimes):
            mine = np.flatnonzero(of == w)
            for at in (mine, mine + len(of)):
                heat[at] -= self.T[at] @ regime.K.T
        heat += latent
        heat[:, self.network.bound] = 0.0
        return heat

    def _solve(self, regimes: list[Regime], of: Indices, heat: Array, like: LinearRun | None = None) -> LinearRun:
        problem = lay_out(self.plan, self.readouts, regimes, of, self.held, heat)
        return solve(problem, self.known, like, self.begun.starts(problem))
