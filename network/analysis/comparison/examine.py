"""All tests on the residuals of one recording."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from network.analysis.comparison.amounts import to_unit
from network.analysis.comparison.candidate_drivers import Candidate, forms, normalise, without
from network.analysis.comparison.cycles import CLEAR, cycles_by_regime
from network.analysis.comparison.drivers import LEAST, SURE, Companion, Driver, companions, correlation, drivers
from network.analysis.comparison.lagged_drivers import find_lagging
from network.analysis.comparison.lags import autocorrelations, independent
from network.analysis.comparison.periodicity import Periodicity, periodicity
from network.analysis.comparison.resample import Grid, fill_gaps, reading_step
from network.analysis.comparison.speed_levels import ByRegime, Regimes, by_regime, regimes_of
from network.analysis.comparison.spikes import Spikes, calm_spikes
from network.analysis.comparison.whiteness import Whiteness, whiteness
from network.analysis.comparison.window import worst_window
from network.catalogue.declaration.declare import Array

if TYPE_CHECKING:
    from network.analysis.comparison.channel_residual import ChannelResidual
    from network.engine.trajectory import Trajectory
    from network.recordings.columns import Column


@dataclass(frozen=True)
class Window:
    """first..last: [s] from the start of the recording's clock; mean: residual in it, SI."""

    first: float
    last: float
    mean: float
    unit: str

    def summary(self) -> dict[str, Any]:
        return {"from": self.first, "to": self.last, "mean": to_unit(self.mean, self.unit)}


@dataclass(frozen=True)
class ChannelTests:
    """What the tests say of one channel; None and empty where nothing is significant or there is too little to test."""

    name: str
    whiteness: Whiteness | None
    period: Periodicity | None
    drivers: tuple[Driver, ...]
    companions: tuple[Companion, ...]
    regimes: ByRegime | None
    window: Window | None
    spikes: Spikes | None = None

    def summary(self) -> dict[str, Any]:
        """The key `tests` of `compare --json`."""
        one = {"whiteness": self.whiteness, "period": self.period, "regimes": self.regimes, "worst": self.window}
        told: dict[str, Any] = {key: None if value is None else value.summary() for key, value in one.items()}
        told["drivers"] = [driver.summary() for driver in self.drivers]
        told["companions"] = [companion.summary() for companion in self.companions]
        return told


@dataclass(frozen=True, eq=False)
class Rows:
    """The channels of a recording on a grid. si: residuals, NaN in gaps; values: in σ about their mean, 0 in gaps;
    r: autocorrelations."""

    channels: Sequence[ChannelResidual]
    grid: Grid
    si: Array
    values: Array
    there: Array
    r: Array
    pairs: Array

    @property
    def rms(self) -> Array:
        """About the mean, in σ."""
        return np.asarray(np.sqrt((self.values**2).sum(axis=1) / np.maximum(self.there.sum(axis=1), 1)))


def examine(
    residuals: Mapping[str, ChannelResidual], run: Trajectory, columns: Mapping[str, Column], unused: Sequence[str]
) -> Mapping[str, ChannelTests]:
    """Tests of every channel of a recording that has readings, without those that lie far apart."""
    calm = [calm_spikes(channel) for channel in residuals.values() if channel.n]
    channels = [channel for channel, _ in calm]
    grid = Grid.of(run.t)
    rows = rows_of(channels, grid)
    candidates = candidates_of(run, columns, unused, grid)
    regimes = regimes_of(run, grid)
    driven = _find_drivers(rows, candidates)
    together = _together(rows)
    periods = _periods(rows, candidates, regimes)
    return {
        channel.name: ChannelTests(
            channel.name,
            whiteness(channel, rows.values[k], rows.r[k], rows.pairs[k], grid.step),
            periods[k], driven[k], together[k],
            None if regimes is None
            else by_regime(channel.name, channel.unit, channel.sigma, rows.si[k], rows.r[k], regimes),
            Window(*worst_window(channel), channel.unit), calm[k][1],
        )
        for k, channel in enumerate(channels)
    }  # fmt: skip


