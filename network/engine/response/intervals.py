"""In which interval an instant lies: a sample at an edge belongs to the interval after it."""

from __future__ import annotations

import numpy as np

from network.catalogue.declaration.declare import Array, Indices

SAME = 1e-6
"""s: how far an instant may lie beside its edge."""


def interval_of(edges: Array, t: Array) -> Indices:
    """The interval between K + 1 edges in which each instant lies: 0 to K − 1; the last one holds its end too."""
    return np.asarray(np.clip(np.searchsorted(edges - SAME, t, side="right") - 1, 0, len(edges) - 2))


def first_from(edges: Array, t: Array) -> Indices:
    """Of each instant the first edge that is not before it."""
    return np.asarray(np.searchsorted(edges, t - SAME))


def locate_instants(edges: Array, t: Array) -> tuple[Indices, Array]:
    """Of each instant its interval, and its share of the way through it."""
    k = interval_of(edges, t)
    return k, np.clip((t - edges[k]) / (edges[k + 1] - edges[k]), 0.0, 1.0)
