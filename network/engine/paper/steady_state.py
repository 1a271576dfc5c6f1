"""Where constant inputs drive the spindle unit of the paper's closed form, and how fast."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.catalogue.mechanisms.mechanism import Inputs
from network.engine.paper.spindle_unit import SpindleUnit
from network.platform.refusal import Spot, refuse
from network.recordings.inputs import Schedule


@dataclass(frozen=True)
class Settled:
    """Per piece of time, K of them. tau: time constant [s]; T: where T̄ settles, f of eq. 15 [°C]; inside: whether
    something heats the inside of the unit; T_s: temperature next to it, settled [°C]; q_in2: heat flow to the beam once
    T̄ has settled [W]."""

    tau: Array
    T: Array
    inside: Mask
    T_s: Array
    q_in2: Array

    def rise(self, T: Array, piece: Indices, reference: float) -> Array:
        """ΔT₁ of eq. 16 [K] for T̄ = T in the given pieces; without heat inside T_s is T̄."""
        return np.where(self.inside[piece], (self.T_s[piece] + T) / 2, T) - reference


def solve_steady_state(unit: SpindleUnit, schedule: Schedule, edges: Array, first: Mapping[str, float]) -> Settled:
    """For the inputs in the middle of every piece between edges; `first`: temperatures at the start by node.

    Raises Refused where the unit loses its heat to nothing.
    """
    middle = (edges[:-1] + edges[1:]) / 2
    u: Inputs = {"time": middle} | {name: signal.at(middle) for name, signal in schedule.signals.items()}
    nodes = unit.machine.nodes
    given = np.stack([_evaluate_fixed(nodes[name].temperature, first[name], u) for name in nodes], axis=1)
    (matrices, regime_of), q = unit.conductances(u), unit.heats(u)
    result = Settled(*(np.zeros(len(middle), kind) for kind in (float, float, bool, float, float)))
    for r, K in enumerate(matrices):
        at = np.flatnonzero(regime_of == r)
        part = _in_regime(unit, K, q[at], given[at])
        for whole, piece in zip(vars(result).values(), vars(part).values(), strict=True):
            whole[at] = piece
    return result


def _evaluate_fixed(held: Any, first: float, u: Inputs) -> Array:
    """Temperature of a node that the closed form does not compute: held, or as it was at the start."""
    if isinstance(held, str):
        return u[held]
    return np.full(len(u["time"]), first if held is None else held)


def _in_regime(unit: SpindleUnit, K: Array, q: Array, given: Array) -> Settled:
    """K (nodes, nodes); q, given (pieces, nodes)."""
    index = {name: i for i, name in enumerate(unit.machine.nodes)}
    parts, junctions = (np.array([index[name] for name in group], int) for group in (unit.parts, unit.junctions))
    outer = np.setdiff1d(np.arange(len(index)), [*parts, *junctions])
    through = K[:, junctions] @ np.linalg.pinv(K[np.ix_(junctions, junctions)])
    K, q = K - through @ K[junctions], q - q[:, junctions] @ through.T
    inner = K[np.ix_(parts, parts)]
    if not -inner.sum() > 1e-12 * np.abs(K).max():
        raise refuse(Spot(unit.machine.file), "the spindle unit loses its heat to nothing", "link it to the ambient")
    push = q + given[:, outer] @ K[:, outer].T
    T = push[:, parts].sum(axis=1) / -inner.sum()
    inside = _inside(unit, q[:, parts])
    T_s = (inside * np.linalg.solve(-inner, push[:, parts].T).T).sum(axis=1)
    to_beam = np.zeros(len(T))
    if unit.beam is not None:
        to_beam = push[:, index[unit.beam]] + K[index[unit.beam], parts].sum() * T
    tau = np.full(len(T), unit.heat_capacity / -inner.sum())
    return Settled(tau, T, np.asarray(inside.any(axis=1)), T_s, to_beam)


def _inside(unit: SpindleUnit, q: Array) -> Array:
    """Shares of the heat that goes into parts other than the spindle itself; zeros where none does."""
    is_inside = np.array([name != unit.spindle for name in unit.parts])
    heat = np.maximum(q, 0.0) * is_inside
    total = heat.sum(axis=1, keepdims=True)
    return np.asarray(heat / np.where(total > 0, total, 1.0))
