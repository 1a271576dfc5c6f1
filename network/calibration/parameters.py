"""The numbers a calibration may move, in the coordinates it moves them in: the logarithm, or the number itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from network.declare import Array
from network.machine import Machine
from network.quantities import ParamField
from network.refusal import Spot, likely, refuse
from network.units import Number, show

SECTIONS = ("materials", "nodes", "links", "sources", "sensors")
Named: TypeAlias = dict[str, dict[str, Any]]
WIDEST = 8.0
"""Prior σ that a number with ± may move at most: beyond, its file is wrong and not its value."""


@dataclass(frozen=True)
class Parameter:
    """One free number. centre, spread, low, high: prior mean, σ and bounds in θ; θ = log value, or value.

    path: as in the file, like 'links.skin.conductance'; a flat prior counts as a wide normal one within its bounds.
    """

    path: str
    field: ParamField
    number: Number
    is_log: bool
    centre: float
    spread: float
    low: float
    high: float

    @property
    def entry(self) -> str:
        return self.path.rpartition(".")[0]

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

    def told(self, theta: float, digits: int = 4) -> str:
        return show(self.value(theta), self.field.unit, digits)

    @property
    def is_unknown(self) -> bool:
        return self.number.prior == "unknown"


def parameter(machine: Machine, path: str, number: Number | None = None) -> Parameter:
    """The parameter at a path of a machine; `number` replaces its prior. Raises Refused where there is none."""
    entry_path, _, key = path.rpartition(".")
    entry = dict(machine.entries()).get(entry_path)
    fields = {f.key: f for f in entry.params().values()} if entry is not None else {}
    if entry is None or key not in fields:
        raise refuse(Spot(machine.file), f"there is no number '{path}'", likely(path, machine.uncertain))
    field = fields[key]
    number = number or entry.numbers.get(field.attribute, Number(float(entry.__dict__[field.attribute])))
    return _parameter(path, field, number)


def _parameter(path: str, field: ParamField, number: Number) -> Parameter:
    is_log = not field.may_be_negative and number.prior != "normal"
    if number.prior == "unknown":
        low, high = ((math.log(v) if v > 0 else math.log(number.high * 1e-6)) if is_log else v for v in
                     (number.low, number.high))  # fmt: skip
        return Parameter(path, field, number, is_log, (low + high) / 2, (high - low) / 2, low, high)
    centre = math.log(number.value) if is_log else number.value
    spread = number.spread or 1.0
    ends = [math.log(v) if v > 0 else -math.inf for v in (field.low, field.high)] if is_log else (field.low, field.high)
    low, high = max(ends[0], centre - WIDEST * spread), min(ends[1], centre + WIDEST * spread)
    return Parameter(path, field, number, is_log, centre, spread, low, high)


def free_parameters(machine: Machine) -> tuple[Parameter, ...]:
    """All numbers with ± or `unknown`."""
    return tuple(parameter(machine, path) for path in machine.uncertain)


def at_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """The machine with numbers exchanged, by path; entries that look at others look again."""
    changed: dict[str, dict[str, float]] = {}
    entries = dict(machine.entries())
    for path, value in values.items():
        entry_path, _, key = path.rpartition(".")
        fields = {f.key: f.attribute for f in entries[entry_path].params().values()}
        changed.setdefault(entry_path, {})[fields[key]] = value
    parts: Named = {name: {**getattr(machine, name)} for name in SECTIONS}
    tcp: Named = {axis: {**own} for axis, own in machine.tcp.items()}
    for path, exchanged in changed.items():
        _exchange(parts, tcp, path, exchanged)
    new = replace(
        machine, materials=parts["materials"], nodes=parts["nodes"], links=parts["links"], sources=parts["sources"],
        sensors=parts["sensors"], tcp=tcp,
    )  # fmt: skip
    if any(path.startswith(("nodes.", "materials.")) for path in changed):
        for name, entry in parts["nodes"].items():
            parts["nodes"][name] = entry.resolved(new)
        for own in tcp.values():
            own.update({name: entry.resolved(new) for name, entry in own.items()})
    return new


def _exchange(parts: Named, tcp: Named, path: str, values: Mapping[str, float]) -> None:
    """Puts numbers into the entry at a path, inside another one too (melting ranges, effects of sensors)."""
    section, _, rest = path.partition(".")
    if section == "tcp":
        axis, _, name = rest.partition(".")
        tcp[axis][name] = tcp[axis][name].replaced(**values)
        return
    named = parts[section]
    if rest in named:
        named[rest] = named[rest].replaced(**values)
    elif rest.endswith(".melts"):
        node = named[name := rest.removesuffix(".melts")]
        named[name] = node.replaced(melts=node.melts.replaced(**values))
    else:
        name, _, index = rest.rpartition(".effects.")
        sensor = named[name]
        effects = list(sensor.effects)
        effects[int(index)] = effects[int(index)].replaced(**values)
        named[name] = sensor.replaced(effects=tuple(effects))


def centres(parameters: Sequence[Parameter]) -> Array:
    return np.array([p.centre for p in parameters])


def values_at(parameters: Iterable[Parameter], theta: Array) -> dict[str, float]:
    """Numbers in SI by path."""
    return {p.path: p.value(float(x)) for p, x in zip(parameters, theta, strict=True)}
