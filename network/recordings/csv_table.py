"""CSV with units in the header: read fast, every fault told by its line; and written whole or not at all."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.platform.files import replace_file
from network.platform.quantities.unit_values import in_own_unit
from network.platform.quantities.units import BadNumber, Unit, unit
from network.platform.refusal import Complaints, Spot
from network.recordings.alike import Alike
from network.recordings.numbers import read_numbers
from network.recordings.plain_numbers import read_plain_numbers
from network.recordings.stamps import find_form, read_stamps
from network.recordings.table_rows import Header, Row, check_rows, table_rows
from network.recordings.text_layout import Layout, find_layout

_TIMES = "write `time [s]`, `time [min]` or `time [h]`; without a unit it is stamps like 2020-06-15T08:30 or 08:30:00"
_USUAL_UNITS = {"speed": "rpm", "feed": "m/min", "ambient": "degC", "time": "s"}


@dataclass(frozen=True)
class Heading:
    """A column that is read: its name and unit with us, its label in the file and where it stands there; stamp: the
    form of time stamps, '' for numbers."""

    name: str
    unit: Unit
    label: str
    index: int = -1
    stamp: str = ""


@dataclass(frozen=True, eq=False)
class Table:
    """cells: rows × columns, in the units of the file; lines: where each row stands in it."""

    file: str
    headings: tuple[Heading, ...]
    cells: Array
    lines: Indices


ROWS = 1000
"""Rows of a table that are written at a time: as text a number takes ten times its room."""
Choose: TypeAlias = Callable[[Header, Complaints], list[Heading]]


def read_heading(text: str) -> Heading:
    """`name [unit]`. Raises BadNumber."""
    name, unit_text = _split_heading(text.strip())
    if not unit_text:
        name = re.split(r"[\[(]", text, maxsplit=1)[0].strip() or "name"
        raise BadNumber("has no unit", f"write `{name} [unit]`, as in `{name} [{usual_unit(name) or 'degC'}]`")
    if not name:
        raise BadNumber("has no name", "write `name [unit]`")
    given = unit(unit_text)
    if name == "time" and given.dimension != "[time]":
        raise BadNumber(f"time is in {given.text}", "give it in s, min or h")
    return Heading(name, given, text.strip())


def usual_unit(name: str) -> str:
    """The unit in which such a channel is mostly told; empty where its name does not say."""
    return next((given for word, given in _USUAL_UNITS.items() if word in name.lower()), "")


def _split_heading(text: str) -> tuple[str, str]:
    """Name and what stands in the brackets at the end, without spaces around; '' for what is not there."""
    name, bracket, rest = text.rpartition("[")
    inside = rest[:-1].strip() if bracket and rest.endswith("]") else ""
    return (name.strip(), inside) if "]" not in inside else (text, "")


def refuse_twice(names: Sequence[str], spot: Spot, complaints: Complaints) -> None:
    for name, count in sorted(Counter(names).items()):
        if count > 1:
            complaints.refuse(spot, f"the column '{name}' is there {count} times", "keep or map one of them")


def table(path: Path, choose: Choose, complaints: Complaints, layout: Layout | None = None) -> Table:
    """The chosen columns, in the units of the file. Raises Refused for what is no table."""
    layout = find_layout(path, layout or Layout())
    header, rows = check_rows(path, *table_rows(path, layout))
    headings = choose(header, complaints)
    if not headings:
        return Table(str(path), (), np.empty((0, 0)), np.empty(0, int))
    faults = Alike(str(path))
    quick = _read_clean(path, len(header.labels), headings) if layout.is_plain and header.line == 1 else None
    cells, lines = quick or _read_texts(rows, header, headings, layout, faults)
    faults.tell(complaints)
    if len(cells) < 2 and not complaints.refusals:
        wrong = "has only one row of values" if len(cells) else "has a header and no values"
        complaints.refuse(Spot(str(path)), wrong, "give at least two rows below the header")
    return Table(str(path), tuple(headings), cells, lines)


def _read_clean(path: Path, width: int, headings: Sequence[Heading]) -> tuple[Array, Indices] | None:
    """The fast way; None for anything but plain numbers and gaps."""
    if any(heading.stamp for heading in headings):
        return None
    cells = read_plain_numbers(path, width, [heading.index for heading in headings])
    return (cells, np.arange(len(cells)) + 2) if cells is not None and not np.isinf(cells).any() else None


def _read_texts(
    rows: Iterable[Row], header: Header, headings: Sequence[Heading], layout: Layout, faults: Alike
) -> tuple[Array, Indices]:
    """The slow way, which reads what is not plain and names every fault with its line."""
    has_times = any(heading.name == "time" for heading in headings)
    texts, lines = _split_columns(rows, len(header.labels), headings, has_times, faults)
    commas = layout.decimal == "," if layout.decimal or layout.delimiter == "," else None
    columns = []
    for heading, cells in zip(headings, texts, strict=True):
        form = find_form(cells, heading.stamp) if heading.stamp else ""
        if form:
            columns.append(read_stamps(cells, lines, heading.label, form, faults))
            continue
        if heading.stamp:
            faults.add("unit", header.line, f"column '{heading.label}' has no unit, and no time stamps", _TIMES)
        columns.append(read_numbers(cells, lines, heading.label, commas, faults))
    return np.array(columns, float).T.reshape(-1, len(headings)), np.array(lines, int)


def _split_columns(
    rows: Iterable[Row], width: int, headings: Sequence[Heading], has_times: bool, faults: Alike
) -> tuple[list[list[str]], list[int]]:
    """The cells of every column that is read. Blank lines are passed over where rows have a time of their own."""
    texts: list[list[str]] = [[] for _ in headings]
    lines, empty = list[int](), list[Row]()
    for line, row in rows:
        empty.append((line, row))
        if not any(row):
            continue
        for number, given in empty[-1:] if has_times or not lines else empty:
            cells = _check_width(given, width, number, faults)
            if cells:
                lines.append(number)
                for text, heading in zip(texts, headings, strict=True):
                    text.append(cells[heading.index])
        empty.clear()
    return texts, lines


def _check_width(row: list[str], width: int, line: int, faults: Alike) -> list[str]:
    """The cells of a row as wide as the header; none where it is faulty."""
    cells = row[:width] if not any(row[width:]) else row
    if len(cells) == width:
        return cells
    if not any(row):
        right = "take it out, or write nan for a gap, for rows without a time count by their place"
        faults.add("blank", line, "is an empty line", right)
        return []
    right = "separate columns by one comma, and write decimals with a point"
    right = right if len(cells) > width else "keep the comma of an empty field"
    faults.add(("width", len(cells)), line, f"has {len(cells)} fields, the header has {width}", right)
    return []


def write_csv(path: str | Path, t: Array, columns: Mapping[str, tuple[str, Array]]) -> None:
    """Writes a recording: t [s] exactly, each column (unit, values in SI) with 7 digits in its unit, NaN as `nan`.

    The file is replaced as a whole. Raises Refused where it cannot be written, BadNumber for an unknown unit.
    """
    units = [unit(text) for text, _ in columns.values()]
    head = io.StringIO()
    labels = (f"{name} [{given.text}]" for name, given in zip(columns, units, strict=True))
    csv.writer(head, lineterminator="\n").writerow(["time [s]", *labels])

    def write(beside: Path) -> None:
        with beside.open("w", encoding="utf-8", newline="\n") as file:
            file.write(head.getvalue())
            for first in range(0, len(t), ROWS):
                some = slice(first, first + ROWS)
                several = zip([values for _, values in columns.values()], units, strict=True)
                shown = [in_own_unit(values[some], given).tolist() for values, given in several]
                file.writelines(_lines(t[some], shown))

    replace_file(Path(path), write)


def _lines(t: Array, shown: Sequence[Sequence[float]]) -> Iterator[str]:
    form = "%s" + ",%.7g" * len(shown) + "\n"
    times = (repr(time).removesuffix(".0") for time in t.tolist())
    return (form % row for row in zip(times, *shown, strict=True))
