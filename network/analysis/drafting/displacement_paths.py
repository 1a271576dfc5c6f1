"""Which parts move the tool: displacement as a sum of their rises, by least squares and evidence.

d(t) − d(0) = Σ k_p (T_p(t) − T_p(0)), k = ± α L of a part that stretches. Forward selection by BIC, as for what drives a
temperature; each run has a zero of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from network.analysis.drafting.lag_fit import count_independent
from network.analysis.drafting.part_models import Identified
from network.catalogue.declaration.declare import Array
from network.recordings.hygiene.data_quality import noise_of, quantum_of
from network.recordings.recording import Recording

STEEL = 1.1e-5
"""1/K: the expansion that lengths are told for."""
MOST_REPEATS, FEWEST_REPEATS = 0.9, 0.5
"""Readings that repeat the one before: of a display that is frozen, and of one that is not."""
FEWEST = 12


@dataclass(frozen=True, eq=False)
class Path:
    """One channel. slopes: displacement over temperature, by the index of a part or
    the name of a held temperature [m/K]; left, moved: rms of what they leave
    and of the whole [m]; noise: 1σ of a sample [m]; gate: an input, while which is zero the reading is frozen, or ''."""

    channel: str
    axis: str
    slopes: Mapping[int | str, float]
    left: float
    moved: float
    noise: float
    gate: str


def find_paths(runs: Sequence[Recording], found: Identified) -> tuple[Path, ...]:
    """Of every channel of displacement."""
    return tuple(_find_path(runs, found, name, axis) for name, axis in found.roles.displacements.items())


def _find_path(runs: Sequence[Recording], found: Identified, name: str, axis: str) -> Path:
    gate = next((i for i in found.roles.inputs if _is_frozen(runs, name, i)), "")
    there = [run.columns[name].values for run in runs if name in run.columns]
    known = [row[np.isfinite(row)] for row in there]
    noise = float(np.median([max(noise_of(row), quantum_of(row) / np.sqrt(12)) for row in known if len(row) > 4] or [0]))
    target = _targets(found, name, gate)
    slopes, left = _select(found, target)
    moved = float(np.sqrt(np.nanmean(target**2))) if np.isfinite(target).any() else 0.0
    return Path(name, axis, slopes, left, moved, noise if noise > 0 else 1e-7, gate)


def _is_frozen(runs: Sequence[Recording], name: str, gate: str) -> bool:
    """Whether readings repeat while an input is zero, and not while it is not."""
    still, moving = list[Array](), list[Array]()
    for run in (run for run in runs if name in run.columns):
        same = np.diff(run.columns[name].values) == 0
        off = run.signal(gate).at(run.t) == 0
        still.append(same[off[1:] & off[:-1]])
        moving.append(same[~off[1:] & ~off[:-1]])
    zero, rest = (np.concatenate(rows) if rows else np.empty(0) for rows in (still, moving))
    return bool(min(len(zero), len(rest)) >= FEWEST and zero.mean() > MOST_REPEATS and rest.mean() < FEWEST_REPEATS)


def _targets(found: Identified, name: str, gate: str) -> Array:
    """Over the cells of all runs, less the first reading of each; NaN where it is not known or frozen."""
    rows = []
    for course in found.courses:
        values = course.values[name].copy()
        if gate:
            values[course.values[gate] == 0] = np.nan
        known = values[np.isfinite(values)]
        rows.append(values - known[0] if len(known) else values)
    return np.concatenate(rows)


def _select(found: Identified, target: Array) -> tuple[dict[int | str, float], float]:
    """Parts that are worth a place, with their slopes, and the rms that they leave."""
    run = np.repeat(np.arange(len(found.courses)), [c.cells for c in found.courses])
    rows = [m.group.mean for m in found.models]
    rows += [np.concatenate([c.values[name] for c in found.courses]) for name in found.roles.held]
    keys: list[int | str] = [*range(len(found.models)), *found.roles.held]
    use, best = list[int](), _fit(rows, [], target, run)
    while len(use) < len(rows):
        tried = {k: _fit(rows, [*use, k], target, run) for k in range(len(rows)) if k not in use}
        k = min(tried, key=lambda j: tried[j][1])
        worth = count_independent(tried[k][2], run)
        if worth * np.log(max(best[1], 1e-30) / max(tried[k][1], 1e-30)) <= np.log(max(worth, 2.0)):
            break
        use, best = [*use, k], tried[k]
    return dict(zip([keys[k] for k in use], best[0].tolist(), strict=True)), float(np.sqrt(best[1]))


def _fit(rows: Sequence[Array], use: Sequence[int], target: Array, run: Array) -> tuple[Array, float, Array]:
    """(slopes, mean square left, residual); each run about its own mean."""
    there = np.isfinite(target)
    for k in use:
        there = there & np.isfinite(rows[k])
    if there.sum() <= len(use) + len(np.unique(run)):
        return np.zeros(len(use)), np.inf, np.full(len(target), np.nan)
    x = np.stack([rows[k][there] for k in use], axis=1) if use else np.empty((int(there.sum()), 0))
    x, y = _centre(x, run[there]), _centre(target[there][:, None], run[there])[:, 0]
    slopes = np.linalg.lstsq(x, y, rcond=None)[0]
    residual = np.full(len(target), np.nan)
    residual[there] = y - x @ slopes
    return slopes, float(np.nanmean(residual**2)), residual


def _centre(x: Array, run: Array) -> Array:
    out = x.copy()
    for one in np.unique(run):
        out[run == one] -= x[run == one].mean(axis=0)
    return out
