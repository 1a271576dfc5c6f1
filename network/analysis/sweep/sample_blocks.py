"""Instants of output in blocks of equal length, over which decays are worked out once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.engine.solvers.plan import Plan


@dataclass(frozen=True)
class SampleBlocks:
    """Instants of output by blocks of equal length: the interval of each, when it begins after the interval's edge, and
    where every instant lies among all blocks."""

    interval: Indices
    since: Array
    within: Array
    at: Indices

    @classmethod
    def of(cls, plan: Plan) -> SampleBlocks:
        first, last = plan.bounds[:-1], plan.bounds[1:]
        length = int(np.clip(np.median((last - first)[last > first]) // 2, 8, 64))
        count = -(-(last - first) // length)
        begin = np.cumsum(count) - count
        nth = np.arange(count.sum()) - np.repeat(begin, count)
        since = np.where(last > first, plan.t[np.minimum(first, len(plan.t) - 1)] - plan.edges[:-1], 0.0)
        at = [b * length + np.arange(n) for b, n in zip(begin.tolist(), (last - first).tolist(), strict=True)]
        tau = np.repeat(since, count) + nth * length * plan.spacing
        within = np.asarray(np.arange(length) * plan.spacing, float)
        return cls(np.repeat(np.arange(len(count)), count), tau, within, np.concatenate(at))
