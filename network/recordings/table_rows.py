"""The rows of a table as text, with the line of each; what is no row is told or passed over."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TextIO

from network.platform.quantities.units import BadNumber, unit
from network.platform.refusal import Spot, refuse
from network.recordings.numbers import is_number
from network.recordings.text_layout import EXPECTED, MARK, UTF8, WORKBOOKS, Layout
from network.recordings.workbook import workbook_rows

Row = tuple[int, list[str]]


@dataclass(frozen=True)
class Header:
    """labels: of the columns, `1`, `2` … where the file names none; units: of a second line, () without; line: where
    it stands, 0 without."""

    labels: tuple[str, ...]
    units: tuple[str, ...] = ()
    line: int = 0

    @property
    def told(self) -> list[str]:
        """`name [unit]` where a line of units stands below the names."""
        if not self.units:
            return list(self.labels)
        pairs = zip(self.labels, self.units, strict=True)
        return [f"{label} [{text or '1'}]" if label else "" for label, text in pairs]


@contextmanager
def open_text(path: Path, encoding: str) -> Iterator[TextIO]:
    """The file as text; what is no readable CSV is refused."""
    try:
        with path.open(encoding=encoding, newline="") as handle:
            yield handle
    except UnicodeDecodeError:
        raise refuse(Spot(str(path)), "is not UTF-8 text", UTF8) from None
    except csv.Error as error:
        raise refuse(Spot(str(path)), f"is not CSV: {error}", "look for quotes that are not closed") from None
    except OSError as error:
        raise refuse(Spot(str(path)), f"cannot be read: {error.strerror}", "give a file you may read") from None


def table_rows(path: Path, layout: Layout) -> tuple[Header, Iterator[Row]]:
    """The header, and the rows below it; a blank line has no cells. Raises Refused."""
    rows = _sheet_rows(path, layout) if path.suffix.lower() in WORKBOOKS else _text_rows(path, layout)
    first = next(((line, row) for line, row in rows if any(row)), None)
    if first is None:
        raise refuse(Spot(str(path)), "is empty", EXPECTED)
    line, cells = first
    if not layout.header:
        return Header(tuple(str(k + 1) for k in range(_width(cells)))), chain([first], rows)
    if layout.marked:
        cells[0] = cells[0].lstrip(MARK).strip()
    labels = tuple(cells[: _width(cells)])
    second = next(rows, None)
    if second is None:
        return Header(labels, (), line), rows
    if _is_units(labels, second[1]):
        return Header(labels, tuple(map(_bare, second[1][: len(labels)])), line), rows
    return Header(labels, (), line), chain([second], rows)


def check_rows(path: Path, header: Header, rows: Iterator[Row]) -> tuple[Header, Iterator[Row]]:
    """The same; refused where the first row below the header is none of numbers and stamps. Such a file is no table,
    and nothing of what it holds is told: it may be anything that a mapping names."""
    first = next(((line, row) for line, row in rows if any(row)), None)
    if first is None:
        raise refuse(Spot(str(path)), "has a header and no values", "give at least two rows below the header")
    if not any(map(_may_be_reading, first[1])):
        raise refuse(Spot(str(path), first[0]), "is no row of numbers, so that this is no table", EXPECTED)
    return header, chain([first], rows)


def _may_be_reading(cell: str) -> bool:
    """A number, a word for a gap, or a stamp, which has more digits than letters."""
    return is_number(cell) or sum(map(str.isdigit, cell)) > sum(map(str.isalpha, cell))


def _sheet_rows(path: Path, layout: Layout) -> Iterator[Row]:
    for line, row in workbook_rows(path, layout.sheet):
        if not (layout.comment and row and row[0].startswith(layout.comment)):
            yield line, row if any(row) else []


def _width(cells: Sequence[str]) -> int:
    """Cells without the empty ones at the end, which a trailing separator makes."""
    return max((k + 1 for k, cell in enumerate(cells) if cell), default=0)


def _is_units(labels: Sequence[str], cells: Sequence[str]) -> bool:
    """Whether a row below the names holds their units: no number in it, and most of its words are units."""
    told = [_bare(cell) for cell in cells if cell]
    if not told or _width(cells) > len(labels) or len(cells) < len(labels) or any(map(_has_number, cells)):
        return False
    named = any("[" in label for label in labels)
    return not named and sum(map(_is_unit, told)) > len(told) / 2


def _has_number(cell: str) -> bool:
    return is_number(cell) or re.search(r"\d[\d:.,-]*\d", cell) is not None


def _bare(cell: str) -> str:
    """`[degC]`, `(degC)` or `degC`; a dash is a bare number."""
    text = cell.strip().strip("[]()").strip()
    return "1" if text in ("-", "--") else text


def _is_unit(text: str) -> bool:
    try:
        unit(text)
    except BadNumber:
        return False
    return True


class _Lines:
    """Lines of a text without comments; `number` is that of the last one given."""

    def __init__(self, handle: TextIO, layout: Layout) -> None:
        self.handle, self.layout, self.number = handle, layout, 0

    def __iter__(self) -> Iterator[str]:
        for line in self.handle:
            self.number += 1
            is_comment = self.layout.comment and line.startswith(self.layout.comment)
            if not is_comment and self.number > self.layout.before:
                yield line


def _text_rows(path: Path, layout: Layout) -> Iterator[Row]:
    with open_text(path, layout.encoding) as handle:
        lines = _Lines(handle, layout)
        for row in csv.reader(iter(lines), delimiter=layout.delimiter):
            if any("\n" in cell or "\r" in cell for cell in row):
                spot = Spot(str(path), lines.number - 1)
                raise refuse(spot, "has a line break inside of quotes", "keep a row in one line")
            yield lines.number, [cell.strip() for cell in row]
