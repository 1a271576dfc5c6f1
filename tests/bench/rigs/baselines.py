"""What can be said of a held-out run without any physics: nothing, ridge on lagged inputs, ridge on temperatures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from bench.rigs.figures import Figures, Left, counted, pooled
from bench.ridge import Run, fit_ridge, lagged

from network import Machine, Recording
from network.calibration.hygiene import look_at
from network.declare import Array
from network.units import difference, unit

LAGS, SHORTEST = 5, 1 / 64
"""How many, and the shortest as a share of the longest training run, which is the longest."""
PIECES = 4
"""Into which a single training run is cut, to be left out in turn."""
FIRST_READINGS = 60.0
"""s: the stretch whose mean is a first reading."""

Features = Callable[[Recording], Array]


@dataclass(frozen=True)
class Laid:
    """Runs to learn from and to be told, of one machine. counts: channel → input that must not be zero."""

    machine: Machine
    train: tuple[Recording, ...]
    holdout: tuple[Recording, ...]
    counts: Mapping[str, str]

    @property
    def channels(self) -> list[str]:
        runs = (*self.train, *self.holdout)
        return [name for name in self.machine.sensors if all(name in run.columns for run in runs)]

    @property
    def temperatures(self) -> list[str]:
        return [name for name in self.channels if self.machine.sensors[name].place is not None]

    @property
    def lags(self) -> Array:
        """Time constants [s]."""
        longest = max(float(run.t[-1] - run.t[0]) for run in self.train)
        return np.geomspace(SHORTEST * longest, longest, LAGS)


def baselines(
    machine: Path, train: Sequence[Path], holdout: Sequence[Path], counts: Mapping[str, str]
) -> dict[str, Figures]:
    """By name, on the held-out runs."""
    runs = (tuple(Recording.load(path) for path in paths) for paths in (train, holdout))
    laid = Laid(Machine.load(machine), *runs, counts)
    moved = [name for name in laid.channels if name not in laid.temperatures]
    told = {
        "nothing": _told(laid, {name: (lambda run: np.zeros(len(run.t))) for name in laid.channels}),
        "ridge on inputs": _told(laid, _predicted(laid, partial(_inputs, laid), laid.channels)),
    }
    if moved and laid.temperatures:
        told["ridge on temperatures"] = _told(laid, _predicted(laid, partial(_temperatures, laid), moved))
    return told


def _told(laid: Laid, predicted: Mapping[str, Callable[[Recording], Array]]) -> Figures:
    return pooled([_left(laid, run, name, says(run)) for run in laid.holdout for name, says in predicted.items()])


def _left(laid: Laid, run: Recording, name: str, predicted: Array) -> Left:
    """What is left of a channel whose change since its first reading was predicted [SI]."""
    sensor, kept = laid.machine.sensors[name], _usable(laid, run, name)
    scale = difference(unit(sensor.unit)).scale
    shown = "K" if unit(sensor.unit).is_temperature else "µm" if sensor.unit == "um" else sensor.unit
    return Left(name, shown, (_change(run, name) - predicted)[kept] / scale, sensor.sigma / scale)


def _change(run: Recording, name: str) -> Array:
    """Since the first reading: the mean of the first minute, or the first alone where readings are rarer."""
    values = run.columns[name].values
    early = values[run.t <= run.t[0] + FIRST_READINGS]
    return np.asarray(values - np.nanmedian(early))


def _usable(laid: Laid, run: Recording, name: str) -> Array:
    values, sigma = run.columns[name].values, laid.machine.sensors[name].sigma
    return np.asarray(look_at(name, values, sigma).used & counted(run, name, laid.counts))


def _predicted(laid: Laid, features: Features, channels: Sequence[str]) -> dict[str, Callable[[Recording], Array]]:
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
    return lagged(run.t, inputs, before, held=held, time_constants=laid.lags)
