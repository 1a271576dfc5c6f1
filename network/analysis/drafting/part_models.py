"""From recordings to parts: which temperatures move alike, what every part follows, and which part follows which."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from network.analysis.drafting.lag_bench import ALWAYS, AROUND, OTHER, LagBench
from network.analysis.drafting.lag_fit import Fitting, LagFit
from network.analysis.drafting.sensor_groups import Group, group_sensors
from network.catalogue.sensors.sensor_lag import SensorLag

BIOT = 0.1
"""Of the resistance to the surroundings that inside a body, below which it may be taken as one lump (Incropera and
DeWitt, Fundamentals of Heat and Mass Transfer, ch. 5.2)."""
SHORTEST = 2.0
"""Cells: a shorter lag cannot be told from none."""
LONGEST = SensorLag.params()["lag"].high
"""s: no sensor is later."""
GROUPED = 0.7
"""Of the time that parts take: to find groups."""
Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class PartModel:
    """A group of sensors as one part. alone: what it follows of inputs and surroundings; fit: with the part that it
    follows, too; parent: the index of that part, None where it follows none; gain: nats by which it does; gains: by
    index of every other part."""

    group: Group
    alone: LagFit
    fit: LagFit
    parent: int | None = None
    gain: float = 0.0
    gains: Mapping[int, float] = field(default_factory=dict)


def group_alike(bench: LagBench, tell: Progress) -> tuple[Group, ...]:
    """Groups of temperatures that move alike; see _left_of for what differences are measured by."""
    names, readings = bench.known, [bench.rise(name) for name in bench.known]
    columns = {f"other {n}": row for n, row in zip(names, readings, strict=True) if bench.is_in_all(row)}
    bank, fits = bench.bank(columns), list[LagFit]()
    for k, name in enumerate(names):
        fitting = bench.fitting(bank, readings[k], bench.floor([name]))
        fits.append(_left_of(bench, fitting, [other for other in columns if other != f"other {name}"]))
        tell(GROUPED * (k + 1) / len(names))
    return group_sensors(names, readings, [f.square for f in fits], [f.independent for f in fits])


def _left_of(bench: LagBench, fitting: Fitting, others: Sequence[str]) -> LagFit:
    """The best model of a temperature that follows inputs and at most one other temperature, which it follows with a
    lag: what follows another at once is the same part, and tells nothing of what a model leaves."""
    alone = best = fit_alone(bench, fitting)
    own = [name for name in alone.weights if name != AROUND]
    for other in others:
        with_it = fitting.fit([AROUND, other, *own])
        if not _is_at_once(bench, with_it, other, alone) and with_it.gain_over(alone) > 0:
            best = min(best, with_it, key=lambda fit: fit.square)
    return best


def _is_at_once(bench: LagBench, fit: LagFit, other: str, alone: LagFit) -> bool:
    """Whether one temperature follows another as inside one part: with no lag that can be told, or with a tenth of its
    lag and of its loss."""
    share = fit.weights.get(AROUND, 0.0) / max(fit.weights.get(other, 0.0), 1e-12)
    is_lumped = fit.tau <= BIOT * alone.tau and share <= BIOT
    return is_lumped or fit.tau <= SHORTEST * max(c.step for c in bench.courses)


def fit_alone(bench: LagBench, fitting: Fitting, *others: str) -> LagFit:
    """What a temperature follows of inputs, besides the surroundings and others; heat that is always on only for what
    they leave."""
    told = fitting.select([AROUND, *others], (*bench.roles.inputs, *bench.roles.held))
    with_it = fitting.fit([*dict.fromkeys([AROUND, *others, *told.weights]), ALWAYS])
    return with_it if with_it.gain_over(told) > 0 else told


def link_parts(bench: LagBench, groups: Sequence[Group], tell: Progress) -> tuple[PartModel, ...]:
    """Parts from the fastest to the slowest, each beside the faster one that explains most of it."""
    titles = [f"part {k}" for k in range(len(groups))]
    means = {title: group.mean for title, group in zip(titles, groups, strict=True) if bench.is_in_all(group.mean)}
    bank = bench.bank(means)
    fittings = [bench.fitting(bank, group.mean, bench.floor(group.sensors)) for group in groups]
    alone = [fit_alone(bench, fitting) for fitting in fittings]
    order = sorted(range(len(groups)), key=lambda k: (not _is_driven(alone[k]), alone[k].tau))
    models = list[PartModel]()
    for place, k in enumerate(order):
        others = [titles[q] if q != k and titles[q] in means else "" for q in order]
        models.append(_beside(bench, fittings[k], PartModel(groups[k], alone[k], alone[k]), others, place))
        tell(GROUPED + (1 - GROUPED) * (place + 1) / len(order))
    return tuple(_refine(models, [fittings[k] for k in order], [titles[k] for k in order]))


def _is_driven(fit: LagFit) -> bool:
    """By more than its surroundings."""
    return bool(set(fit.weights) - {AROUND})


def _is_seen(fit: LagFit, fitting: Fitting) -> bool:
    """Whether two lags are longer than what cells tell, and of a part that something drives."""
    shortest = SHORTEST * max(course.step for course in fitting.bank.courses)
    return _is_driven(fit) and fit.lags is not None and shortest < fit.lags.short < LONGEST


def _beside(bench: LagBench, fitting: Fitting, model: PartModel, others: Sequence[str], place: int) -> PartModel:
    """With the best of the parts before its place, where it is worth its numbers. others: columns of all parts in their
    order, '' for what cannot be followed."""
    fits = {q: fit_alone(bench, fitting, other) for q, other in enumerate(others) if other}
    fits = {q: fit for q, fit in fits.items() if others[q] in fit.weights}
    gains = {q: fit.gain_over(model.alone) for q, fit in fits.items()}
    parent = max((q for q in fits if q < place), key=lambda q: gains[q], default=None)
    if parent is None or gains[parent] <= 0:
        return replace(model, gains=gains)
    fit = _rename(fits[parent], others[parent], OTHER)
    return replace(model, fit=fit, parent=parent, gain=gains[parent], gains=gains)


def _rename(fit: LagFit, old: str, new: str) -> LagFit:
    """With one of its columns under another name."""
    return replace(fit, weights={new if name == old else name: w for name, w in fit.weights.items()})


def _refine(models: Sequence[PartModel], fittings: Sequence[Fitting], titles: Sequence[str]) -> list[PartModel]:
    """With exact time constants, and two lags for parts that follow no other, where the second is worth its numbers;
    but none with a part behind it that others follow: they are what it warms."""
    followed = {m.parent for m in models}
    refined = list[PartModel]()
    for k, (model, fitting) in enumerate(zip(models, fittings, strict=True)):
        own = OTHER if model.parent is None else titles[model.parent]
        fit = fitting.refine(_rename(model.fit, OTHER, own))
        if model.parent is None and _is_driven(fit):
            two = fitting.fit_two([*dict.fromkeys([AROUND, *fit.weights])], only_late=k in followed)
            fit = two if two.gain_over(fit) > 0 and _is_seen(two, fitting) else fit
        refined.append(replace(model, fit=_rename(fit, own, OTHER)))
    return refined
