"""A table of the paper with ours beside it: cells as numbers, and how they are shown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any, TypeAlias

from network.platform.quantities.text_table import table

Cell: TypeAlias = float | str | None
WIDTH = 120


@dataclass(frozen=True)
class PaperTable:
    """columns: name → format of its numbers, '' for words; notes: what the numbers mean, in sentences."""

    name: str
    title: str
    columns: Mapping[str, str]
    rows: Sequence[Sequence[Cell]]
    notes: Sequence[str] = ()

    def lines(self) -> Iterator[str]:
        hows = self.columns.values()
        cells = [[_format_cell(cell, how) for cell, how in zip(row, hows, strict=True)] for row in self.rows]
        yield self.title
        yield from table(list(self.columns), cells, [name for name, how in self.columns.items() if how])
        for note in self.notes:
            yield from wrap(note, WIDTH, initial_indent="  - ", subsequent_indent="    ")

    def as_dict(self) -> dict[str, Any]:
        rows = [dict(zip(self.columns, row, strict=True)) for row in self.rows]
        return {"title": self.title, "rows": rows, "notes": list(self.notes)}


def _format_cell(cell: Cell, how: str) -> str:
    """A number in its format, – for none."""
    if cell is None:
        return "–"
    return cell if isinstance(cell, str) else format(cell, how)
