"""What lag models of one set of recordings share: the columns that may drive, and the readings to be told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.analysis.comparison.resample import reading_step
from network.analysis.drafting.channel_names import is_cooling
from network.analysis.drafting.channel_roles import Roles
from network.analysis.drafting.lag_bank import LagBank, bank_of
from network.analysis.drafting.lag_fit import Fitting
from network.analysis.drafting.recorded_course import Course, courses_of
from network.catalogue.declaration.declare import Array
from network.platform.quantities.units import unit
from network.recordings.hygiene.data_quality import noise_of, quantum_of
from network.recordings.recording import Recording

AROUND, ALWAYS, OTHER = " surroundings", " always", " part it follows"
"""Columns that no recording has: the surroundings, heat that is always on, and the part that another follows."""
SQUARED = tuple(unit(text).dimension for text in ("A", "V"))
"""Kinds of input whose heat goes with the square: Joule's law."""
RUBBING = tuple(unit(text).dimension for text in ("rpm", "m/min"))
"""Kinds of input whose sign does not matter: friction heats either way."""
SPREAD, RESOLUTION = 2.0, 0.01
"""K: how far surroundings that nobody recorded may be off at least, and the noise of a sensor that shows none."""
FEWEST, MOSTLY = 4, 0.5
"""Readings that tell no noise, and the share that must repeat so that second differences tell none."""


@dataclass(frozen=True, eq=False)
class LagBench:
    """level, spread: surroundings where none are recorded, and how far they may be off [°C, K]; units: of all columns;
    noise: 1σ of every sensor [K]; largest: of every input, the largest size recorded [SI]."""

    runs: Sequence[Recording]
    roles: Roles
    courses: tuple[Course, ...]
    level: float
    spread: float
    units: Mapping[str, str]
    noise: Mapping[str, float]
    largest: Mapping[str, float]

    def goes_squared(self, name: str) -> bool:
        """Whether the heat of an input goes with its square."""
        return name in self.largest and unit(self.units[name]).dimension in SQUARED

    def bank(self, means: Mapping[str, Array]) -> LagBank:
        """What is recorded of drivers, and these temperatures over the cells of all runs."""
        columns: dict[str, Sequence[Array]] = {AROUND: [self._around(c) for c in self.courses]}
        columns[ALWAYS] = [np.ones(c.cells) for c in self.courses]
        for name in self.roles.inputs:
            columns[name] = [self._heat(name, c) for c in self.courses]
        for name in self.roles.held:
            columns[name] = [c.values[name] - self._base(c) for c in self.courses]
        for title, mean in means.items():
            columns[title] = [_bridge(row) for row in self._by_run(mean)]
        return bank_of(self.courses, columns)

    def fitting(self, bank: LagBank, target: Array, floor: float) -> Fitting:
        """Of one temperature."""
        heats = {ALWAYS, *self.roles.inputs}
        signed = {n for n in self.roles.inputs if is_cooling(n)}
        conducts = [name for name in bank.names if name not in heats]
        return Fitting(bank, target, bank.moments(target), conducts, signed, floor)

    def _heat(self, name: str, course: Course) -> Array:
        values = course.values[name]
        kind = unit(self.units[name]).dimension
        return values**2 if kind in SQUARED else np.abs(values) if kind in RUBBING else values

    def _base(self, course: Course) -> float:
        """What the temperatures of a run are counted from."""
        return float(course.values[self.roles.ambient][0]) if self.roles.ambient else self.level

    def _around(self, course: Course) -> Array:
        if not self.roles.ambient:
            return np.zeros(course.cells)
        return np.asarray(course.values[self.roles.ambient] - self._base(course))

    def rise(self, name: str) -> Array:
        """A temperature over what the run is counted from, over the cells of all runs."""
        return np.concatenate([c.values[name] - self._base(c) for c in self.courses])

    def is_in_all(self, mean: Array) -> bool:
        """Whether every run has it."""
        return all(np.isfinite(row).sum() > 1 for row in self._by_run(mean))

    def _by_run(self, mean: Array) -> list[Array]:
        return np.split(mean, np.cumsum([c.cells for c in self.courses])[:-1])

    @property
    def known(self) -> list[str]:
        """Temperatures with a reading."""
        return [name for name in self.roles.temperatures if self.count_known(name) > 0]

    def count_known(self, name: str) -> int:
        """Cells with a reading."""
        return int(np.isfinite(self.rise(name)).sum())

    def samples(self, name: str) -> float:
        """Readings in a cell."""
        count = sum(int(np.isfinite(r.columns[name].values).sum()) for r in self.runs if name in r.columns)
        return max(count / self.count_known(name), 1.0)

    def floor(self, sensors: Sequence[str]) -> float:
        """The mean square in a cell that the mean of sensors cannot do without [K²]."""
        return min(self.noise[n] ** 2 / self.samples(n) for n in sensors) / len(sensors)


