"""From recordings to parts: what every temperature follows, which move alike, and which part follows which."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from network.analysis.drafting.channel_names import is_cooling
from network.analysis.drafting.channel_roles import Roles
from network.analysis.drafting.lag_bank import LagBank, bank_of
from network.analysis.drafting.lag_fit import Fitting, LagFit
from network.analysis.drafting.recorded_course import Course, courses_of
from network.analysis.drafting.sensor_groups import Group, group_sensors
from network.catalogue.declaration.declare import Array
from network.platform.quantities.units import unit
from network.recordings.hygiene.data_quality import noise_of, quantum_of
from network.recordings.recording import Recording

AROUND, ALWAYS = " surroundings", " always"
"""Columns of the bank that no recording has: the surroundings, and heat that is always on."""
SQUARED = tuple(unit(text).dimension for text in ("A", "V"))
"""Kinds of input whose heat goes with the square: Joule's law."""
RUBBING = tuple(unit(text).dimension for text in ("rpm", "m/min"))
"""Kinds of input that rub, which heats and never cools."""
FEWEST_BESIDE, MOST = 2, 0.5
"""Temperatures besides the surroundings that must be there to tell them, and the share of them that must follow."""
BIOT = 0.1
SHORTEST = 2.0
"""Cells: a shorter lag cannot be told from none."""
Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class PartModel:
    """A group of sensors as one part. alone: what it follows of inputs and surroundings; fit: with the part that it
    follows, too; parent: the index of that part, None where it follows none; gain: nats by which it does; gains: by index of
    every other part."""

    group: Group
    alone: LagFit
    fit: LagFit
    parent: int | None = None
    gain: float = 0.0
    gains: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Identified:
    """models: from the fastest part to the slowest; level: the surroundings where none are recorded [°C], spread: how
    far that may be off [K]; noise: 1σ of every sensor [K]; largest: of every input, the largest size
    recorded [SI]; units: of all columns; gapless: temperatures that all recordings have without gaps."""

    roles: Roles
    courses: tuple[Course, ...]
    models: tuple[PartModel, ...]
    level: float
    spread: float
    noise: Mapping[str, float]
    largest: Mapping[str, float]
    units: Mapping[str, str]
    gapless: tuple[str, ...]

    def goes_squared(self, name: str) -> bool:
        """Whether the heat of an input goes with its square."""
        return name in self.largest and unit(self.units[name]).dimension in SQUARED


def identify(runs: Sequence[Recording], roles: Roles, tell: Progress = lambda _: None) -> Identified:
    """Where no input is recorded, the temperature that the others follow is held. Raises Refused for inputs with gaps."""
    roles = _with_surroundings(runs, roles)
    found = _identify(runs, roles, tell)
    leader = "" if found.roles.inputs or roles.held else find_leader(found)
    if not leader:
        return found
    rest = tuple(name for name in roles.temperatures if name != leader)
    return _identify(runs, replace(roles, held=(leader,), temperatures=rest, leader=leader), tell)


def _with_surroundings(runs: Sequence[Recording], roles: Roles) -> Roles:
    """Where no name tells of surroundings: the temperature that no input drives and that most others follow."""
    open_to = [name for name in roles.temperatures if name in _gapless(runs, roles)]
    if roles.ambient or not roles.inputs or len(roles.temperatures) < FEWEST_BESIDE + 1 or not open_to:
        return roles
    bench = _bench(runs, roles)
    gains = {name: row for name, row in bench.list_gains_around(open_to).items() if np.mean(row > 0) > MOST}
    if not gains:
        return roles
    found = max(gains, key=lambda name: float(gains[name].sum()))
    rest = tuple(name for name in roles.temperatures if name != found)
    return replace(roles, ambient=found, temperatures=rest, is_by_behaviour=True)


def find_leader(found: Identified) -> str:
    """The sensor of the part whose temperature explains best those that are nearer to the surroundings than it is, by
    the nats that they gain: heat comes from there. '' where they gain none. One without gaps, for it becomes an input."""
    parts = found.models
    rises = [float(np.nanmean(m.group.mean**2)) for m in parts]
    whole = [[n for n in m.group.sensors if n in found.gapless] for m in parts]
    gains = [
        sum(max(m.gains.get(k, 0.0), 0.0) for m, rise in zip(parts, rises, strict=True) if rise < rises[k])
        for k in range(len(parts))
    ]
    open_to = [k for k in range(len(parts)) if whole[k] and gains[k] > 0]
    return whole[max(open_to, key=lambda k: gains[k])][0] if open_to else ""


def _identify(runs: Sequence[Recording], roles: Roles, tell: Progress) -> Identified:
    bench = _bench(runs, roles)
    models = bench.link(bench.group(tell), tell)
    rest = bench.noise, bench.largest, bench.units, _gapless(runs, roles)
    return Identified(bench.roles, bench.courses, models, bench.level, bench.spread, *rest)


