"""The modes of a run from edge to edge, begun anew where that is said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.response.segments import Segment
from network.engine.solvers.elimination import Regime
from network.engine.solvers.linear import LinearProblem
from network.engine.solvers.modal import Modes, modes_of

TOO_ALIKE, NUDGE = 1e8, 1e-7
"""Condition of the modes from which rounding would be felt, and the relative change of rates that separates them."""


@dataclass(frozen=True, eq=False)
class ModalEnds:
    """Modes of a stretch just after and just before the edges of its intervals, and what drives them there (k, n)."""

    m0: Array
    m1: Array
    p0: Array
    p1: Array


def modes_by_regime(problem: LinearProblem, known: dict[bytes, Modes]) -> tuple[Modes, ...]:
    """The modes of every regime."""
    modes = []
    for regime in problem.regimes:
        key = regime.A.tobytes()
        if key not in known:
            known[key] = separate_modes(regime, problem.scale)
        modes.append(known[key])
    return tuple(modes)


def follow(
    problem: LinearProblem, stretches: Sequence[Segment], starts: Mapping[int, Array]
) -> tuple[Array, Array, tuple[ModalEnds, ...]]:
    """States at the beginnings and ends of all intervals, (K, n) each, and their modes, stretch by stretch; starts:
    states that are set at the beginnings of some intervals."""
    x0, x1, x, found = np.empty(problem.f0.shape), np.empty(problem.f0.shape), problem.x0, []
    for s in stretches:
        here, W, V = slice(s.first, s.last), s.modes.W, s.modes.V
        fresh = {k: W @ state for k, state in starts.items() if s.first < k < s.last}
        ends = _march(s, problem.f0[here] @ W.T, problem.f1[here] @ W.T, W @ starts.get(s.first, x), fresh)
        x0[here], x = np.real(ends.m0 @ V.T), np.real(V @ ends.m1[-1])
        x1[s.first : s.last - 1], x1[s.last - 1] = x0[s.first + 1 : s.last], x
        if fresh:
            before = np.array([*fresh]) - 1
            x1[before] = np.real(ends.m1[before - s.first] @ V.T)
        found.append(ends)
    return x0, x1, tuple(found)


def separate_modes(regime: Regime, scale: Array) -> Modes:
    """The modes of a regime; where some are too much alike (equal cells of a stream), of one that differs by NUDGE."""
    modes = modes_of(regime, scale)
    if modes.condition < TOO_ALIKE:
        return modes
    signs = np.random.default_rng(0).choice([-1.0, 1.0], regime.A.shape)
    return modes_of(replace(regime, A=regime.A + NUDGE * np.abs(np.diag(regime.A))[:, None] * signs), scale)


def _march(s: Segment, p0: Array, p1: Array, start: Array, fresh: Mapping[int, Array]) -> ModalEnds:
    """The modes of a stretch; fresh: modal states that are set at the beginnings of some intervals."""
    from network.engine.response.recursion import recur

    gain, push = s.gain, s.c0 * p0
    push += s.c1 * p1
    before = np.array([*fresh], int) - s.first - 1
    kept = push[before]
    if fresh:
        gain = gain.copy()
        gain[before], push[before] = 0.0, np.array([*fresh.values()])
    m, end = recur(gain, push[:, None].astype(start.dtype, copy=False), start[None])
    m0 = m[:, 0]
    m1 = np.concatenate([m0[1:], end])
    m1[before] = s.gain[before] * m0[before] + kept
    return ModalEnds(m0, m1, p0, p1)
