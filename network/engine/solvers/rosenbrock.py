"""Networks that are not linear in temperature, step by step: RODAS, restarted at every input change and switching.

What a step is worth at an input's jump is known from the one before: after it the step of then is tried first.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.channels import Readouts
from network.engine.solvers import rodas
from network.engine.solvers.frozen_slopes import FrozenSlopes
from network.engine.solvers.latent_state import LatentState
from network.engine.solvers.plan import Plan
from network.engine.solvers.relay_modes import RelayModes
from network.engine.solvers.slope_layout import Dense, lay_out
from network.engine.solvers.step_courses import RosenbrockSolution, Steps
from network.engine.solvers.step_heat import StepHeat
from network.platform.refusal import Failed

SMALLEST_STEP = 1e-9
FIRST_STEP = 1.0
"""s: tried at the start."""
JUMP = 1e-12
"""Of an input, relative, which is none."""
SETTLED, ROUNDS = 1e-11, 50
"""Of a massless junction at the start: the step of Newton's method that no longer matters, and how many at most."""
SLIVER = 1e-4
"""Share of a step over which the heat's own change in time is taken."""


def solve(
    plan: Plan, readouts: Readouts, rtol: float = 1e-7, progress: Callable[[float], None] | None = None
) -> RosenbrockSolution:
    """Integrates a plan. Raises Failed where a step gets too small, or relays switch without end."""
    run = _Run(plan, readouts, rtol)
    run.integrate(progress)
    return run.steps.solution(run.heat, run.latent, readouts, run.relays.switches)


def _grow(size: float) -> float:
    """How much longer the next step is, from the error of one over the tolerance."""
    return float(np.clip(0.9 * size**-0.25, 0.2, 5.0)) if size > 0 else 5.0


