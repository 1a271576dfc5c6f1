"""What a simulation gives: channels over time, the displacement of the tool centre point, heat, and the account."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.entry_path import displacement
from network.catalogue.expansions.base import ANGULAR_AXES
from network.engine.energy import EnergyAccount
from network.engine.network import Network
from network.machine.machine import Machine
from network.platform.data_frame import data_frame
from network.platform.printing import Drawn
from network.platform.quantities.unit_values import in_own_unit
from network.platform.refusal import UnknownName, likely
from network.recordings.inputs import Schedule

ROUNDING = 1e-12
"""m, rad: a millionth of a micrometre. What is left where parts move alike and cancel is rounding below it."""


def drop_rounding(values: Array) -> Array:
    """Movements of an axis [m, rad]; zeros where none is more than rounding."""
    return values if np.abs(values).max(initial=0.0) >= ROUNDING else np.zeros_like(values)


def axis_unit(axis: str) -> str:
    """um on x, y, z; urad on a, b, c."""
    return "urad" if axis in ANGULAR_AXES else "um"


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Drawn):
    """One run. Everything over `t` [s]; inside SI and °C, `shown` gives a channel in its unit.

    inputs, sensors: by name; tcp: axis → displacement [m] or angle [rad]; contributions: (axis, entry) → the same;
    parts: node → mean temperature [°C]; heat: part → heat absorbed since the start [J]; T_start, T_end: all lumps;
    error: estimate of the numerical error [K]; switches: (instant, entry, on or off); states: of entries, by path;
    pieces: the runs it was joined from, where a recording is parted.
    """

    machine: Machine
    schedule: Schedule
    network: Network
    t: Array
    inputs: Mapping[str, Array]
    sensors: Mapping[str, Array]
    tcp: Mapping[str, Array]
    contributions: Mapping[tuple[str, str], Array]
    parts: Mapping[str, Array]
    heat: Mapping[str, Array]
    T_start: Array
    T_end: Array
    energy: EnergyAccount
    switches: tuple[tuple[float, str, bool], ...]
    method: str
    why: str
    solve_seconds: float
    error: float
    warnings: tuple[str, ...]
    states: Mapping[str, Array] = field(default_factory=dict)
    pieces: tuple[Trajectory, ...] = ()

    def of_axis(self, axis: str) -> dict[str, Array]:
        """The contributions to an axis, by entry [m, rad]."""
        return {name: values for (a, name), values in self.contributions.items() if a == axis}

    def columns(self) -> Iterator[tuple[str, str, Array]]:
        """(name, unit, values in that unit) of every input, sensor and tcp axis: the columns of results.csv."""
        yield from ((name, text, in_own_unit(values, text)) for name, text, values in self.columns_in_si())

    def part_columns(self) -> Iterator[tuple[str, str, Array]]:
        """(name, unit, values in that unit) of every part's temperature and heat, of every contribution, of every state
        of an entry: the columns of parts.csv."""
        yield from ((name, text, in_own_unit(values, text)) for name, text, values in self.part_columns_in_si())

    def columns_in_si(self) -> Iterator[tuple[str, str, Array]]:
        """`columns`, values in SI and °C; the unit is that which they are shown in."""
        for name, values in self.inputs.items():
            yield name, self.schedule.signals[name].unit, values
        for name, values in self.sensors.items():
            yield name, self.machine.sensors[name].unit, values
        for axis, values in self.tcp.items():
            yield displacement(axis), axis_unit(axis), values

    def part_columns_in_si(self) -> Iterator[tuple[str, str, Array]]:
        """`part_columns`, values in SI and °C."""
        for name, values in self.parts.items():
            yield f"T.{name}", "degC", values
        for name, values in self.heat.items():
            yield f"heat.{name}", "kJ", values
        for (axis, name), values in self.contributions.items():
            yield f"{displacement(axis)}.{name}", axis_unit(axis), values
        for path, values in self.states.items():
            yield path, self.machine.states[path].unit, values

    def find_column(self, name: str) -> tuple[str, str, Array]:
        """(name, unit, values in that unit) of an input, sensor, tcp axis (`tcp.z` or `z`), part (`T.housing` or
        `housing`), contribution (`tcp.z.housing grows`) or heat (`heat.housing`). Raises UnknownName."""
        known = {column: (text, values) for column, text, values in self.columns_in_si()}
        known |= {column: (text, values) for column, text, values in self.part_columns_in_si() if column not in known}
        meant = next((each for each in (name, displacement(name), f"T.{name}") if each in known), None)
        if meant is None:
            raise UnknownName(f"there is no channel '{name}'; {likely(name, [*known, *self.tcp, *self.parts])}")
        text, values = known[meant]
        return meant, text, in_own_unit(values, text)

    def shown(self, name: str) -> Array:
        """A channel by its name in its unit (degC, um, rpm …). Raises UnknownName, which says what there is."""
        return self.find_column(name)[2]

    def to_pandas(self, parts: bool = False) -> Any:
        """A data frame over time [s] of what `columns` gives, with `parts` of what `part_columns` gives, too. Raises
        ImportError without pandas."""
        more = self.part_columns() if parts else ()
        return data_frame([*self.columns(), *more], ("time", "s", self.t))

    def summary(self) -> dict[str, Any]:
        """What summary.json holds."""
        account = self.energy
        energy = {"in": account.in_, "out": account.out, "stored": account.total_stored, "closure": account.closure}
        return {
            "method": self.method,
            "why": self.why,
            "solve_seconds": self.solve_seconds,
            "error_estimate": {"value": self.error, "unit": "K"},
            "energy": {
                **energy,
                "unit": "J",
                "by_mechanism": dict(account.by_mechanism),
                "absorbed": dict(account.absorbed),
            },
            "tcp": {axis: self._extent(axis) for axis in self.tcp},
            "switches": len(self.switches),
            "warnings": list(self.warnings),
        }

    def _extent(self, axis: str) -> dict[str, Any]:
        values = in_own_unit(self.tcp[axis], axis_unit(axis))
        ends = {"max": values.max(), "min": values.min(), "final": values[-1]}
        return {key: float(value) for key, value in ends.items()} | {"unit": axis_unit(axis)}
