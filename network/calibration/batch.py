"""Many relay machines at once, in even steps: quick runs for a search, not for a result.

All draws step together: x ← E x + Γ₀ f₀ + Γ₁ f₁ (+ what the relay adds while on), exact but for the switching instants:
a switching is seen at the end of its step, and what the relay missed since the crossing is made good to first order.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from network.balance import affine_heat, affine_matrix, source_series
from network.calibration.knots import cell_matrix
from network.calibration.predictor import Run, channels_of
from network.channels import Readouts, readouts
from network.declare import Array
from network.graph import Heats, Network
from network.machine import Machine
from network.mechanisms.base import Relay
from network.solvers.linear import Regime, regime_from
from network.solvers.modal import modes_of, phi
from network.solvers.plan import Plan, spans

MOST_STEPS = 1500


@dataclass(frozen=True)
class Draws:
    """Many networks that differ in numbers only, stepped alike. Matrices of every draw: (M, n, n) each; own: what the
    relay adds to dx/dt while on (M, n)."""

    networks: tuple[Network, ...]
    outputs: Readouts
    step: float
    E: Array
    G0: Array
    G1: Array
    own: Array
    watch: Array
    regimes: tuple[Regime, ...]


def serves(network: Network) -> bool:
    """Whether a network is one for this: linear between the switchings of a single relay, conductances that hold."""
    one = len(network.relays) == 1 and network.relays[0].into.shape[1] == 1
    held = not any(g.law.needs() for g in network.flows) and not any(h.reads for h in network.heats)
    return one and held and network.is_affine()


def step_of(run: Run) -> float:
    """Length of the even steps of a run [s]."""
    t = run.knots.samples
    return float(t[-1] - t[0]) / min(len(t) - 1, MOST_STEPS)


def means_of(
    machine: Machine, draws: Draws, run: Run, start: float, new: Container[str], horizon: float = 1.0
) -> tuple[Array, Array]:
    """Means over the cells of a run for every draw (draws, channels · cells), those behind the horizon 0, and how
    often each relay switched. start: of `new` parts, about which the run says nothing [°C]; horizon: share of the run
    that is computed."""
    t, network = run.knots.samples, draws.networks[0]
    count = max(2, round(horizon * float(t[-1] - t[0]) / draws.step))
    edges = np.asarray(float(t[0]) + draws.step * np.arange(count + 1), float)
    left, right = spans(run.schedule, edges)
    T0 = np.full(network.size, start)
    for name, part in network.parts.items():
        T0[part] = run.start.get(name, start) if name not in new else start
    plan = Plan(network, edges, edges, left, right, T0, "modal", "")
    x, switches = _march(plan, draws)
    return _means(machine, plan, x, draws.outputs, run, network), switches


def _march(plan: Plan, draws: Draws) -> tuple[Array, Array]:
    """States of all draws at all edges (K + 1, draws, n), and their switchings."""
    networks, outputs, K = draws.networks, draws.outputs, len(plan.steps)
    network = networks[0]
    (h0, h1), ends = (plan.held_at(plan.left), plan.held_at(plan.right)), plan.just_inside
    off = np.zeros(1)
    q0, q1 = (affine_heat(network, u, off, K) for u in ends)
    n = draws.E.shape[1]
    F = np.stack([np.hstack([r.F_held, r.F_heat]) for r in draws.regimes])
    f0, f1 = (np.hstack(pair) @ F.transpose(0, 2, 1) for pair in ((h0, q0), (h1, q1)))
    push = (f0 @ draws.G0.transpose(0, 2, 1) + f1 @ draws.G1.transpose(0, 2, 1)).transpose(1, 0, 2)
    law = _joined_law([net.relays[0] for net in networks])
    x = np.empty((K + 1, len(networks), n))
    x[0] = np.concatenate([plan.T0[network.free], np.zeros(outputs.states)])
    kick = np.einsum("mij,mj->mi", draws.G0 + draws.G1, draws.own)
    on, switches, before = (np.zeros(len(networks)) for _ in range(3))
    for k in range(K):
        seen = np.einsum("mn,mn->m", draws.watch, x[k])
        guard = law.guard(on, {name: v[k] for name, v in plan.left.items()}, seen)
        due = guard > 0
        late = np.where(due & (before < 0), guard / np.maximum(guard - before, 1e-12), 0.0)
        x[k] += (late * np.where(on > 0, -1.0, 1.0))[:, None] * kick
        on = np.where(due, 1 - on, on)
        before = np.where(due, 0.0, guard)
        switches += due
        x[k + 1] = np.matmul(draws.E, x[k][:, :, None])[:, :, 0] + push[k] + on[:, None] * kick
    return x, switches


def draws_of(networks: Sequence[Network], run: Run) -> Draws:
    """Networks made ready for runs with the steps of this one."""
    h, outputs, parts = step_of(run), readouts(networks[0], parts=False), []
    u = {name: signal.start[0] for name, signal in run.schedule.signals.items()} | {"time": np.zeros(())}
    for network in networks:
        regime = regime_from(network, affine_matrix(network, u, np.zeros(1)), outputs)
        scale = np.concatenate([np.sqrt(network.capacity[network.free]), np.ones(outputs.states)])
        modes = modes_of(regime, scale)
        one, two, _ = phi(-modes.rates * h)
        decay, c0, c1 = np.exp(-modes.rates * h), h * (one - two), h * two
        group = network.relays[0]
        heat = source_series(group, {n: np.reshape(v, (1, 1)) for n, v in u.items()}, None, 1)[0]
        matrices = [np.real(modes.V * c @ modes.W) for c in (decay, c0, c1)]
        parts.append((*matrices, regime.F_heat @ (group.into @ heat), group.reads[0][0] @ regime.P, regime))
    E, G0, G1, own, watch = (np.stack([p[i] for p in parts]) for i in range(5))
    return Draws(tuple(networks), outputs, h, E, G0, G1, own, watch, tuple(p[5] for p in parts))


def _joined_law(groups: Sequence[Heats[Relay]]) -> Relay:
    """One law with the numbers of all draws side by side."""
    first = groups[0].law
    arrays = {n: np.array([float(g.law.__dict__[n][0]) for g in groups])
              for n in first.params() if isinstance(first.__dict__[n], np.ndarray)}  # fmt: skip
    return first.replaced(**arrays)


def _means(machine: Machine, plan: Plan, x: Array, outputs: Readouts, run: Run, network: Network) -> Array:
    T = np.empty((*x.shape[:2], network.size))
    T[:, :, network.free] = x[:, :, : len(network.free)]
    T[:, :, network.bound] = np.vstack([plan.held_at(plan.left), plan.held_at(plan.right)[-1:]])[:, None]
    u = {n: np.append(plan.left[n], plan.right[n][-1]) for n in plan.left}
    within = run.knots.samples <= plan.edges[-1] + 1e-6
    matrices = [cell_matrix(run.knots, plan.edges, run.present[n] & within) for n in run.channels]
    K = len(plan.steps)
    single = [np.pad(A[:, :K], ((0, 0), (0, 1))) + np.pad(A[:, K:], ((0, 0), (1, 0))) for A in matrices]
    out = []
    for m in range(x.shape[1]):
        rows = np.vstack([outputs.rows @ T[:, m].T, x[:, m, len(network.free) :].T])
        values = channels_of(machine, outputs, rows, u, run.channels)
        out.append(np.concatenate([A @ v for A, v in zip(single, values, strict=True)]))
    return np.array(out)
