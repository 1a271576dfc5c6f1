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

from network.balance import relay_slices
from network.calibration.course import Course, Push, kick, solve
from network.calibration.kicks import states_at
from network.calibration.parameters import Parameter
from network.channels import Readouts
from network.declare import Array
from network.mechanisms.base import STEP
from network.refusal import Failed
from network.solvers import switched
from network.solvers.linear import reduce
from network.solvers.modal import Modes
from network.solvers.plan import SAME_INSTANT, Plan

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
class SwitchedCourse(Course):
    """A course whose answers take the moved switchings along."""

    events: tuple[Event, ...] = ()

    def resolved(self, pushes: Sequence[Push], by_guard: Array | None = None) -> Sequence[Push]:
        """Pushes with the jumps of the switchings that they move; by_guard[p, e] = ∂g/∂θ at event e, where the
        parameter behind a push moves the guards, too."""
        if not self.events or not pushes:
            return pushes
        kicks = [kick(self, (e.interval, self._jump(e))) for e in self.events]
        smooth, mutual = self._guard_changes(pushes), self._guard_changes(kicks)
        rate = self._guard_rates
        earlier = np.array([[f.interval <= e.crossing for f in self.events] for e in self.events])
        coupling = np.where(earlier, mutual.T, 0.0) / rate[:, None]
        np.fill_diagonal(coupling, 0.0)
        right = -(smooth if by_guard is None else smooth + by_guard) / rate
        moved = solve_triangular(np.tril(coupling) + np.eye(len(rate)), right.T, lower=True).T
        jumps = [k.kicks[0] for k in kicks]
        return [replace(p, kicks=(*p.kicks, *((at, jump * dt) for (at, jump), dt in zip(jumps, moved[i], strict=True))))
                for i, p in enumerate(pushes)]  # fmt: skip

    def _jump(self, event: Event) -> Array:
        """Rate of the states before the switching less that after it."""
        dx0, dx1 = self.rates
        return np.asarray(dx1[event.interval - 1] - dx0[event.interval])

    def _guard_changes(self, pushes: Sequence[Push]) -> Array:
        """∇g·s at the crossings, just before them: (pushes, events)."""
        dx = states_at(self, pushes, [e.crossing for e in self.events])
        return np.asarray(np.einsum("pen,en->pe", dx, self._gradients))

    @cached_property
    def _gradients(self) -> Array:
        """∂g/∂(states) at every event."""
        return np.stack([self._gradient(e) for e in self.events])

    def _gradient(self, event: Event) -> Array:
        """∂g/∂(states) at an event."""
        plan, k = self.problem.plan, event.crossing
        regime = self.problem.regimes[int(self.problem.regime_of[k])]
        row = np.zeros(plan.network.size)
        for group, part in relay_slices(plan.network):
            if part.start <= event.relay < part.stop:
                j = event.relay - part.start
                readings = [self.T[0][k] @ R.T for R in group.reads]
                for i, R in enumerate(group.reads):
                    row += self._guard(group, j, event, readings, i) * R[j]
        return np.asarray(row @ regime.P)

    def _guard(self, group: object, j: int, event: Event, readings: list[Array], i: int) -> float:
        """∂guard/∂(reading i) of one relay."""
        stepped = [r + 1j * STEP if n == i else r for n, r in enumerate(readings)]
        mode = np.full(len(readings[0]), 1.0 - event.mode)
        g = group.law.guard(mode, self.inputs_at(event.crossing), *stepped)  # type: ignore[attr-defined]
        return float(np.imag(np.asarray(g)[j]) / STEP)

    def inputs_at(self, k: int) -> dict[str, Array]:
        return {name: values[k] for name, values in self.problem.plan.left.items()}

    @cached_property
    def _guard_rates(self) -> Array:
        """dg/dt just before each crossing."""
        before = self.rates[1][[e.crossing - 1 for e in self.events]]
        rates = np.einsum("en,en->e", self._gradients, before)
        return np.where(np.abs(rates) < LEAST_RATE, LEAST_RATE, rates)

    def by_guard(self, parameter: Parameter, theta: float) -> Array:
        """∂g/∂θ at every event; the pause of a relay counts as a guard that comes later."""
        network, out = self.problem.plan.network, np.zeros(len(self.events))
        if not self.events or parameter.entry not in network.mechanisms:
            return out
        index, slope = network.mechanisms.index(parameter.entry), parameter.slope(parameter.value(theta))
        rates = self._guard_rates
        for e, event in enumerate(self.events):
            for group, part in relay_slices(network):
                j = event.relay - part.start
                if not (part.start <= event.relay < part.stop) or group.entry[j] != index:
                    continue
                values = group.law.__dict__[parameter.attribute].astype(complex)
                values[j] += 1j * STEP
                law = group.law.replaced(**{parameter.attribute: values})
                readings = [self.T[0][event.crossing] @ R.T for R in group.reads]
                mode = np.full(len(readings[0]), 1.0 - event.mode)
                g = law.guard(mode, self.inputs_at(event.crossing), *readings)
                later = np.imag(np.broadcast_to(law.pause(), len(values))[j]) / STEP
                out[e] = slope * (float(np.imag(np.asarray(g)[j])) / STEP - rates[e] * later)
        return out


def switched_course(plan: Plan, readouts: Readouts, known: dict[bytes, Modes] | None = None) -> SwitchedCourse:
    """The run of a plan with relays. Raises Failed where its modes are too much alike."""
    found = switched.find(plan, readouts)
    if found is None:
        raise Failed("a network with relays whose modes are too much alike for the closed form cannot be fitted")
    pauses = np.concatenate(
        [np.broadcast_to(np.asarray(g.law.pause(), float), g.into.shape[1]) for g in plan.network.relays]
    )
    crossings = [t - float(pauses[j]) for t, j, _ in found.switches]
    plan = with_edges(found.plan, np.array(crossings, float))
    course = solve(reduce(plan, readouts), known)
    events = []
    for (t, j, mode), crossing in zip(found.switches, crossings, strict=True):
        k, c = (int(np.argmin(np.abs(plan.edges - x))) for x in (t, crossing))
        if 0 < k < len(plan.steps) and 0 < c <= k:
            events.append(Event(k, c, j, mode))
    return SwitchedCourse(course.problem, course.modes, course.x0, course.x1, tuple(events))


def with_edges(plan: Plan, instants: Array) -> Plan:
    """The plan with further edges; relay modes stay what they are around them."""
    gap = np.abs(plan.edges[:, None] - instants[None, :]).min(axis=0) if len(instants) else np.empty(0)
    new = instants[(gap > SAME_INSTANT) & (instants > plan.edges[0]) & (instants < plan.edges[-1])]
    if not len(new):
        return plan
    edges = np.unique(np.concatenate([plan.edges, new]))
    at = np.clip(np.searchsorted(plan.edges, (edges[1:] + edges[:-1]) / 2) - 1, 0, len(plan.steps) - 1)
    share = [(side - plan.edges[at]) / plan.steps[at] for side in (edges[:-1], edges[1:])]
    left, right = ({n: a[at] + s * (plan.right[n] - a)[at] for n, a in plan.left.items()} for s in share)
    modes = None if plan.modes is None else plan.modes[at]
    return replace(plan, edges=edges, left=left, right=right, modes=modes)
