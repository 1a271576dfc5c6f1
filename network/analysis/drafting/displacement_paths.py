"""Which parts move the tool: displacement as a sum of their rises, by least squares and evidence.

d(t) − d(0) = Σ k_p (T_p(t) − T_p(0)), k = ± α L of a part that stretches. A machine will know T_p to s_p, what its lag
model leaves, and so d to Σ k_p² s_p² at best: slopes minimise |d − Σ k T|² + n Σ k² s², which keeps large ones of
opposite sign away that hold in these recordings only. Forward selection by BIC of that sum, one or two parts at a time,
because paths of opposite sign show only together; each run has a zero of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from network.analysis.drafting.identification import Identified
from network.analysis.drafting.lag_bench import typical_noise
from network.analysis.drafting.lag_fit import count_independent
from network.catalogue.declaration.declare import Array, Indices
from network.recordings.recording import Recording

STEEL = 1.1e-5
"""1/K: the expansion that lengths are told for."""
REPEATS, TIMES = 0.9, 5.0
"""Share of readings that repeat the one before while a display is frozen, and how many times as often it moves else."""
FEWEST, RESOLUTION = 12, 1e-7
"""Readings that tell nothing, and the noise of a probe that shows none [m]."""


@dataclass(frozen=True, eq=False)
class Path:
    """One channel. slopes: displacement over temperature, by the index of a part or the name of a held temperature
    [m/K]; left, moved: rms of what they leave and of the whole [m]; noise: 1σ of a sample [m]; gate: an input, while
    which is zero the reading is frozen, or ''."""

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
    target = _targets(found, name, gate)
    slopes, left = _select(found, target)
    moved = float(np.sqrt(np.nanmean(target**2))) if np.isfinite(target).any() else 0.0
    return Path(name, axis, slopes, left, moved, typical_noise(runs, name, FEWEST, RESOLUTION), gate)


def _is_frozen(runs: Sequence[Recording], name: str, gate: str) -> bool:
    """Whether readings repeat while an input is zero, and not while it is not."""
    still, moving = list[Array](), list[Array]()
    for run in (run for run in runs if name in run.columns):
        same = np.diff(run.columns[name].values) == 0
        off = run.signal(gate).at(run.t) == 0
        still.append(same[off[1:] & off[:-1]])
        moving.append(same[~off[1:] & ~off[:-1]])
    zero, rest = (np.concatenate(rows) if rows else np.empty(0) for rows in (still, moving))
    return bool(
        min(len(zero), len(rest)) >= FEWEST and zero.mean() > REPEATS and 1 - rest.mean() > TIMES * (1 - zero.mean())
    )


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


@dataclass(frozen=True, eq=False)
class _Candidates:
    """Displacement and temperatures of all that may move it, each run about its own mean, where all are known.

    known: s² of each; run: of each cell."""

    x: Array
    y: Array
    known: Array
    run: Indices

    def fit(self, use: Sequence[int]) -> tuple[float, Array]:
        """(mean square left, that of the temperatures in it; slopes)."""
        x, n = self.x[:, use], max(len(self.y), 1)
        moments, joint = x.T @ x / n + np.diag(self.known[use]), x.T @ self.y / n
        slopes = np.linalg.lstsq(moments, joint, rcond=1e-12)[0]
        return float(self.y @ self.y / n - joint @ slopes), np.asarray(slopes)

    def independent(self, use: Sequence[int], slopes: Array) -> float:
        return count_independent(self.y - self.x[:, use] @ slopes, self.run)


def _select(found: Identified, target: Array) -> tuple[dict[int | str, float], float]:
    """Parts that are worth a place, with their slopes, and the rms that they leave."""
    keys: list[int | str] = [*range(len(found.models)), *found.roles.held]
    all_of = _candidates(found, target)
    use, (square, slopes) = list[int](), all_of.fit([])
    while len(all_of.y) > FEWEST:
        free = [k for k in range(len(keys)) if k not in use]
        tried = {add: all_of.fit([*use, *add]) for add in (*((k,) for k in free), *combinations(free, 2))}
        best = [min((a for a in tried if len(a) == size), key=lambda a: tried[a][0], default=()) for size in (1, 2)]
        gains = {a: _gain(all_of, square, [*use, *a], tried[a], len(a)) for a in best if a}
        add = max(gains, key=lambda a: gains[a], default=())
        if not add or gains[add] <= 0:
            break
        use, (square, slopes) = [*use, *add], tried[add]
    left = all_of.y - all_of.x[:, use] @ slopes
    rms = float(np.sqrt(np.mean(left**2))) if len(left) else 0.0
    return dict(zip([keys[k] for k in use], slopes.tolist(), strict=True)), rms


def _candidates(found: Identified, target: Array) -> _Candidates:
    rows = [m.group.mean for m in found.models]
    rows += [np.concatenate([c.values[name] for c in found.courses]) for name in found.roles.held]
    known = np.array([*(m.fit.square for m in found.models), *(0.0 for _ in found.roles.held)])
    run = np.repeat(np.arange(len(found.courses)), [c.cells for c in found.courses])
    there = np.isfinite(target) & np.isfinite(rows).all(axis=0)
    x, y = np.stack(rows, axis=1)[there], target[there][:, None]
    return _Candidates(_centre(x, run[there]), _centre(y, run[there])[:, 0], known, run[there])


def _gain(all_of: _Candidates, before: float, use: Sequence[int], after: tuple[float, Array], more: int) -> float:
    """Nats of evidence, as of lag models."""
    n = all_of.independent(use, after[1])
    return float(n * np.log(max(before, 1e-30) / max(after[0], 1e-30)) - more * np.log(max(n, 2.0))) / 2


def _centre(x: Array, run: Indices) -> Array:
    out = x.copy()
    for one in np.unique(run):
        out[run == one] -= x[run == one].mean(axis=0)
    return out
