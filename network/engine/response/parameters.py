"""The numbers a calibration may move, in the coordinates it moves them in: the logarithm, or the number itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from network.catalogue.declaration.declare import Array, Declared
from network.catalogue.declaration.entry_path import EntryPath, Keys, NumberPath
from network.catalogue.declaration.number_fields import ParamField
from network.catalogue.declaration.sections import TCP
from network.machine.machine import Machine
from network.platform.quantities.units import Number, difference, show, unit
from network.platform.refusal import Spot, likely, refuse

SECTIONS = ("materials", "nodes", "links", "sources", "sensors")
WIDEST = 8.0
"""Prior σ that a number with ± may move at most: beyond, its file is wrong and not its value."""


@dataclass(frozen=True, repr=False)
class Parameter:
    """One free number. centre, spread, low, high: prior mean, σ and bounds in θ; θ = log value, or value.

    A flat prior counts as a wide normal one within its bounds.
    """

    entry: EntryPath
    field: ParamField
    number: Number
    is_log: bool
    centre: float
    spread: float
    low: float
    high: float

    @cached_property
    def path(self) -> str:
        """As its user writes it, like 'links.skin.conductance'."""
        return str(NumberPath(self.entry, self.field.key))

    def __repr__(self) -> str:
        return f"<{self.path}: {self.format_value(self.centre)}>"

    @property
    def attribute(self) -> str:
        return self.field.attribute

    def value(self, theta: float) -> float:
        """The number in SI."""
        return math.exp(theta) if self.is_log else theta

    def slope(self, value: float) -> float:
        """∂value/∂θ."""
        return value if self.is_log else 1.0

    def std(self, theta: float, spread: float) -> float:
        """1σ of the value from 1σ of θ, linearised."""
        return self.slope(self.value(theta)) * spread

    def format_value(self, theta: float, digits: int = 4) -> str:
        return show(self.value(theta), self.field.unit, digits)

    def to_unit(self, value: float) -> float:
        """A value in the unit its field is stated in; a difference of temperatures in kelvin."""
        given = unit(self.field.unit)
        return (difference(given) if self.field.unit == "K" else given).from_si(value)

    def std_to_unit(self, std: float) -> float:
        """1σ of the value in that unit."""
        return std / difference(unit(self.field.unit)).scale

    @property
    def is_unknown(self) -> bool:
        return self.number.prior == "unknown"


def parameter(machine: Machine, path: NumberPath, number: Number | None = None) -> Parameter:
    """The parameter at a path of a machine; `number` replaces its prior. Raises Refused where there is none."""
    entry = machine.by_path.get(path.entry)
    fields = {f.key: f for f in entry.params().values()} if entry is not None else {}
    if entry is None or path.key not in fields:
        raise refuse(Spot(machine.file), f"there is no number '{path}'", likely(str(path), machine.uncertain))
    field = cast(ParamField, entry.field_of(fields[path.key].attribute))
    number = number or entry.numbers.get(field.attribute, Number(float(entry.__dict__[field.attribute])))
    return _parameter(path.entry, field, number)


def _parameter(entry: EntryPath, field: ParamField, number: Number) -> Parameter:
    is_log = not field.may_be_negative and number.prior != "normal"
    if number.prior == "unknown":
        low, high = ((math.log(v) if v > 0 else math.log(number.high * 1e-6)) if is_log else v for v in
                     (number.low, number.high))  # fmt: skip
        return Parameter(entry, field, number, is_log, (low + high) / 2, (high - low) / 2, low, high)
    centre = math.log(number.value) if is_log else number.value
    spread = number.spread or 1.0
    ends = [math.log(v) if v > 0 else -math.inf for v in (field.low, field.high)] if is_log else (field.low, field.high)
    low, high = max(ends[0], centre - WIDEST * spread), min(ends[1], centre + WIDEST * spread)
    return Parameter(entry, field, number, is_log, centre, spread, low, high)


def free_parameters(machine: Machine) -> tuple[Parameter, ...]:
    """All numbers with ± or `unknown`."""
    entries = machine.by_path.items()
    return tuple(parameter(machine, NumberPath(path, key)) for path, entry in entries for key in entry.uncertain())


def at_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """The machine with numbers exchanged, by path; entries that look at others look again."""
    changed: dict[EntryPath, dict[str, float]] = {}
    for text, value in values.items():
        if (number := NumberPath.parse(text, machine.paths)) is None:
            raise KeyError(text)
        fields = {f.key: f.attribute for f in machine.by_path[number.entry].params().values()}
        changed.setdefault(number.entry, {})[fields[number.key]] = value
    held: dict[tuple[str, str], dict[str, Any]] = {(name, ""): {**getattr(machine, name)} for name in SECTIONS}
    held |= {(TCP, axis): {**own} for axis, own in machine.tcp.items()}
    for path, exchanged in changed.items():
        own = held[path.section, path.axis]
        own[path.name] = _exchange(own[path.name], path.inner, exchanged)
    machine = _with_entries(machine, held)
    if any(path.section in ("nodes", "materials") for path in changed):
        _resolve_again(machine, held, "nodes", TCP)
    if any(path.section == "sensors" for path in changed):
        _resolve_again(machine, held, "sensors")
    return machine


def _exchange(entry: Declared, inner: Keys, values: Mapping[str, float]) -> Declared:
    """An entry with numbers exchanged: its own, or those of one that it holds."""
    if not inner:
        return entry.replaced(**values)
    key = str(inner[0])
    held = entry.__dict__[key]
    if not isinstance(held, tuple):
        return entry.replaced(**{key: _exchange(held, inner[1:], values)})
    more = tuple(_exchange(e, inner[2:], values) if i == inner[1] else e for i, e in enumerate(held))
    return entry.replaced(**{key: more})


def _with_entries(machine: Machine, held: Mapping[tuple[str, str], dict[str, Any]]) -> Machine:
    """The machine with other entries, by section and axis."""
    tcp = {axis: held[TCP, axis] for axis in machine.tcp}
    named = {name: held[name, ""] for name in SECTIONS}
    return replace(
        machine, materials=named["materials"], nodes=named["nodes"], links=named["links"], sources=named["sources"],
        sensors=named["sensors"], tcp=tcp,
    )  # fmt: skip


def _resolve_again(machine: Machine, held: Mapping[tuple[str, str], dict[str, Any]], *sections: str) -> None:
    """Nodes take what materials give now, expansions what nodes are, and sensors what others have, in the entries that
    a new machine holds."""
    for (section, _), entries in held.items():
        if section in sections:
            entries.update({name: entry.resolve(machine) for name, entry in entries.items()})


def centres(parameters: Sequence[Parameter]) -> Array:
    return np.array([p.centre for p in parameters])


def values_at(parameters: Iterable[Parameter], theta: Array) -> dict[str, float]:
    """Numbers in SI by path."""
    return {p.path: p.value(float(x)) for p, x in zip(parameters, theta, strict=True)}


def at_prior_centres(machine: Machine, parameters: Sequence[Parameter]) -> Machine:
    """The machine before anything is learned."""
    return at_values(machine, values_at(parameters, centres(parameters)))