def _bench(runs: Sequence[Recording], roles: Roles) -> _Bench:
    drivers = (*roles.inputs, *roles.held, *((roles.ambient,) if roles.ambient else ()))
    courses = courses_of(runs, drivers, (*roles.temperatures, *roles.displacements))
    level, spread = _level(courses, roles)
    roles = without_silent(roles, courses)
    largest = {n: max(float(np.abs(c.values[n]).max()) for c in courses) for n in roles.inputs}
    units = {name: column.unit for run in runs for name, column in (*run.constants.items(), *run.columns.items())}
    noise = {name: _noise(runs, name) for name in roles.temperatures}
    return _Bench(runs, roles, courses, level, spread, units, noise, largest)


def _gapless(runs: Sequence[Recording], roles: Roles) -> tuple[str, ...]:
    return tuple(
        name for name in roles.temperatures
        if all(name in run.columns and np.isfinite(run.columns[name].values).all() for run in runs)
    )  # fmt: skip


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
    """Where temperatures begin, in the middle, and how far the runs differ in it, 2 K at least."""
    if roles.ambient:
        rows = [float(np.mean(c.values[roles.ambient])) for c in courses]
    else:
        begins = [[_first(c.values[n]) for n in roles.temperatures if np.isfinite(c.values[n]).any()] for c in courses]
        rows = [float(np.median(b)) for b in begins if b]
    return float(np.median(rows)), max(2.0, float(np.std(rows)))


def _first(values: Array) -> float:
    return float(values[np.isfinite(values)][0])


def _noise(runs: Sequence[Recording], name: str) -> float:
    """1σ of a sample: from second differences, at least that of rounding to its steps."""
    rows = [run.columns[name].values for run in runs if name in run.columns]
    rows = [row[np.isfinite(row)] for row in rows]
    told = [max(noise_of(row), quantum_of(row) / np.sqrt(12)) for row in rows if len(row) > 4]
    typical = float(np.median(told)) if told else 0.0
    return typical if typical > 0 else 0.01


