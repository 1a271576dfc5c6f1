"""Where a run's movement comes from: shares by part, cause and kind of movement, which add up to the whole."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from network.catalogue.declaration.declare import Array
from network.engine.trajectory import Trajectory, axis_unit
from network.platform.data_frame import data_frame
from network.platform.printing import Brief, Drawn
from network.platform.quantities.unit_values import in_own_unit

By = Literal["part", "cause", "kind"]
FEWEST_DIGITS = 5e-4
"""Of the largest movement: what three digits leave untold."""


@dataclass(frozen=True, eq=False, repr=False)
class Share(Brief):
    """What one cause moved an axis through one part and one kind of movement, over time [m, rad]."""

    axis: str
    part: str
    kind: str
    cause: str
    values: Array


@dataclass(frozen=True, eq=False, repr=False)
class Superposition(Drawn):
    """All shares of a run. remainder: axis → movement that they leave [m, rad]; how: the method in a sentence."""

    run: Trajectory
    shares: tuple[Share, ...]
    remainder: Mapping[str, Array]
    how: str

    def sum_by(self, axis: str, *by: By) -> dict[tuple[str, ...], Array]:
        """Shares of an axis added up, by the keys asked for: ('housing', 'friction') → over time."""
        sums: dict[tuple[str, ...], Array] = {}
        for share in self.shares:
            if share.axis == axis:
                key = tuple(str(getattr(share, name)) for name in by)
                sums[key] = sums[key] + share.values if key in sums else share.values
        return sums

    def furthest(self, axis: str) -> int:
        """The instant at which the axis is furthest from where it was at the start."""
        return int(np.argmax(np.abs(self.run.tcp[axis] - self.run.tcp[axis][0])))

    @property
    def is_told_whole(self) -> bool:
        """Whether the remainder lies below the digits that are told."""
        largest = {axis: float(np.abs(values).max()) for axis, values in self.run.tcp.items()}
        return all(float(np.abs(r).max()) <= FEWEST_DIGITS * largest[axis] for axis, r in self.remainder.items())

    def columns(self) -> Iterator[tuple[str, str, Array]]:
        """(name, unit, values in that unit) of what `columns_in_si` gives."""
        yield from ((name, text, in_own_unit(values, text)) for name, text, values in self.columns_in_si())

    def to_pandas(self) -> Any:
        """A data frame over time [s] of what `columns` gives. Raises ImportError without pandas."""
        return data_frame(self.columns(), ("time", "s", self.run.t))

    def columns_in_si(self) -> Iterator[tuple[str, str, Array]]:
        """(name, unit, values in SI) for parts.csv: by cause, by part, by kind, and all three at once; of these, what
        is never worth a digit is added up."""
        for axis in self.run.tcp:
            for by, word in (("cause", "from"), ("part", "through"), ("kind", "by")):
                for (name,), values in self.sum_by(axis, by).items():  # type: ignore[arg-type]
                    yield f"{word}.{axis}.{name}", axis_unit(axis), values
            yield from self._list_shares(axis)
            yield f"remainder.{axis}", axis_unit(axis), self.remainder[axis]

    def _list_shares(self, axis: str) -> Iterator[tuple[str, str, Array]]:
        least = FEWEST_DIGITS * float(np.abs(self.run.tcp[axis]).max())
        small = []
        for (part, kind, cause), values in self.sum_by(axis, "part", "kind", "cause").items():
            if np.abs(values).max() > least:
                yield f"share.{axis}.{part}.{kind}.{cause}", axis_unit(axis), values
            else:
                small.append(values)
        if small:
            yield f"share.{axis}.others", axis_unit(axis), np.sum(small, axis=0)
