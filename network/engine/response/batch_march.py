"""The beginnings of runs as many relay machines at once tell them, in even steps: for a search, not for a result.

All draws step together, and all runs with the same steps, mode by mode: m ← e^(−λh) m + c₀ f₀ + c₁ f₁ (+ what the relay
adds while on), exact but for the switching instants: a switching is seen at the end of its step, and what the relay
missed since the crossing is made good to first order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Relay
from network.engine.entry_groups import Heats
from network.engine.response.batch import Draws
from network.engine.response.run_beginning import Beginning

AT_ONCE = 8e6
"""Modal states of draws over runs that are kept at a time."""
RANK = 1e-13
"""Singular value, as a share of the largest, below which inputs are combinations of others."""


def means_of(beginnings: Sequence[Beginning], draws: Draws, began: Mapping[str, Array]) -> tuple[list[Array], Array]:
    """Means over the cells of every run with the steps of the draws (draws, channels · cells), those behind the share
    0, and how often each relay switched in all. began: where parts start in every draw [°C], others as the run has
    them."""
    (left, right), basis = _least([b.inputs(draws.networks[0]) for b in beginnings])
    T0 = np.stack([b.start(began, len(draws.networks)) for b in beginnings])
    each = max(1, int(AT_ONCE / (draws.decay.shape[1] * left.shape[0] * left.shape[1])))
    told, switched = [], []
    for i in range(0, len(draws.networks), each):
        some = draws.of(slice(i, i + each))
        some = replace(some, into=some.into @ basis.T, direct=some.direct @ basis.T)
        modes, switches = _march(beginnings, some, np.concatenate([left, right], axis=2), T0[:, i : i + each])
        told.append([_seen(b, some, modes[:, r], left[:, r], right[:, r]) for r, b in enumerate(beginnings)])
        switched.append(switches)
    return [np.concatenate(parts) for parts in zip(*told, strict=True)], np.concatenate(switched)


def _seen(b: Beginning, draws: Draws, modes: Array, left: Array, right: Array) -> Array:
    return b.means(draws, modes[: b.count + 1], np.vstack([left[: b.count], right[b.count - 1 : b.count]]))


def _least(ends: Sequence[tuple[Array, Array]]) -> tuple[tuple[Array, Array], Array]:
    """Inputs of all runs at both ends of the steps as few series (K, runs, r) each, 0 behind the end of a run, and what
    each is in all inputs (r, inputs)."""
    U, size, basis = np.linalg.svd(np.vstack([side for pair in ends for side in pair]), full_matrices=False)
    r = int((size > RANK * size.max(initial=0.0)).sum())
    series, i = U[:, :r] * size[:r], 0
    both = np.zeros((2, max(len(begin) for begin, _ in ends), len(ends), r))
    for run, (begin, _) in enumerate(ends):
        for side in both:
            side[: len(begin), run] = series[i : i + len(begin)]
            i += len(begin)
    return (both[0], both[1]), basis[:r]


def _march(beginnings: Sequence[Beginning], draws: Draws, inputs: Array, T0: Array) -> tuple[Array, Array]:
    """Modal states of all draws in all runs at all edges (K + 1, runs, draws, n), from inputs at both ends of the steps
    (K, runs, 2 r) and their temperatures T0 (runs, draws, N), and their switchings."""
    (K, R, _), M = inputs.shape, len(draws.decay)
    law, time = _stack_laws([network.relays[0] for network in draws.networks]), np.zeros((K, R, 1))
    ends = np.array([[b.count] for b in beginnings])
    for r, b in enumerate(beginnings):
        time[: b.count, r, 0] = b.plan.left["time"]
    m = _push_inputs(draws, inputs, T0)
    kick = (draws.c0 + draws.c1) * draws.own
    on, before = (np.zeros((R, M)) for _ in range(2))
    switches = np.zeros((R, M))
    for k in range(K):
        seen = np.real(np.einsum("mn,rmn->rm", draws.watch, m[k]))
        guard = law.guard(on, {"time": time[k]}, seen)
        due = guard > 0
        if due.any():
            late = np.where(due & (before < 0), guard / np.maximum(guard - before, 1e-12), 0.0)
            m[k] += (late * np.where(on > 0, -1.0, 1.0))[:, :, None] * kick
            on, guard = np.where(due, 1 - on, on), np.where(due, 0.0, guard)
            switches += due & (k < ends)
        before = guard
        m[k + 1] += draws.decay * m[k]
        if on.any():
            m[k + 1] += on[:, :, None] * kick
    return m, switches.sum(axis=0)


def _push_inputs(draws: Draws, inputs: Array, T0: Array) -> Array:
    """Where all draws begin in all runs, then what their inputs add in every step (K + 1, runs, draws, n)."""
    (K, R, width), (M, n), outputs = inputs.shape, draws.decay.shape, draws.outputs
    free = T0[:, :, draws.networks[0].free]
    states = np.array([[outputs.start_states(T) for T in run] for run in T0]) if outputs.states else free[:, :, :0]
    gain = np.concatenate([c[:, :, None] * draws.into for c in (draws.c0, draws.c1)], axis=2)
    m = np.empty((K + 1, R, M, n), draws.decay.dtype)
    m[0] = np.einsum("mij,rmj->rmi", draws.first, np.concatenate([free, states], axis=2))
    np.matmul(inputs.reshape(K * R, width), gain.transpose(2, 0, 1).reshape(width, M * n),
              out=m[1:].reshape(K * R, M * n))  # fmt: skip
    return m


def _stack_laws(groups: Sequence[Heats[Relay]]) -> Relay:
    """One law with the numbers of all draws side by side."""
    first = groups[0].law
    arrays = {n: np.array([float(g.law.__dict__[n][0]) for g in groups])
              for n in first.params() if isinstance(first.__dict__[n], np.ndarray)}  # fmt: skip
    return first.replaced(**arrays)
