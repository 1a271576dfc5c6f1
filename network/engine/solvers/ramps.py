"""Ramped inputs: intervals cut so finely that every source is straight within each piece."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.mechanisms.mechanism import Mechanism
from network.engine.entry_groups import Heats
from network.engine.network import Network
from network.recordings.inputs import Schedule

BENDS = 1e-9
"""Relative deviation from a straight line that a source on a ramped input may keep."""
MOST_PIECES = 4096


def straighten_ramps(
    network: Network, schedule: Schedule, edges: Array, left: Mapping[str, Array], right: Mapping[str, Array]
) -> Array:
    """Edges with ramps cut so finely that every source is straight within each piece, to BENDS of its heat."""
    pieces = np.ones(len(edges) - 1, int)
    for heats in (*network.heats, *network.relays):
        own = ["time"] if heats.law.follows_time else []
        names = [n for n in (*heats.law.needs(), *own) if not np.array_equal(left[n], right[n])]
        if names:
            bend = np.array([_bend(heats, left, right, share) for share in (0.25, 0.5, 0.75)]).max(axis=0)
            pieces = np.maximum(pieces, np.ceil(np.sqrt(bend / BENDS)).astype(int))
    pieces = np.clip(pieces, 1, MOST_PIECES)
    if pieces.max() == 1:
        return edges
    cut = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(edges[:-1], edges[1:], pieces, strict=True)]
    zero_crossings = list(_zero_crossings(schedule, edges))
    return np.unique(np.concatenate([*cut, [edges[-1]], np.array(zero_crossings, float)]))


def _bend(heats: Heats[Mechanism], left: Mapping[str, Array], right: Mapping[str, Array], share: float) -> Array:
    """Distance of the source from the straight line at a share of each interval, relative to its heat there."""
    at = [{n: ((1 - s) * left[n] + s * right[n])[:, None] for n in left} for s in (1e-9, share, 1 - 1e-9)]
    zeros = [np.zeros(1) for _ in heats.reads]
    first, inside, last = (np.asarray(heats.heat(u, *zeros) + 0 * u["time"]) for u in at)
    size = np.maximum(np.abs(np.stack([first, inside, last])).max(axis=0), 1e-300)
    return np.asarray((np.abs(inside - (1 - share) * first - share * last) / size).max(axis=1))


def _zero_crossings(schedule: Schedule, edges: Array) -> Iterator[float]:
    for signal in schedule.signals.values():
        first, last = signal.span(edges[:-1], edges[1:])
        for k in np.flatnonzero(first * last < 0):
            yield float(edges[k] + (edges[k + 1] - edges[k]) * first[k] / (first[k] - last[k]))
