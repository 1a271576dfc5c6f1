"""The columns of a table as channels: values in SI over times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.refusal import Complaints
from network.recordings.csv_table import Heading, check_times


@dataclass(frozen=True, eq=False)
class Column:
    """One channel. values: in SI (temperatures in °C), NaN for gaps; unit: what it is shown in."""

    name: str
    unit: str
    values: Array


def channels(
    headings: Sequence[Heading], cells: Array, file: str, interval: float | None, complaints: Complaints
) -> tuple[Array, dict[str, Column]]:
    """Times [s] and the other columns in SI."""
    t = np.arange(len(cells), dtype=np.float64) * (interval or 1.0)
    columns = {}
    for k, heading in enumerate(headings):
        values = cells[:, k] * heading.unit.scale + heading.unit.offset
        if heading.name == "time":
            check_times(cells[:, k], heading.unit.text, file, complaints)
            t = values
        else:
            columns[heading.name] = Column(heading.name, heading.unit.text, values)
    return t, columns
