"""What can be said of a held-out run without any physics: nothing, ridge on lagged inputs, ridge on temperatures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from bench.ridge import Run, fit_ridge, lagged
from bench.rigs.case import dump, read
from bench.rigs.figures import Figures, Left, counted, left, pooled

from network import Machine, Recording
from network.catalogue.declaration.declare import Array, Mask
from network.platform.quantities.units import unit
from network.recordings.hygiene.data_quality import look_at

LAGS, SHORTEST = 5, 1 / 64
"""How many, and the shortest as a share of the longest training run, which is the longest."""
PIECES = 4
"""Into which a single training run is cut, to be left out in turn."""
FIRST_READINGS = 60.0
"""s: the stretch whose mean is a first reading."""

Features = Callable[[Recording], Array]
Predict = Callable[[Recording], Array]


@dataclass(frozen=True)
class Laid:
    """Runs to learn from and to be told, of one machine. before: the held-out ones with what was recorded before
    them; counts: channel → input that must not be zero."""

    machine: Machine
    train: tuple[Recording, ...]
    holdout: tuple[Recording, ...]
    before: tuple[Recording, ...]
    counts: Mapping[str, str]

    @property
    def channels(self) -> list[str]:
        runs = (*self.train, *self.holdout)
        return [name for name in self.machine.sensors if all(name in run.columns for run in runs)]

    @property
    def moved(self) -> list[str]:
        """Channels of displacement."""
        return [name for name in self.channels if self.machine.sensors[name].place is None]

    @property
    def temperatures(self) -> list[str]:
        """Columns without gaps, whether the machine knows them or not."""
        runs = (*self.train, *self.before)
        warm = [name for name, column in runs[0].columns.items() if unit(column.unit).is_temperature]
        return [name for name in warm if all(name in r.columns and np.isfinite(r.columns[name].values).all()
                                             for r in runs)]  # fmt: skip

    @property
    def lags(self) -> Array:
        """Time constants [s]."""
        longest = max(float(run.t[-1] - run.t[0]) for run in self.train)
        return np.geomspace(SHORTEST * longest, longest, LAGS)


def baselines(
    machine: Path, train: Sequence[Path], holdout: Sequence[Path], counts: Mapping[str, str]
) -> dict[str, Figures]:
    """By name, on the held-out runs."""
    before = [whole(path) for path in holdout]
    runs = [tuple(Recording.load(path) for path in paths) for paths in (train, holdout, before)]
    laid = Laid(Machine.load(machine), runs[0], runs[1], runs[2], counts)
    told = {
        "nothing": _told(laid, dict.fromkeys(laid.channels, _stays)),
        "ridge on inputs": _told(laid, _predicted(laid, partial(_inputs, laid), laid.channels)),
    }
    if laid.moved and laid.temperatures:
        told["ridge on temperatures"] = _told(laid, _predicted(laid, partial(_temperatures, laid), laid.moved))
    return told


def whole(path: Path) -> Path:
    """The mapping of a run with what stands before it in its file; beside it."""
    tree = read(path)
    if "from" not in tree:
        return path
    beside = path.with_name(f"whole-{path.name}")
    dump({key: value for key, value in tree.items() if key != "from"}, beside)
    return beside


def _told(laid: Laid, predicted: Mapping[str, Predict]) -> Figures:
    runs = zip(laid.holdout, laid.before, strict=True)
    return pooled([_left(laid, run, name, says(before)) for run, before in runs for name, says in predicted.items()])


def _left(laid: Laid, run: Recording, name: str, predicted: Array) -> Left:
    """What is left of a channel whose course was predicted [SI], both since the run's beginning."""
    sensor, kept = laid.machine.sensors[name], _usable(laid, run, name)
    since = predicted[len(predicted) - len(run.t) :]
    if len(predicted) > len(run.t):
        since = since - since[0]
    return left(name, sensor.unit, sensor.sigma, (_change(run, name) - since)[kept])


def _stays(run: Recording) -> Array:
    return np.zeros(len(run.t))


def _change(run: Recording, name: str) -> Array:
    """Since the first reading, the mean of the first minute."""
    values = run.columns[name].values
    return np.asarray(values - np.nanmean(values[run.t <= run.t[0] + FIRST_READINGS]))


def _usable(laid: Laid, run: Recording, name: str) -> Mask:
    values, sigma = run.columns[name].values, laid.machine.sensors[name].sigma
    return np.asarray(look_at(name, values, sigma).used & counted(run, name, laid.counts))


def _predicted(laid: Laid, features: Features, channels: Sequence[str]) -> dict[str, Predict]:
    return {name: partial(_says, _learned(laid, features, name), features) for name in channels}


def _says(predict: Callable[[Array], Array], features: Features, run: Recording) -> Array:
    return predict(features(run))[:, 0]


def _learned(laid: Laid, features: Features, name: str) -> Callable[[Array], Array]:
    runs = []
    for run in laid.train:
        target = np.where(_usable(laid, run, name), _change(run, name), np.nan)[:, None]
        runs.append(Run(features(run), target))
    return fit_ridge(runs if len(runs) > 1 else _cut(runs[0])).predict


def _cut(run: Run) -> list[Run]:
    cells = np.array_split(np.arange(len(run.targets)), PIECES)
    return [Run(run.features[cell], run.targets[cell]) for cell in cells]


def _inputs(laid: Laid, run: Recording) -> Array:
    """Schedule and room with their lags; before the run the schedule is zero and the room as at its beginning."""
    slow = [name for name, wanted in laid.machine.inputs.items() if unit(wanted).is_temperature]
    fast = [name for name in laid.machine.inputs if name not in slow]
    signals = run.schedule(laid.machine.inputs).signals
    laps = [_lagged(laid, run, [signals[name].at(run.t) for name in names], names is fast) for names in (slow, fast)]
    return np.hstack([lap for lap in laps if lap.shape[1]])


def _temperatures(laid: Laid, run: Recording) -> Array:
    return _lagged(laid, run, [run.columns[name].values for name in laid.temperatures], False)


def _lagged(laid: Laid, run: Recording, values: Sequence[Array], held: bool) -> Array:
    if not values:
        return np.empty((len(run.t), 0))
    inputs = np.stack(values, axis=1)
    before = np.zeros(len(values)) if held else inputs[0]
    return lagged(run.t, inputs, before, held=held, time_constants=laid.lags.tolist())
