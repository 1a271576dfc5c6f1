"""What was set aside of a recording: which channel, when, how far off and why."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from network.catalogue.declaration.declare import Array, Indices
from network.platform.quantities.text_table import digits, span
from network.platform.quantities.units import difference, unit
from network.recordings.columns import Column

ALWAYS = "reads the same at all times"


@dataclass(frozen=True, eq=False)
class SetAside:
    """Readings of one channel that count in no fit and no figure, or are only told where `is_told_only`.

    begin, until: instants of the first and of the last [s]; size: how far off, SI; unit: it is shown in; why: what is
    wrong with them; rows: which samples of the run.
    """

    channel: str
    begin: float
    until: float
    size: float
    unit: str
    why: str
    rows: Indices
    is_told_only: bool = False

    @classmethod
    def of(
        cls, t: Array, column: Column, rows: Indices, why: str, size: float = 0.0, is_told_only: bool = False
    ) -> SetAside:
        """Those rows of a channel."""
        ends = float(t[rows[0]]), float(t[rows[-1]])
        return cls(column.name, *ends, size, column.unit, why, rows, is_told_only)

    @property
    def readings(self) -> int:
        return len(self.rows)

    @property
    def shown_size(self) -> tuple[float, str]:
        """The size as a difference, and its unit."""
        given = unit(self.unit)
        return self.size / difference(given).scale, "K" if given.is_temperature else self.unit

    def summary(self) -> dict[str, Any]:
        """Its part of the results as JSON."""
        value, shown = self.shown_size
        size = {"value": value, "unit": shown}
        told = {"why": self.why, "readings": self.readings, "set_aside": not self.is_told_only}
        return {"from": self.begin, "until": self.until, "size": size, **told}

    def sentence(self, file: str) -> str:
        """What a user reads."""
        if self.why == ALWAYS:
            return f"{file}: {self.channel} {self.why}; it is left out"
        many = f"{self.readings} readings" if self.readings != 1 else "1 reading"
        when = f"from {span(self.begin)} to {span(self.until)}" if self.readings != 1 else f"at {span(self.begin)}"
        value, shown = self.shown_size
        by = f" by {digits(value)} {shown}" if self.size else ""
        left = "" if self.is_told_only else f"; {many} {'are' if self.readings != 1 else 'is'} left out"
        return f"{file}: {self.channel} {self.why}{by} {when}{left}"


def summarise_excluded(excluded: Iterable[SetAside]) -> dict[str, list[dict[str, Any]]]:
    """`excluded` of a run: what was set aside and what was only told, by channel."""
    found: dict[str, list[dict[str, Any]]] = {}
    for one in excluded:
        found.setdefault(one.channel, []).append(one.summary())
    return found
