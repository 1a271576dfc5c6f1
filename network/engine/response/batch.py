"""Many relay machines that differ in numbers only, as modes that step alike: what a quick search runs (batch_march)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.balance import affine_matrix, source_series
from network.engine.channels import Readouts, readouts
from network.engine.network import Network
from network.engine.response.measured_run import Run
from network.engine.solvers.elimination import Regime, regime_from
from network.engine.solvers.modal import Modes, modes_of, phi

MOST_STEPS = 1500


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
    """Networks made ready for runs with the steps of this one. What differs in the numbers of its relay alone has the
    modes of the others."""
    h, outputs = step_of(run), readouts(networks[0], parts=False)
    u = {name: signal.start[0] for name, signal in run.schedule.signals.items()} | {"time": np.zeros(())}
    told: dict[tuple[Any, ...], _Stepped] = {}
    parts = []
    for network in networks:
        key = (network.capacity.tobytes(), *map(id, network.flows))
        if key not in told:
            told[key] = _step(
                network, regime_from(network, affine_matrix(network, u, np.zeros(1)), outputs), outputs, h
            )
        own, group = told[key], network.relays[0]
        heat = source_series(group, {n: np.reshape(v, (1, 1)) for n, v in u.items()}, None, 1)[0]
        adds = own.modes.W @ (own.regime.F_heat @ (group.into @ heat))
        parts.append((*own.steps, own.modes.W, own.into, adds, group.reads[0][0] @ own.seen, own.shows, own.direct))
    return Draws(tuple(networks), outputs, h, *(np.stack([p[i] for p in parts]) for i in range(len(parts[0]))))


@dataclass(frozen=True)
class _Stepped:
    """What draws of the same conductances and capacities share; steps: decay, c0 and c1; seen: all lumps of modes."""

    regime: Regime
    modes: Modes
    steps: tuple[Array, Array, Array]
    into: Array
    seen: Array
    shows: Array
    direct: Array


def _step(network: Network, regime: Regime, outputs: Readouts, h: float) -> _Stepped:
    scale = np.concatenate([np.sqrt(network.capacity[network.free]), np.ones(outputs.states)])
    modes = modes_of(regime, scale)
    one, two, _ = phi(-modes.rates * h)
    states = np.eye(len(scale))[len(network.free) :]
    into, beside = (np.hstack(pair) for pair in ((regime.F_held, regime.F_heat), (regime.P_held, regime.P_heat)))
    shows = np.vstack([outputs.rows @ regime.P, states]) @ modes.V
    direct = np.vstack([outputs.rows @ beside, np.zeros((len(states), beside.shape[1]))])
    steps = np.exp(-modes.rates * h), h * (one - two), h * two
    return _Stepped(regime, modes, steps, modes.W @ into, regime.P @ modes.V, shows, direct)
