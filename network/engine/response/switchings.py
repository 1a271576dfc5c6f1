"""Relays in a fit: where they switch, and how the switchings move as a parameter does.

A switching at t* (guard g(x, θ) = 0, then a pause) moves by dt/dθ = −(∂g/∂θ + ∇g·s)/ġ, s = ∂x/∂θ at the crossing, and
leaves a jump (ẋ before − ẋ after) dt behind. What a jump does to later crossings is the closed answer to it, so all
switchings of a run move by one triangular system. Source: sensitivity of hybrid systems, Hiskens & Pai, IEEE Trans.
Circuits Syst. I 47 (2000) 204, eq. 26-30; unverified.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.base import STEP, add_imaginary_step
from network.catalogue.mechanisms.mechanism import Inputs, Relay
from network.engine.balance import relay_slices
from network.engine.channels import Readouts
from network.engine.entry_groups import Guards, Heats, Rates
from network.engine.network import Network
from network.engine.response.linear_run import LinearRun, Push, kick, solve
from network.engine.response.parameters import Parameter
from network.engine.response.state_jumps import states_at
from network.engine.solvers import switched
from network.engine.solvers.elimination import KnownRegimes
from network.engine.solvers.linear import reduce
from network.engine.solvers.modal import Modes
from network.engine.solvers.plan import Plan, merge_instants
from network.engine.solvers.switched import with_edges
from network.platform.refusal import Failed, Spot, refuse

MOST = 2
"""Switchings for each interval between knots, beyond which a run is not followed."""
ROUNDS, CLOSE = 2, 0.5
"""Times at most that bent laws are laid straight about the means of a run, and the change of these [K] that is none."""
LEAST_RATE = 1e-7
"""K/s: a guard that creeps over zero slower than this has no switching instant to speak of."""


@dataclass(frozen=True)
class Event:
    """One switching: the interval that begins with it, the one that begins with its crossing, relay, new mode."""

    interval: int
    crossing: int
    relay: int
    mode: int


@dataclass(frozen=True, eq=False)
class Seen:
    """What one group of relays saw at its crossings: which events they are, and for each the relay of the group; mode
    (events, relays), inputs (events, 1) and readings (events, relays) before it switches."""

    group: Heats[Relay]
    events: Indices
    relay: Indices
    mode: Array
    u: Inputs
    readings: tuple[Array, ...]

    def guards(self, law: Relay, readings: Sequence[Array]) -> Array:
        """Guards of the relays that switch."""
        g = np.broadcast_to(np.asarray(law.guard(self.mode, self.u, *readings)), self.mode.shape)
        return np.asarray(g[np.arange(len(self.events)), self.relay])

    def slope(self, law: Relay, readings: Sequence[Array]) -> Array:
        """Derivative of the same by the imaginary step in a law or a reading."""
        return np.asarray(np.imag(self.guards(law, readings)) / STEP)

    def by_reading(self, i: int) -> Array:
        """∂guard/∂(reading i) at the events."""
        own = [add_imaginary_step(T, 1j * STEP) if n == i else T for n, T in enumerate(self.readings)]
        return self.slope(self.group.law, own)


@dataclass(frozen=True, eq=False)
class SwitchedCourse(LinearRun):
    """A course whose answers take the moved switchings along."""

    events: tuple[Event, ...] = ()

    def complete_pushes(self, pushes: Sequence[Push], by_guard: Array | None = None) -> Sequence[Push]:
        """Pushes with the jumps of the switchings that they move; by_guard[p, e] = ∂g/∂θ at event e, where the
        parameter behind a push moves the guards, too."""
        if not self.events or not pushes:
            return pushes
        smooth = self._guard_changes(pushes)
        right = -(smooth if by_guard is None else smooth + by_guard) / self._guard_rates
        moved = solve_triangular(self._coupling, right.T, lower=True, check_finite=False).T
        return [replace(p, jumps=(self._intervals, self._jumps * dt[:, None]))
                for p, dt in zip(pushes, moved, strict=True)]  # fmt: skip

    @cached_property
    def _coupling(self) -> Array:
        """What every switching does to later crossings, beside ones: lower triangular (events, events)."""
        jumps = zip(self._intervals.tolist(), self._jumps, strict=True)
        mutual = self._guard_changes([kick(self, jump) for jump in jumps])
        rate = self._guard_rates[:, None]
        coupling = np.where(self._intervals <= self._crossings[:, None], mutual.T, 0.0) / rate
        np.fill_diagonal(coupling, 1.0)
        return np.tril(coupling)

    @cached_property
    def _intervals(self) -> Indices:
        return np.array([e.interval for e in self.events], int)

    @cached_property
    def _crossings(self) -> Indices:
        return np.array([e.crossing for e in self.events], int)

    @cached_property
    def _jumps(self) -> Array:
        """Rates of the states before the switchings less those after them: (events, n)."""
        dx0, dx1 = self.rates
        return np.asarray(dx1[self._intervals - 1] - dx0[self._intervals])

    def _guard_changes(self, pushes: Sequence[Push]) -> Array:
        """∇g·s at the crossings, just before them: (pushes, events)."""
        dx = states_at(self, pushes, self._crossings.tolist())
        return np.asarray(np.einsum("pen,en->pe", dx, self._gradients))

    @cached_property
    def _seen(self) -> tuple[Seen, ...]:
        """What each group of relays saw at its crossings."""
        plan, groups = self.problem.plan, []
        relay, mode = (np.array([getattr(e, name) for e in self.events], int) for name in ("relay", "mode"))
        for group, part in relay_slices(plan.network):
            events = np.flatnonzero((relay >= part.start) & (relay < part.stop))
            at = self._crossings[events]
            readings = tuple(self.T[0][at] @ R.T for R in group.reads)
            before = np.repeat(1.0 - mode[events, None], part.stop - part.start, axis=1)
            u = {name: values[at, None] for name, values in plan.left.items()}
            groups.append(Seen(group, events, relay[events] - part.start, before, u, readings))
        return tuple(groups)

    @cached_property
    def guards(self) -> Array:
        """At every event; zero but for rounding, where the run switches by them."""
        values = np.empty(len(self.events))
        for seen in self._seen:
            values[seen.events] = seen.guards(seen.group.law, seen.readings)
        return values

    @cached_property
    def _gradients(self) -> Array:
        """∂g/∂(states) at every event: (events, n)."""
        problem = self.problem
        rows = np.zeros((len(self.events), problem.plan.network.size))
        for seen in self._seen:
            for i, R in enumerate(seen.group.reads):
                rows[seen.events] += seen.by_reading(i)[:, None] * R[seen.relay]
        regime_of, gradients = problem.regime_of[self._crossings], np.empty((len(rows), problem.order))
        for r in np.unique(regime_of).tolist():
            gradients[regime_of == r] = rows[regime_of == r] @ problem.regimes[r].P
        return gradients

    @cached_property
    def _guard_rates(self) -> Array:
        """dg/dt just before each crossing."""
        rates = np.einsum("en,en->e", self._gradients, self.rates[1][self._crossings - 1])
        return np.where(np.abs(rates) < LEAST_RATE, LEAST_RATE, rates)

    def is_guarded_by(self, name: str, step: float) -> bool:
        """Whether a step of an input moves a guard by itself: at a crossing, or through what is no state that a relay
        reads."""
        capacity = self.problem.plan.network.capacity
        no_state = (capacity == 0) | np.isinf(capacity)
        if any(R[:, no_state].any() for seen in self._seen for R in seen.group.reads):
            return True
        moved = [replace(seen, u={**seen.u, name: seen.u[name] + step}) for seen in self._seen]
        return any((after.guards(after.group.law, after.readings) != seen.guards(seen.group.law, seen.readings)).any()
                   for seen, after in zip(self._seen, moved, strict=True))  # fmt: skip

    def by_guard(self, parameter: Parameter, theta: float) -> Array:
        """∂g/∂θ at every event; the pause of a relay counts as a guard that comes later."""
        network, out, name = self.problem.plan.network, np.zeros(len(self.events)), str(parameter.entry)
        for seen in self._seen if self.events else ():
            for j in [j for j, entry in enumerate(seen.group.entry) if network.mechanisms[entry] == name]:
                law, mine = seen.group.law, seen.relay == j
                values = law.__dict__[parameter.attribute].astype(complex)
                values[j] += 1j * STEP
                law = law.replaced(**{parameter.attribute: values})
                later = float(np.imag(np.broadcast_to(law.pause(), len(values))[j]) / STEP)
                by_theta = seen.slope(law, seen.readings) - self._guard_rates[seen.events] * later
                out[seen.events[mine]] = parameter.slope(parameter.value(theta)) * by_theta[mine]
        return out


def check_followed(network: Network) -> None:
    """Raises Refused where a relay switches a conductance, or stands beside a state that is not linear."""
    spot, as_it_is = Spot(network.machine.file), "simulate and compare serve this machine as it is"
    for group in network.relays:
        if isinstance(group, Guards):
            wrong = f"{network.mechanisms[group.entry[0]]} ({group.law.kind}) switches a conductance"
            right = f"a fit follows relays that switch a heat; {as_it_is}"
            raise refuse(spot, f"{wrong}, which a fit cannot follow", right)
    if network.melting and network.relays:
        wrong = f"{network.tell_melting(network.melting[0])}, which a fit cannot follow beside a relay"
        raise refuse(spot, wrong, f"take the relay out; {as_it_is}")
    for rates in network.heats if network.relays else ():
        if isinstance(rates, Rates) and not rates.law.is_affine():
            wrong = f"{network.mechanisms[rates.entry[0]]} ({rates.law.kind}) is not linear"
            right = f"make it linear, or take the relay out; {as_it_is}"
            raise refuse(spot, f"{wrong}, which a fit cannot follow beside a relay", right)


def build_course_about(
    plan: Plan, readouts: Readouts, known: dict[bytes, Modes], regimes: KnownRegimes, middle: Array | None = None
) -> tuple[SwitchedCourse, Array]:
    """The run of a plan with relays, laws that are not straight by their tangents about its own mean temperatures, and
    these (N); middle: those of a run nearby. Error: of second order in how far temperatures go from their means."""
    start = np.nan_to_num(plan.T0, nan=plan.network.machine.reference)
    middle = start if middle is None or len(middle) != len(start) else middle
    if plan.network.is_affine():
        return build_switched_course(plan, readouts, known, regimes), middle
    for _ in range(ROUNDS):
        course, about = build_switched_course(replace(plan, about=middle), readouts, known, regimes), middle
        T0, T1 = course.T
        middle = course.problem.plan.steps @ (T0 + T1) / 2 / course.problem.plan.steps.sum()
        if not np.isfinite(middle).all():
            raise Failed("with its tangents the run runs away")
        if np.abs(middle - about).max() < CLOSE:
            break
    return course, about


def build_switched_course(
    plan: Plan, readouts: Readouts, known: dict[bytes, Modes] | None = None, regimes: KnownRegimes | None = None
) -> SwitchedCourse:
    """The run of a plan with relays; known: modes, regimes: of the same network, found before. Raises Failed where
    modes are too much alike."""
    known, regimes = {} if known is None else known, {} if regimes is None else regimes
    solution = switched.find(plan, readouts, known=known, most=round(MOST * len(plan.steps)), regimes=regimes)
    if solution is None:
        raise Failed("a network with relays whose modes are too much alike for the closed form cannot be fitted")
    pauses = np.concatenate(
        [np.broadcast_to(np.asarray(g.law.pause(), float), g.into.shape[1]) for g in plan.network.relays]
    )
    switchings = np.array([t for t, _, _ in solution.switches], float)
    crossings = switchings - pauses[[j for _, j, _ in solution.switches]]
    plan = _with_crossings(solution.plan, crossings)
    course = solve(reduce(plan, readouts, regimes), known)
    begins, crossed = (np.abs(plan.edges - t[:, None]).argmin(axis=1).tolist() for t in (switchings, crossings))
    events = tuple(Event(k, c, j, mode) for k, c, (_, j, mode) in zip(begins, crossed, solution.switches, strict=True)
                   if 0 < k < len(plan.steps) and 0 < c <= k)  # fmt: skip
    return SwitchedCourse(course.problem, course.modes, course.x0, course.x1, events)


def _with_crossings(plan: Plan, crossings: Array) -> Plan:
    """The plan with edges at the crossings that come before their switchings."""
    inner = crossings[(crossings > plan.edges[0]) & (crossings < plan.edges[-1])]
    edges = merge_instants(plan.edges, inner)
    return plan if len(edges) == len(plan.edges) else with_edges(plan, edges)
