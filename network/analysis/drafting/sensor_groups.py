"""Which temperatures move alike, so that one part stands for them.

Average linkage by the mean square in which two differ, their constant errors apart; how many groups by evidence. With
s_i² what a lag model leaves of a temperature alone and d_i² how far it is from its group's mean, one part for the group
leaves s_i² + d_i²: K groups cost Σ n_i ln(s_i² + d_i²) + K p ln Σ n_i (BIC), n_i independent readings, p numbers of a
part. Where d is less than what the model leaves anyway, nothing is gained by parting them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from network.catalogue.declaration.declare import Array

NUMBERS = 4
"""Of a part: its heat capacity, a conductance to the surroundings, one to another part, and a heat."""


@dataclass(frozen=True, eq=False)
class Group:
    """sensors: their names; mean: of their readings, constant errors apart, over all cells; apart: rms by which its
    members differ from it [K]; offsets: of each against the mean."""

    sensors: tuple[str, ...]
    mean: Array
    apart: float


def group_sensors(
    names: Sequence[str], readings: Sequence[Array], squares: Sequence[float], independent: Sequence[float]
) -> tuple[Group, ...]:
    """readings: over all cells, NaN in gaps; squares, independent: s² and n of each."""
    if len(names) == 1:
        return (_group(names, readings),)
    tree = linkage(squareform(_distances(readings), checks=False), method="average")
    weights, left = np.array(independent), np.array(squares)
    best, cost = np.ones(len(names), int), np.inf
    for count in range(1, len(names) + 1):
        label = fcluster(tree, count, criterion="maxclust")
        apart = np.empty(len(names))
        for one in np.unique(label):
            members = np.flatnonzero(label == one)
            apart[members] = _from_mean([readings[i] for i in members.tolist()])
        now = weights @ np.log(left + apart) + label.max() * NUMBERS * np.log(weights.sum())
        if now < cost - 1e-9:
            best, cost = label, float(now)
    kept = dict.fromkeys(best.tolist())
    return tuple(_pick(names, readings, np.flatnonzero(best == one).tolist()) for one in kept)


def _pick(names: Sequence[str], readings: Sequence[Array], members: Sequence[int]) -> Group:
    return _group([names[i] for i in members], [readings[i] for i in members])


def _group(names: Sequence[str], readings: Sequence[Array]) -> Group:
    return Group(tuple(names), mean_course(readings), float(np.sqrt(_from_mean(readings).mean())))


def _distances(readings: Sequence[Array]) -> Array:
    count = len(readings)
    apart = np.zeros((count, count))
    for i in range(count):
        for j in range(i):
            difference = readings[i] - readings[j]
            known = np.isfinite(difference).any()
            apart[i, j] = apart[j, i] = float(np.nanvar(difference)) if known else np.inf
    finite = apart[np.isfinite(apart)].max(initial=0.0)
    return np.asarray(np.sqrt(np.where(np.isfinite(apart), apart, 4 * finite)))


def mean_course(readings: Sequence[Array]) -> Array:
    """The mean over sensors that each may lack cells, their constant errors against the others taken out first."""
    rows = np.array(readings)
    there = np.isfinite(rows)
    count = np.maximum(there.sum(axis=0), 1)
    mean = np.where(there, rows, 0.0).sum(axis=0) / count
    for _ in range(3):
        off = [float(np.nanmean(row - mean)) if ok.any() else 0.0 for row, ok in zip(rows, there, strict=True)]
        level = rows - np.array(off)[:, None]
        mean = np.where(there, level, 0.0).sum(axis=0) / count
    return np.asarray(np.where(there.any(axis=0), mean, np.nan))


def _from_mean(readings: Sequence[Array]) -> Array:
    """Mean square distance of each from the mean of all, constant errors apart."""
    mean = mean_course(readings)
    return np.array([float(np.nanvar(row - mean)) if np.isfinite(row).any() else 0.0 for row in readings])