def rows_of(channels: Sequence[ChannelResidual], grid: Grid) -> Rows:
    si = np.stack([grid.put(channel.residual) for channel in channels])
    values, there = fill_gaps(si / np.array([[channel.sigma] for channel in channels]))
    return Rows(channels, grid, si, values, there, *autocorrelations(values, there))


def candidates_of(run: Trajectory, columns: Mapping[str, Column], unused: Sequence[str], grid: Grid) -> list[Candidate]:
    """Inputs and unused columns that vary, in all their forms."""
    candidates: list[Candidate] = []
    for name, values in run.inputs.items():
        candidates += forms(name, grid.hold(values), True, grid)
    for name in unused:
        candidates += forms(name, grid.put(columns[name].values), False, grid)
    return candidates


def _find_drivers(rows: Rows, candidates: Sequence[Candidate]) -> list[tuple[Driver, ...]]:
    if not candidates:
        return [()] * len(rows.channels)
    z, z_there = fill_gaps(np.stack([candidate.values for candidate in candidates]))
    r, pairs = correlation(rows.values, rows.there, z, z_there)
    worth = independent(rows.r, autocorrelations(z, z_there)[0], pairs)
    named = [channel.name for channel in rows.channels]
    plain = [drivers(named[k], candidates, r[k], worth[k], float(rows.rms[k])) for k in range(len(named))]
    return [(*found, *_find_late(rows, k, candidates, found)) for k, found in enumerate(plain)]


def _find_late(rows: Rows, k: int, candidates: Sequence[Candidate], found: Sequence[Driver]) -> Iterator[Driver]:
    """Drivers that a channel follows late, beside those found at once; the closest first."""
    named = {driver.of for driver in found}
    own = [c for c in candidates if c.form == "value" and c.name not in named]
    late = [(c, find_lagging(rows.values[k], rows.there[k], c, rows.grid, SURE / len(own))) for c in own]
    for c, lagging in sorted(((c, found) for c, found in late if found is not None), key=lambda pair: -abs(pair[1].r)):
        if abs(lagging.r) > LEAST:
            form = replace(c, form="lagged" if lagging.lag else "value", lag=lagging.lag)
            worth = lagging.r, float(lagging.blocks), min(lagging.p * len(own), 1.0)
            yield Driver(rows.channels[k].name, c.name, form.form, form.lag, c.is_input, *worth, float(rows.rms[k]),
                         form.words, by_changes=True)  # fmt: skip


def _together(rows: Rows) -> list[tuple[Companion, ...]]:
    r, pairs = correlation(rows.values, rows.there, rows.values, rows.there)
    worth = independent(rows.r, rows.r, pairs)
    named = [channel.name for channel in rows.channels]
    return [companions(named, k, r[k], worth[k], float(rows.rms[k])) for k in range(len(named))]


def _periods(rows: Rows, candidates: Sequence[Candidate], regimes: Regimes | None) -> list[Periodicity | None]:
    """Periods of what the inputs do not explain, with their change from level to level."""
    inputs = [candidate.values for candidate in candidates if candidate.is_input]
    inputs += [values**2 for values in map(normalise, inputs)]
    free = without(rows.values, inputs, rows.there)
    periods: list[Periodicity | None] = []
    for k, channel in enumerate(rows.channels):
        period = periodicity(channel.name, channel.unit, channel.sigma, free[k], rows.there[k], rows.grid.step)
        if period is not None and period.amplitude < reading_step(channel.measured) / 2:
            period = None  # rounding alone makes such a sawtooth out of a slope
        if period is not None:
            told = regimes is not None and period.clarity > CLEAR
            levels = cycles_by_regime(free[k], rows.grid.step, period.period, regimes) if told and regimes else ()
            period = replace(period, by_regime=levels)
        periods.append(period)
    return periods