@dataclass(frozen=True, eq=False)
class _Bench:
    """What lag models of one set of recordings share."""

    runs: Sequence[Recording]
    roles: Roles
    courses: tuple[Course, ...]
    level: float
    spread: float
    units: Mapping[str, str]
    noise: Mapping[str, float]
    largest: Mapping[str, float]

    def list_gains_around(self, names: Sequence[str]) -> dict[str, Array]:
        """Of every name that no input drives, the nats by which each other temperature is better told with it as
        surroundings than with constant ones."""
        known = [n for n in self.roles.temperatures if self._known(n) > 0]
        bank = self._bank({f"other {n}": self._rise(n) for n in names})
        fittings = {n: self._fitting(bank, self._rise(n), self.noise[n] ** 2 / self._samples(n)) for n in known}
        told = {name: fitting.select([AROUND], self.roles.inputs) for name, fitting in fittings.items()}
        free = [n for n in names if told[n].gain_over(fittings[n].fit([AROUND])) <= 0]
        return {
            name: np.array([
                fittings[n].select([f"other {name}"], self.roles.inputs).gain_over(told[n]) for n in known if n != name
            ])
            for name in free
        }  # fmt: skip

    def group(self, tell: Progress) -> tuple[Group, ...]:
        """Groups of temperatures that move alike; see _left_of for what differences are measured by."""
        names = [n for n in self.roles.temperatures if self._known(n) > 0]
        readings = [self._rise(name) for name in names]
        columns = {f"other {n}": row for n, row in zip(names, readings, strict=True) if self._in_all(row)}
        bank, fits = self._bank(columns), list[LagFit]()
        for k, name in enumerate(names):
            fitting = self._fitting(bank, readings[k], self.noise[name] ** 2 / self._samples(name))
            fits.append(self._left_of(fitting, [other for other in columns if other != f"other {name}"]))
            tell(0.7 * (k + 1) / len(names))
        return group_sensors(names, readings, [f.square for f in fits], [f.independent for f in fits])

    def _left_of(self, fitting: Fitting, others: Sequence[str]) -> LagFit:
        """The best model of a temperature that follows inputs and at most one other temperature, which it follows with
        a lag: what follows another at once is the same part, and tells nothing of what a model leaves."""
        alone = best = self._alone(fitting)
        own = [name for name in alone.weights if name != AROUND]
        for other in others:
            with_it = fitting.fit([AROUND, other, *own])
            if not self._at_once(with_it, other, alone) and with_it.gain_over(alone) > 0:
                best = min(best, with_it, key=lambda fit: fit.square)
        return best

    def _at_once(self, fit: LagFit, other: str, alone: LagFit) -> bool:
        """Whether one temperature follows another as inside one part: with no lag that can be told, or with a tenth of
        its lag and of its loss (Bi < 0.1, where a body may be taken as one lump: Incropera, ch. 5.2)."""
        share = fit.weights.get(AROUND, 0.0) / max(fit.weights.get(other, 0.0), 1e-12)
        is_lumped = fit.tau <= BIOT * alone.tau and share <= BIOT
        return is_lumped or fit.tau <= SHORTEST * max(c.step for c in self.courses)

    def _alone(self, fitting: Fitting, *others: str) -> LagFit:
        """Inputs first; heat that is always on only for what they leave."""
        told = fitting.select([AROUND, *others], (*self.roles.inputs, *self.roles.held))
        with_it = fitting.fit([*dict.fromkeys([AROUND, *others, *told.weights]), ALWAYS])
        return with_it if with_it.gain_over(told) > 0 else told

    def link(self, groups: Sequence[Group], tell: Progress) -> tuple[PartModel, ...]:
        """Parts from the fastest to the slowest, each beside the faster one that explains most of it."""
        titles = [f"part {k}" for k in range(len(groups))]
        means = {title: group.mean for title, group in zip(titles, groups, strict=True) if self._in_all(group.mean)}
        bank = self._bank(means)
        fittings = [self._fitting(bank, g.mean, self._floor(g)) for g in groups]
        alone = [self._alone(fitting) for fitting in fittings]
        order = sorted(range(len(groups)), key=lambda k: (not set(alone[k].weights) - {AROUND}, alone[k].tau))
        rank = {k: place for place, k in enumerate(order)}
        models = list[PartModel]()
        for place, k in enumerate(order):
            fits = {q: self._alone(fittings[k], titles[q]) for q in order if q != k and titles[q] in means}
            fits = {q: fit for q, fit in fits.items() if titles[q] in fit.weights}
            gains = {rank[q]: fit.gain_over(alone[k]) for q, fit in fits.items()}
            model = PartModel(groups[k], alone[k], alone[k], gains=gains)
            parent = max((q for q in fits if rank[q] < place), key=lambda q: gains[rank[q]], default=None)
            if parent is not None and gains[rank[parent]] > 0:
                weights = {OTHER if n == titles[parent] else n: w for n, w in fits[parent].weights.items()}
                fit = replace(fits[parent], weights=weights)
                model = replace(model, fit=fit, parent=rank[parent], gain=gains[rank[parent]])
            models.append(model)
            tell(0.7 + 0.3 * (place + 1) / len(order))
        return tuple(self._refine(models, [fittings[k] for k in order]))

    def _refine(self, models: Sequence[PartModel], fittings: Sequence[Fitting]) -> list[PartModel]:
        """With two lags for parts that follow no other, where the second is worth its numbers; but none with a part
        behind it that others follow: they are what it warms."""
        followed = {m.parent for m in models}
        refined = list[PartModel]()
        for k, (model, fitting) in enumerate(zip(models, fittings, strict=True)):
            if model.parent is None and set(model.fit.weights) - {AROUND}:
                two = fitting.fit_two([*dict.fromkeys([AROUND, *model.fit.weights])], only_late=k in followed)
                if two.gain_over(model.fit) > 0 and set(two.weights) - {AROUND}:
                    model = replace(model, fit=two)
            refined.append(model)
        return refined

    def _bank(self, means: Mapping[str, Array]) -> LagBank:
        columns: dict[str, Sequence[Array]] = {AROUND: [self._around(c) for c in self.courses]}
        columns[ALWAYS] = [np.ones(c.cells) for c in self.courses]
        for name in self.roles.inputs:
            columns[name] = [self._heat(name, c) for c in self.courses]
        for name in self.roles.held:
            columns[name] = [c.values[name] - self._base(c) for c in self.courses]
        ends = np.cumsum([c.cells for c in self.courses])[:-1]
        for title, mean in means.items():
            columns[title] = [_bridge(row) for row in np.split(mean, ends)]
        return bank_of(self.courses, columns)

    def _fitting(self, bank: LagBank, target: Array, floor: float) -> Fitting:
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

    def _rise(self, name: str) -> Array:
        return np.concatenate([c.values[name] - self._base(c) for c in self.courses])

    def _in_all(self, mean: Array) -> bool:
        ends = np.cumsum([c.cells for c in self.courses])[:-1]
        return all(np.isfinite(row).sum() > 1 for row in np.split(mean, ends))

    def _known(self, name: str) -> int:
        return int(np.isfinite(self._rise(name)).sum())

    def _samples(self, name: str) -> float:
        """Readings in a cell."""
        count = sum(int(np.isfinite(r.columns[name].values).sum()) for r in self.runs if name in r.columns)
        return max(count / self._known(name), 1.0)

    def _floor(self, group: Group) -> float:
        return min(self.noise[n] ** 2 / self._samples(n) for n in group.sensors) / len(group.sensors)


OTHER = " part it follows"
"""The column of the part that another follows."""


def _bridge(row: Array) -> Array:
    """Straight lines through gaps."""
    known = np.flatnonzero(np.isfinite(row))
    return np.interp(np.arange(len(row)), known, row[known])