class _Run:
    """Of states x: what the solved lumps are followed by, then the states of sensors."""

    def __init__(self, plan: Plan, readouts: Readouts, tolerance: float) -> None:
        self.plan, self.readouts, self.tolerance = plan, readouts, tolerance
        self.heat, self.network = StepHeat(plan), plan.network
        self.latent = LatentState(plan.network, np.isfinite(plan.network.capacity))
        self.relays, self.n = RelayModes(plan), len(self.heat.solved)
        self.mass = np.concatenate([self.network.capacity[self.heat.solved], np.ones(readouts.states)])
        self.steps = Steps(plan)
        self._lay_out()

    def _lay_out(self) -> None:
        """Where the slopes of all laws and sensors stand."""
        r, n = self.readouts, self.n
        rows, columns = self.heat.pattern()
        sensed = np.hstack([r.state_T[:, self.heat.solved], r.state_z])
        i, j = np.nonzero(sensed)
        self.layout = lay_out(n + r.states, np.concatenate([rows, i + n]), np.concatenate([columns, j]))
        self.sensed = np.zeros(self.layout.count)
        self.sensed[self.layout.places(i + n, j)] = sensed[i, j]
        places = [self.layout.places(i, j) for bent in self.heat.bent for i, j, _, _ in bent.entries]
        self.bent_places = np.concatenate([np.zeros(0, int), *places])
        self.known: dict[object, Array] = {}
        self.frozen = FrozenSlopes(self._rate, self.mass, self.layout) if isinstance(self.layout, Dense) else None

    # -- the system, sensor states included ---------------------------------------------------------------------------
    def _rate(self, t: float, x: Array) -> Array:
        r, solved = self.readouts, self.latent.temperature(x[: self.n])
        into = self.heat.into(t, solved)
        if not r.states:
            return into
        T = self.heat.lumps(t, solved)
        return np.concatenate([into, r.state_T @ T + r.state_z @ x[self.n :] + r.state_constant])

    def _slopes(self, t: float, x: Array) -> Array:
        """∂rate/∂x, as laid out."""
        solved = self.latent.temperature(x[: self.n])
        slopes, bent = self._straight_slopes(), self.heat.bent_slopes(t, solved)
        if bent:
            slopes = slopes + np.bincount(self.bent_places, np.concatenate(bent), self.layout.count)
        soft = self.latent.softening(solved)
        if soft is not None:
            slopes = slopes * np.concatenate([soft, np.ones(self.readouts.states)])[self.layout.column]
        return np.asarray(slopes)

    def _straight_slopes(self) -> Array:
        if self.heat.key not in self.known:
            slopes, K = self.sensed.copy(), self.heat.matrix
            i, j = np.nonzero(K)
            slopes[self.layout.places(i, j)] += K[i, j]
            self.known[self.heat.key] = slopes
        return self.known[self.heat.key]

    def _lumps(self, t: float, x: Array) -> Array:
        return self.heat.lumps(t, self.latent.temperature(x[: self.n]))

    def _start(self) -> Array:
        """Free lumps at T0, relays as their guards say, junctions where no heat stays in them, sensors settled."""
        self.heat.enter(0, self.relays.on)
        t0, T0 = float(self.plan.edges[0]), self.plan.T0[self.heat.solved]
        x = np.concatenate([self.latent.state(T0), np.zeros(self.readouts.states)])
        self._settle(t0, x)
        if len(self.relays):
            self.relays.begin(self._lumps(t0, x), self.heat.inputs(t0))
            self.heat.enter(0, self.relays.on)
            self._settle(t0, x)
        if self.readouts.states:
            x[self.n :] = self.readouts.start_states(self._lumps(t0, x))
        return x

    def _settle(self, t: float, x: Array) -> None:
        light = np.flatnonzero(self.mass == 0)
        rows, columns = (at.ravel() for at in np.meshgrid(light, light, indexing="ij"))
        for _ in range(ROUNDS if len(light) else 0):
            slopes = self._among(rows, columns, self._slopes(t, x)).reshape(len(light), len(light))
            move = np.linalg.solve(slopes, self._rate(t, x)[light])
            x[light] -= move
            if np.abs(move).max() < SETTLED * (1 + np.abs(x[light]).max()):
                return

    def _among(self, rows: Indices, columns: Indices, slopes: Array) -> Array:
        """Slopes of some rows by some columns, zero where none can stand."""
        i, j = self.heat.pattern()
        there = set(zip(i.tolist(), j.tolist(), strict=True))
        known = np.array([pair in there for pair in zip(rows.tolist(), columns.tolist(), strict=True)])
        found = np.zeros(len(rows))
        found[known] = slopes[self.layout.places(rows[known], columns[known])]
        return found

    # -- stepping -----------------------------------------------------------------------------------------------------
    def integrate(self, progress: Callable[[float], None] | None) -> None:
        x, plan, self.after_jump = self._start(), self.plan, FIRST_STEP
        h = self.after_jump
        self.steps.begin(float(plan.edges[0]), x)
        for k in range(len(plan.steps)):
            if self._jumps(k):
                h = min(h, self.after_jump)
            x, h = self._cross_interval(k, x, h)
            if progress:
                progress(float(plan.edges[k + 1]))

    def _jumps(self, k: int) -> bool:
        """Whether an input jumps at the beginning of interval k."""
        sides = ((a[k], self.plan.right[name][k - 1]) for name, a in self.plan.left.items() if name != "time")
        return k > 0 and any(abs(after - before) > JUMP * (1 + abs(after)) for after, before in sides)

    def _cross_interval(self, k: int, x: Array, h: float) -> tuple[Array, float]:
        t, end, is_first = float(self.plan.edges[k]), float(self.plan.edges[k + 1]), self._jumps(k)
        self.heat.enter(k, self.relays.on)
        while t < end:
            if len(self.relays):
                self.relays.note(t, self._lumps(t, x), self.heat.inputs(t))
                if self.relays.switch_due(t):
                    self.heat.enter(k, self.relays.on)
                    h, is_first = min(h, self.after_jump), True
                    continue
            x, t, h, took = self._step(k, t, x, h, self.relays.next_due(t, end))
            if is_first:
                self.after_jump, is_first = took, False
        return x, h

    def _step(self, k: int, t: float, x: Array, h: float, end: float) -> tuple[Array, float, float, float]:
        """One accepted step: new state, instant, the step to try next, and the one taken."""
        rate = self._rate(t, x)
        return self._step_frozen(k, t, x, h, end, rate) or self._step_anew(k, t, x, h, end, rate)

    def _step_anew(
        self, k: int, t: float, x: Array, h: float, end: float, rate: Array
    ) -> tuple[Array, float, float, float]:
        """With slopes from there."""
        slopes = self._slopes(t, x)
        if self.frozen is not None:
            self.frozen.renew(slopes)
        drift, sliver = None, SLIVER * min(h, end - t)
        if not self.heat.is_steady:
            drift = (self._rate(t + sliver, x) - rate) / sliver
        while True:
            is_last = h >= (end - t) * (1 - 1e-10)
            step = end - t if is_last else h
            made = rodas.step(self._rate, self.mass, self.layout, t, x, step, rate, slopes, drift)
            size = rodas.size_error(made[2], x, made[0], self.tolerance)
            factor = _grow(size)
            if size <= 1:
                break
            h = step * min(factor, 0.9) if np.isfinite(size) else step * 0.2
            self._check_step(h, t, x)
        took = self._stop_at_crossing(t, x, step, made)
        if took is not None:
            step, is_last = took, False
            made = rodas.step(self._rate, self.mass, self.layout, t, x, step, rate, slopes, drift)
        now = end if is_last else t + step
        self.steps.keep(k, now, made[0], made[1], self.relays.on)
        return made[0], now, max(h, step * factor) if is_last or took is not None else step * factor, step

    def _step_frozen(
        self, k: int, t: float, x: Array, h: float, end: float, rate: Array
    ) -> tuple[Array, float, float, float] | None:
        """The rest of an interval that is shorter than a step, on the slopes of an earlier one; None where these do not
        hold, or a guard is crossed in it."""
        step = end - t
        if self.frozen is None or h < step * (1 - 1e-10) or self.heat.is_steady:
            return None
        made = self.frozen.step(t, x, step, rate, self.tolerance)
        if made is None or self._find_crossing(t, x, step, made[0], made[1]) is not None:
            return None
        after, bend, size = made
        self.steps.keep(k, end, after, bend, self.relays.on)
        return after, end, max(h, step * _grow(size)), step

    def _stop_at_crossing(self, t: float, x: Array, h: float, made: tuple[Array, rodas.Bend, Array]) -> float | None:
        """How far the step goes until a guard is crossed, which is noted; None where none is."""
        found = self._find_crossing(t, x, h, made[0], made[1])
        if found is None:
            return None
        share, relay = found
        self.relays.pending[relay] = t + share * h + float(self.relays.pauses[relay])
        return share * h

    def _find_crossing(self, t: float, x: Array, h: float, after: Array, bend: rodas.Bend) -> tuple[float, int] | None:
        """The share of the step at which a guard is crossed, and which; None where none is."""
        if len(self.relays) == len(self.relays.pending):
            return None

        def seen(s: Array) -> tuple[Array, dict[str, Array]]:
            states = rodas.between(s[:, None], x, after, bend)
            k = np.full(len(s), self.heat.k)
            return self.steps.lumps(self.heat, self.latent, t + s * h, k, states)

        found = self.relays.first_crossing(seen, h)
        return None if found is None or found[0] * h < SMALLEST_STEP else found

    def _check_step(self, h: float, t: float, x: Array) -> None:
        if not h >= SMALLEST_STEP:
            hot = float(np.abs(x).max())
            raise Failed(
                f"the integration stopped at {t:.6g} s with {hot:.3g} degC; "
                "a heat source that grows with its own temperature runs away like this"
            )
