"""The columns of tables as channels: values in SI over times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from network.catalogue.declaration.declare import Array, Indices, Mask
from network.platform.printing import Brief
from network.platform.quantities.unit_values import in_own_unit
from network.recordings.csv_table import Table


@dataclass(frozen=True, eq=False, repr=False)
class Column(Brief):
    """One channel. values: in SI (temperatures in °C), NaN for gaps; unit: what it is shown in; spread: how often the
    noise of its sensor each value has, where some were set right; once without."""

    name: str
    unit: str
    values: Array
    spread: Array | None = None

    @property
    def shown(self) -> Array:
        """The values in the unit."""
        return in_own_unit(self.values, self.unit)

    def keep(self, kept: Mask | slice) -> Column:
        """Some of its values."""
        spread = None if self.spread is None else self.spread[kept]
        return replace(self, values=self.values[kept], spread=spread)


@dataclass(frozen=True, eq=False, repr=False)
class Samples(Brief):
    """t: [s], as the clock of the file has it, in the order of the rows; lines: where each row stands; files: and in
    which of them; time_unit: what the file tells times in, '' for stamps."""

    t: Array
    columns: Mapping[str, Column]
    lines: Indices
    files: tuple[str, ...]
    file_of: Indices
    time_unit: str


def channels(tables: Sequence[Table], interval: float | None) -> Samples:
    """Tables with the same columns, one behind the other. Dates count from the first row [s], clocks from midnight."""
    headings = tables[0].headings
    cells = np.concatenate([table.cells for table in tables])
    file_of = np.repeat(np.arange(len(tables)), [len(table.cells) for table in tables])
    t, time_unit = np.arange(len(cells), dtype=np.float64) * (interval or 1.0), "s"
    columns = {}
    for k, heading in enumerate(headings):
        values = cells[:, k] * heading.unit.scale + heading.unit.offset
        if heading.name != "time":
            columns[heading.name] = Column(heading.name, heading.unit.text, values)
        elif heading.stamp:
            t, time_unit = _since_first(values), ""
        else:
            t, time_unit = values, heading.unit.text
    lines = np.concatenate([table.lines for table in tables])
    return Samples(t, columns, lines, tuple(table.file for table in tables), file_of, time_unit)


def _since_first(seconds: Array) -> Array:
    """Dates, which are more than a year of seconds from their origin, from the first on, to a microsecond."""
    known = seconds[np.isfinite(seconds)]
    if not len(known) or abs(known[0]) < 366 * 86400:
        return seconds
    return np.asarray(np.round(seconds - known[0], 6))
