"""Many relay machines at once, in even steps: quick runs for a search, not for a result.

All draws step together, mode by mode: m ← e^(−λh) m + c₀ f₀ + c₁ f₁ (+ what the relay adds while on), exact but for the
switching instants: a switching is seen at the end of its step, and what the relay missed since the crossing is made
good to first order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.base import Relay
from network.engine.balance import affine_heat, affine_matrix, source_series
from network.engine.channels import Readouts, readouts
from network.engine.entry_groups import Heats
from network.engine.network import Network
from network.engine.response.cells import cell_matrix
from network.engine.response.measured_run import Run
from network.engine.response.output_jacobian import channels_of, slopes_of
from network.engine.solvers.elimination import regime_from
from network.engine.solvers.modal import modes_of, phi
from network.engine.solvers.plan import Plan, spans
from network.machine.machine import Machine

MOST_STEPS = 1500
AT_ONCE = 8e6
"""Modal states of draws over a run that are kept at a time."""

RANK = 1e-13
"""Singular value, as a share of the largest, below which inputs are combinations of others."""


@dataclass(frozen=True)
class Draws:
    """Many networks that differ in numbers only, as modes (M, n), stepped alike: decay over a step, c0 and c1 of what
    is put in at its ends (solvers.modal).

    first: from states to modes (M, n, n); into: from held temperatures and heats to modes (M, n, inputs); own: what
    the relay adds while on (M, n); watch: what it reads of the modes (M, n); shows, direct: base readings of modes and
    of held temperatures and heats (M, width, ·).
    """

    networks: tuple[Network, ...]
    outputs: Readouts
    step: float
    decay: Array
    c0: Array
    c1: Array
    first: Array
    into: Array
    own: Array
    watch: Array
    shows: Array
    direct: Array

    def of(self, some: slice) -> Draws:
        """Some of them."""
        arrays: dict[str, Any] = {n: a[some] for n, a in self.__dict__.items() if isinstance(a, np.ndarray)}
        return replace(self, networks=self.networks[some], **arrays)


def serves(network: Network) -> bool:
    """Whether a network is one for this: linear between the switchings of a single relay, conductances that hold."""
    one = len(network.relays) == 1 and network.relays[0].into.shape[1] == 1
    follow = any(g.law.needs() for g in network.flows) or any(r.law.needs() for r in network.relays)
    held = not follow and not any(h.reads for h in network.heats)
    return one and held and network.is_affine()


def step_of(run: Run) -> float:
    """Length of the even steps of a run [s]."""
    t = run.knots.samples
    return float(t[-1] - t[0]) / min(len(t) - 1, MOST_STEPS)


def draws_of(networks: Sequence[Network], run: Run) -> Draws:
    """Networks made ready for runs with the steps of this one."""
    h, outputs, parts = step_of(run), readouts(networks[0], parts=False), []
    u = {name: signal.start[0] for name, signal in run.schedule.signals.items()} | {"time": np.zeros(())}
    for network in networks:
        regime = regime_from(network, affine_matrix(network, u, np.zeros(1)), outputs)
        scale = np.concatenate([np.sqrt(network.capacity[network.free]), np.ones(outputs.states)])
        modes = modes_of(regime, scale)
        one, two, _ = phi(-modes.rates * h)
        group, states = network.relays[0], np.eye(len(scale))[len(network.free) :]
        heat = source_series(group, {n: np.reshape(v, (1, 1)) for n, v in u.items()}, None, 1)[0]
        into, beside = (np.hstack(pair) for pair in ((regime.F_held, regime.F_heat), (regime.P_held, regime.P_heat)))
        shows = np.vstack([outputs.rows @ regime.P, states]) @ modes.V
        direct = np.vstack([outputs.rows @ beside, np.zeros((len(states), beside.shape[1]))])
        steps = np.exp(-modes.rates * h), h * (one - two), h * two
        own, watch = modes.W @ (regime.F_heat @ (group.into @ heat)), group.reads[0][0] @ regime.P @ modes.V
        parts.append((*steps, modes.W, modes.W @ into, own, watch, shows, direct))
    return Draws(tuple(networks), outputs, h, *(np.stack([p[i] for p in parts]) for i in range(len(parts[0]))))


def means_of(
    machine: Machine, draws: Draws, run: Run, began: Mapping[str, Array], horizon: float = 1.0
) -> tuple[Array, Array]:
    """Means over the cells of a run for every draw (draws, channels · cells), those behind the horizon 0, and how
    often each relay switched. began: where parts start in every draw [°C], the others as the run has them; horizon:
    share of the run that is computed."""
    t, network = run.knots.samples, draws.networks[0]
    count = max(2, round(horizon * float(t[-1] - t[0]) / draws.step))
    edges = np.asarray(float(t[0]) + draws.step * np.arange(count + 1), float)
    left, right = spans(run.schedule, edges)
    T0 = np.full((len(draws.networks), network.size), machine.reference)
    for name, part in network.parts.items():
        T0[:, part] = np.reshape(began.get(name, run.start.get(name, machine.reference)), (-1, 1))
    plan = Plan(network, edges, edges, left, right, T0[0], "modal", "")
    seen = _Seen(machine, plan, draws, run)
    each = max(1, int(AT_ONCE / (draws.decay.shape[1] * count)))
    parts = (slice(i, i + each) for i in range(0, len(draws.networks), each))
    told = [seen.means(draws.of(part), T0[part]) for part in parts]
    return np.concatenate([means for means, _ in told]), np.concatenate([switches for _, switches in told])


class _Seen:
    """A run as its channels show it, for some draws at a time."""

    def __init__(self, machine: Machine, plan: Plan, draws: Draws, run: Run) -> None:
        self.machine, self.plan, self.run, self.outputs = machine, plan, run, draws.outputs
        off = np.zeros(1)
        held = plan.evaluate_held(plan.left), plan.evaluate_held(plan.right)
        heat = (affine_heat(plan.network, u, off, len(plan.steps)) for u in plan.just_inside)
        self.inputs, self.basis = _least(*(np.hstack(pair) for pair in zip(held, heat, strict=True)))
        self.u = {n: np.append(plan.left[n], plan.right[n][-1]) for n in plan.left}
        within = run.knots.samples <= plan.edges[-1] + 1e-6
        K = len(plan.steps)
        both = [cell_matrix(run.knots, plan.edges, run.present[n] & within) for n in run.channels]
        self.averages = [csr_matrix(np.pad(A[:, :K], ((0, 0), (0, 1))) + np.pad(A[:, K:], ((0, 0), (1, 0))))
                         for A in both]  # fmt: skip
        level = np.full((draws.outputs.width, K + 1), machine.reference)
        self.level = level
        slopes = slopes_of(machine, draws.outputs, level, self.u, run.channels)
        self.slopes = slopes if slopes and slopes.is_constant and slopes.is_straight else None

    def means(self, draws: Draws, T0: Array) -> tuple[Array, Array]:
        draws = replace(draws, into=draws.into @ self.basis.T, direct=draws.direct @ self.basis.T)
        modes, switches = _march(self.plan, draws, self.inputs, T0)
        edges = np.vstack([self.inputs[0], self.inputs[1][-1:]])
        if self.slopes is None:
            return self._one_by_one(draws, modes, edges), switches
        shows, direct = (self.slopes.matrix @ a for a in (draws.shows, draws.direct))
        y = np.real(np.matmul(modes.transpose(1, 0, 2), shows.transpose(0, 2, 1))) + edges @ direct.transpose(0, 2, 1)
        y += (self._values(self.level) - self.slopes.matrix @ self.level).T
        y[:, :, self.slopes.zeroed] -= y[:, :1, self.slopes.zeroed]
        return np.hstack([(A @ y[:, :, i].T).T for i, A in enumerate(self.averages)]), switches

    def _one_by_one(self, draws: Draws, modes: Array, edges: Array) -> Array:
        """Where channels do not follow the readings by one matrix."""
        readings = (np.real(show @ modes[:, m].T) + direct @ edges.T
                    for m, (show, direct) in enumerate(zip(draws.shows, draws.direct, strict=True)))  # fmt: skip
        values = (self._values(r) for r in readings)
        return np.array([np.concatenate([A @ row for A, row in zip(self.averages, v, strict=True)]) for v in values])

    def _values(self, readings: Array) -> Array:
        return channels_of(self.machine, self.outputs, readings, self.u, self.run.channels)


def _least(begin: Array, end: Array) -> tuple[tuple[Array, Array], Array]:
    """Inputs at both ends of the steps as few series (K, r) each, and what each is in all inputs (r, inputs)."""
    U, size, basis = np.linalg.svd(np.vstack([begin, end]), full_matrices=False)
    r = int((size > RANK * size.max(initial=0.0)).sum())
    series = U[:, :r] * size[:r]
    return (series[: len(begin)], series[len(begin) :]), basis[:r]


def _march(plan: Plan, draws: Draws, inputs: tuple[Array, ...], T0: Array) -> tuple[Array, Array]:
    """Modal states of all draws at all edges (K + 1, draws, n) from their temperatures T0 (draws, N), and their
    switchings."""
    K, (M, n), outputs = len(plan.steps), draws.decay.shape, draws.outputs
    states = np.array([outputs.start_states(T) if outputs.states else np.empty(0) for T in T0])
    x0 = np.hstack([T0[:, plan.network.free], states])
    law = _stack_laws([net.relays[0] for net in draws.networks])
    m = np.empty((K + 1, M, n), draws.decay.dtype)
    m[0] = np.matmul(draws.first, x0[:, :, None])[:, :, 0]
    into = draws.into.transpose(2, 0, 1).reshape(-1, M * n)
    kick = (draws.c0 + draws.c1) * draws.own
    on, switches, before = (np.zeros(M) for _ in range(3))
    for k in range(K):
        seen = np.real(np.einsum("mn,mn->m", draws.watch, m[k]))
        guard = law.guard(on, {name: v[k] for name, v in plan.left.items()}, seen)
        due = guard > 0
        late = np.where(due & (before < 0), guard / np.maximum(guard - before, 1e-12), 0.0)
        m[k] += (late * np.where(on > 0, -1.0, 1.0))[:, None] * kick
        on = np.where(due, 1 - on, on)
        before = np.where(due, 0.0, guard)
        switches += due
        f0, f1 = ((side[k] @ into).reshape(M, n) for side in inputs)
        m[k + 1] = draws.decay * m[k] + draws.c0 * f0 + draws.c1 * f1 + on[:, None] * kick
    return m, switches


def _stack_laws(groups: Sequence[Heats[Relay]]) -> Relay:
    """One law with the numbers of all draws side by side."""
    first = groups[0].law
    arrays = {n: np.array([float(g.law.__dict__[n][0]) for g in groups])
              for n in first.params() if isinstance(first.__dict__[n], np.ndarray)}  # fmt: skip
    return first.replaced(**arrays)