def set_up(runs: Sequence[Recording], roles: Roles) -> LagBench:
    """Raises Refused for inputs with gaps."""
    drivers = (*roles.inputs, *roles.held, *((roles.ambient,) if roles.ambient else ()))
    courses = courses_of(runs, drivers, (*roles.temperatures, *roles.displacements))
    level, spread = _level(courses, roles)
    roles = without_silent(roles, courses)
    largest = {n: max(float(np.abs(c.values[n]).max()) for c in courses) for n in roles.inputs}
    units = {name: signal.unit for run in runs for name, signal in run.constants.items()}
    units |= {name: column.unit for run in runs for name, column in run.columns.items()}
    noise = {name: typical_noise(runs, name, FEWEST, RESOLUTION) for name in roles.temperatures}
    return LagBench(runs, roles, courses, level, spread, units, noise, largest)


def list_gapless(runs: Sequence[Recording], roles: Roles) -> tuple[str, ...]:
    """Temperatures that may become inputs: all recordings have them without gaps, and nobody says they are sensors."""
    open_to = [name for name in roles.temperatures if name not in roles.sensors]
    there = [name for name in open_to if all(name in run.columns for run in runs)]
    return tuple(n for n in there if all(np.isfinite(run.columns[n].values).all() for run in runs))


def without_silent(roles: Roles, courses: Sequence[Course]) -> Roles:
    """Without inputs that are zero, and without all but one of those that are constant."""
    low = {n: min(float(c.values[n].min()) for c in courses) for n in roles.inputs}
    high = {n: max(float(c.values[n].max()) for c in courses) for n in roles.inputs}
    constant = [n for n in roles.inputs if low[n] == high[n]]
    first = next((n for n in constant if high[n] != 0), "")
    silent = {n: "it is zero at all times" if high[n] == 0 else f"it is constant, as {first} is" for n in constant}
    silent = {n: why for n, why in silent.items() if n != first}
    return replace(roles, inputs=tuple(n for n in roles.inputs if n not in silent), unused={**roles.unused, **silent})


def _level(courses: Sequence[Course], roles: Roles) -> tuple[float, float]:
    """Where temperatures begin, in the middle, and how far the runs differ in it, SPREAD at least."""
    if roles.ambient:
        rows = [float(np.mean(c.values[roles.ambient])) for c in courses]
    else:
        begins = [[_first(c.values[n]) for n in roles.temperatures if np.isfinite(c.values[n]).any()] for c in courses]
        rows = [float(np.median(b)) for b in begins if b]
    return float(np.median(rows)), max(SPREAD, float(np.std(rows)))


def _first(values: Array) -> float:
    return float(values[np.isfinite(values)][0])


def noise_in(values: Array) -> float:
    """1σ of a sample, from second differences; at least that of rounding to the steps of the readings, and of readings
    that mostly repeat the one before, that of their jumps: √(mean square difference/2)."""
    jumps = np.diff(values)
    of_jumps = np.sqrt(np.mean(jumps**2) / 2) if np.mean(jumps == 0) > MOSTLY else 0.0
    return float(max(noise_of(values), max(quantum_of(values), reading_step(values)) / np.sqrt(12), of_jumps))


def typical_noise(runs: Sequence[Recording], name: str, fewest: int, resolution: float) -> float:
    """1σ of a sample, that of a typical run of more than so many readings; what cannot be seen where none shows."""
    rows = [run.columns[name].values for run in runs if name in run.columns]
    told = [noise_in(row[np.isfinite(row)]) for row in rows if np.isfinite(row).sum() > fewest]
    typical = float(np.median(told)) if told else 0.0
    return typical if typical > 0 else resolution


def _bridge(row: Array) -> Array:
    """Straight lines through gaps."""
    known = np.flatnonzero(np.isfinite(row))
    return np.interp(np.arange(len(row)), known, row[known])
