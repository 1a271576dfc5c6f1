"""Ornstein–Uhlenbeck noise at the samples, averaged over cells: exact covariances of the means.

Between two cells e^(−(t_b − t_a)/τ) is a product of what the earlier one keeps until its last sample, the way between,
and what the later one keeps from its first, so that only the pairs within a cell have to be summed.
"""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array, Indices


def correlate_cell_means(t: Array, cell: Indices, cells: int, tau: float) -> Array:
    """Correlations of the means over cells of the samples at t [s], increasing; rows of cells without any are zero."""
    known, starts = np.unique(cell, return_index=True)
    stops = np.append(starts[1:], len(t)) - 1
    count = stops - starts + 1.0
    group = np.repeat(np.arange(len(known)), stops - starts + 1)
    keeps = np.add.reduceat(np.exp((t - t[stops][group]) / tau), starts) / count
    begins = np.add.reduceat(np.exp((t[starts][group] - t) / tau), starts) / count
    way = np.exp(-np.maximum(t[starts][None, :] - t[stops][:, None], 0.0) / tau)
    upper = np.triu(keeps[:, None] * begins[None, :] * way, 1)
    inner = upper + upper.T + np.diag(_within(t, starts, stops, tau))
    matrix = np.zeros((cells, cells))
    matrix[np.ix_(known, known)] = inner
    return matrix


def _within(t: Array, starts: Indices, stops: Indices, tau: float) -> Array:
    """Mean over all pairs of samples of each cell."""
    count = stops - starts + 1
    earlier, pairs = np.zeros(len(starts)), np.zeros(len(starts))
    for i in range(1, int(count.max())):
        more = np.flatnonzero(count > i)
        at = starts[more] + i
        earlier[more] = (earlier[more] + 1) * np.exp((t[at - 1] - t[at]) / tau)
        pairs[more] += earlier[more]
    return np.asarray((count + 2 * pairs) / count**2)
