"""Laws whose slopes are not the same in the whole run: which they are, their heat, and their slopes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.mechanisms.mechanism import Mechanism
from network.engine.balance import flow_heat, source_heat
from network.engine.entry_groups import Flows, Heats
from network.engine.network import Network

Group = Flows | Heats[Mechanism]
Slopes = tuple[Array, ...]

BEND = 0.3
"""Of what holds a lump: how far the slopes that it feels may move within a window; a round shrinks the error to it."""
LEAST = 1e-12
"""W/K that hold a lump at least."""
MOST_WINDOWS = 60
"""Of a run."""
AT_ONCE = 64
"""Intervals that are looked at together."""


def find_bent_groups(network: Network) -> list[Group]:
    """The laws whose slopes are not the same in the whole run: bent ones, and those that follow an input."""
    every: list[Group] = [*network.flows, *network.heats]
    found = [g for g in every if not g.law.is_affine() or g.law.needs()]
    return [g for g in found if isinstance(g, Flows) or g.reads]


def heat_of(group: Group, T: Array, u: dict[str, Array]) -> Array:
    """Heat of the members at many instants (instants, members)."""
    return flow_heat(group, T, u) if isinstance(group, Flows) else source_heat(group, T, u)


def among(group: Group, others: Sequence[Group]) -> bool:
    return any(group is other for other in others)


def spread_of(group: Group) -> Array:
    """What one watt of each member brings into the lumps (members, N)."""
    return group.spread if isinstance(group, Flows) else group.into.T


def heat_along(group: Group, slopes: Slopes, moved: Array) -> Array:
    """Heat of the members by straight laws as temperatures move (2 K, members)."""
    if isinstance(group, Flows):
        joined = slopes[0] * moved[:, group.a] + slopes[1] * moved[:, group.b]
        for slope, R in zip(slopes[2:], group.reads, strict=True):
            joined = joined + slope * (moved @ R.T)
        return np.asarray(joined * group.w)
    return sum((s * (moved @ R.T) for s, R in zip(slopes, group.reads, strict=True)), np.zeros(1))


def loosen(groups: Sequence[Group], slopes: Sequence[Slopes], around: Array) -> Array:
    """What the slopes of some groups are to every lump, as a share of what holds it (around, W/K): (2 K, N)."""
    total = np.zeros((1, len(around)))
    for group, own in zip(groups, slopes, strict=True):
        weight = group.w if isinstance(group, Flows) else 1.0
        total = total + (weight * sum(np.abs(s) for s in own)) @ np.abs(spread_of(group))
    return np.asarray(total / np.maximum(around, LEAST))


def windows(moving: Sequence[Array], K: int, runs: int = 1) -> Indices:
    """The window of each interval: a new one begins where one of some courses (2 K, ·) has moved by more than BEND;
    runs: how many follow each other."""
    parts = [own for own in moving if len(own) > 1 and own.size]
    if not parts:
        return np.zeros(K, int)
    both = np.hstack(parts)
    middle, bend, most = (both[:K] + both[K:]) / 2, BEND, MOST_WINDOWS * runs
    while (begins := _list_begins(middle, bend, most)) is None:
        bend *= 1.5
    return np.repeat(np.arange(len(begins)), np.diff([*begins, K]))


def _list_begins(middle: Array, bend: float, most: int) -> list[int] | None:
    """The first interval of each window in which a course moves by no more than a bend; None where these are more."""
    begins, first = [0], 0
    while first < len(middle):
        here = slice(first, first + AT_ONCE)
        moved = np.abs(middle[here] - middle[begins[-1]]).max(axis=1) > bend
        if moved.any():
            begins.append(first + int(moved.argmax()))
            if len(begins) > most:
                return None
        first = begins[-1] + 1 if moved.any() else here.stop
    return begins


def slopes_of_group(group: Group, T: Array, u: Mapping[str, Array]) -> Slopes:
    """Slopes of a group by each of its readings at many instants, each (instants, members)."""
    if isinstance(group, Flows):
        slopes: Slopes = group.slopes(T, u)
    else:
        slopes = group.slopes(u, *(T @ R.T for R in group.reads))
    return tuple(np.broadcast_to(s, (len(T), len(group.entry))) for s in slopes)


def find_lumps_read(network: Network, groups: Sequence[Group]) -> Indices:
    """The lumps that groups read, but for held ones."""
    read = np.zeros(network.size, bool)
    for group in groups:
        if isinstance(group, Flows):
            read[group.a] = read[group.b] = True
        for R in group.reads:
            read |= R.any(axis=0)
    return np.flatnonzero(read & np.isfinite(network.capacity))
