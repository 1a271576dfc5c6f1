"""CSV with units in the header: read fast, every fault told by its line; and written whole or not at all."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TextIO, TypeAlias

import numpy as np

from network.catalogue.declaration.declare import Array
from network.platform.files import replace_file
from network.platform.package_data import hint
from network.platform.quantities.units import BadNumber, Unit, unit
from network.platform.refusal import Complaints, Spot, refuse

LARGEST_FILE = 500_000_000
MOST_FAULTS = 20
_EXPECTED = "the first row is like `time [s],speed [rpm],T_housing [degC]`"
USUAL_UNITS = {"speed": "rpm", "feed": "m/min", "ambient": "degC"}


@dataclass(frozen=True)
class Heading:
    """A column that is read: its name and unit with us, its label in the file and where it stands there."""

    name: str
    unit: Unit
    label: str
    index: int = -1


Choose: TypeAlias = Callable[[list[str], Complaints], list[Heading]]


def read_heading(text: str) -> Heading:
    """`name [unit]`. Raises BadNumber."""
    match = re.fullmatch(r"\s*(.*?)\s*\[\s*([^\[\]]*?)\s*\]\s*", text)
    if not match or not match[2]:
        name = re.sub(r"\s*[\[(].*", "", text).strip() or "name"
        raise BadNumber("has no unit", f"write `{name} [unit]`, as in `{name} [{USUAL_UNITS.get(name, 'degC')}]`")
    if not match[1]:
        raise BadNumber("has no name", "write `name [unit]`")
    given = unit(match[2])
    if match[1] == "time" and given.dimension != "[time]":
        raise BadNumber(f"time is in {given.text}", "give it in s, min or h")
    return Heading(match[1], given, text.strip())


def refuse_twice(names: Sequence[str], spot: Spot, complaints: Complaints) -> None:
    for name in sorted({name for name in names if names.count(name) > 1}):
        complaints.refuse(spot, f"the column '{name}' is there {names.count(name)} times", "keep or map one of them")


@contextmanager
def _text(path: Path) -> Iterator[TextIO]:
    """The file as text; what is no readable UTF-8 CSV is refused with its line."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as handle:
            yield handle
    except UnicodeDecodeError:
        raise refuse(Spot(str(path), _undecodable(path)), "is not UTF-8 text", "save it as CSV in UTF-8") from None
    except csv.Error as error:
        raise refuse(Spot(str(path)), f"is not CSV: {error}", "look for quotes that are not closed") from None
    except OSError as error:
        raise refuse(Spot(str(path)), f"cannot be read: {error.strerror}", "give a file you may read") from None


def _undecodable(path: Path) -> int:
    with path.open("rb") as handle:
        for line, content in enumerate(handle, 1):
            try:
                content.decode("utf-8")
            except UnicodeDecodeError:
                return line
    return 0


def _header(path: Path) -> list[str]:
    spot = Spot(str(path))
    if not path.is_file():
        wrong = "is not a file" if path.exists() else "there is no such file"
        raise refuse(spot, wrong, f"give the path of a recording{hint(path)}")
    if path.stat().st_size > LARGEST_FILE:
        wrong = f"has {path.stat().st_size / 1e6:.0f} MB, more than {LARGEST_FILE / 1e6:.0f} MB"
        raise refuse(spot, wrong, "split it, or take fewer samples")
    with _text(path) as handle:
        header = [text.strip() for text in next(csv.reader(handle), [])]
        if not any(header):
            raise refuse(spot, "is empty" if not handle.read(1000).strip() else "begins with an empty line", _EXPECTED)
    seen = next((name for mark, name in ((";", "';'"), ("\t", "tabs")) if mark in header[0]), "")
    if len(header) == 1 and seen:
        wrong = f"has its columns separated by {seen}"
        raise refuse(Spot(str(path), 1), wrong, "use commas between columns, and points in decimals")
    if "\0" in header[0]:
        raise refuse(Spot(str(path), 1), "is not UTF-8 text", "save it as CSV in UTF-8")
    return header


def table(path: Path, choose: Choose, complaints: Complaints) -> tuple[list[Heading], Array]:
    """The chosen columns, in the units of the file: rows × columns, row k from line k + 2."""
    header = _header(path)
    headings = choose(header, complaints)
    if not headings:
        return [], np.empty((0, 0))
    try:
        cells = _read_clean(path, len(header), headings)
    except ValueError:
        cells = _walk(path, len(header), headings, complaints)
    if len(cells) < 2 and not complaints.refusals:
        wrong = "has only one row of values" if len(cells) else "has a header and no values"
        complaints.refuse(Spot(str(path)), wrong, "give at least two rows below the header")
    for row, k in np.argwhere(np.isinf(cells))[:MOST_FAULTS]:
        wrong = f"column '{headings[k].label}' is infinite"
        complaints.refuse(Spot(str(path), int(row) + 2), wrong, "give a finite number, or an empty field for a gap")
    return headings, cells


def _read_clean(path: Path, width: int, headings: Sequence[Heading]) -> Array:
    """The fast way. Raises ValueError for anything but plain numbers and gaps; `_walk` then says what it is."""
    with _text(path) as handle:
        next(handle)
        rows = _plain_rows(handle, width - 1)
        first = next(rows, None)
        if first is None:
            raise ValueError
        use = [heading.index for heading in headings]
        return np.loadtxt(chain([first], rows), delimiter=",", comments=None, usecols=use, ndmin=2, dtype=np.float64)


def _plain_rows(lines: Iterable[str], commas: int) -> Iterator[str]:
    for line in lines:
        if line.count(",") != commas or '"' in line or line.isspace():
            raise ValueError
        if ",," in line or line[0] == "," or line.rstrip("\r\n")[-1] == ",":
            line = ",".join(text.strip() or "nan" for text in line.split(","))
        yield line


def _walk(path: Path, width: int, headings: Sequence[Heading], complaints: Complaints) -> Array:
    """The slow way, which names every fault with its line, up to a number that can be read."""
    rows: list[list[float]] = []
    blank: list[int] = []
    with _text(path) as handle:
        reader = csv.reader(handle)
        next(reader)
        for line, row in enumerate(reader, 2):
            spot = Spot(str(path), line)
            if reader.line_num != line:
                raise refuse(spot, "has a line break inside of quotes", "keep a row in one line")
            blank += [line] if not row else []
            rows.append(_row(row, width, headings, spot, complaints) if row else [math.nan] * len(headings))
            if len(complaints.refusals) >= MOST_FAULTS:
                spot = Spot(str(path), line + 1)
                complaints.refuse(spot, "is not looked at, nor what follows", "correct what is above first")
                break
    while blank and blank[-1] == len(rows) + 1:
        blank.pop()
        rows.pop()
    for line in blank[:MOST_FAULTS]:
        complaints.refuse(Spot(str(path), line), "is an empty line", "take it out, or write nan for a gap")
    return np.array(rows, float).reshape(-1, len(headings))


def _row(
    row: Sequence[str], width: int, headings: Sequence[Heading], spot: Spot, complaints: Complaints
) -> list[float]:
    if len(row) == width:
        return [_cell(row[heading.index].strip(), heading, spot, complaints) for heading in headings]
    right = "separate columns by one comma, and write decimals with a point"
    right = right if len(row) > width else "keep the comma of an empty field"
    complaints.refuse(spot, f"has {len(row)} fields, the header has {width}", right)
    return [math.nan] * len(headings)


def _cell(text: str, heading: Heading, spot: Spot, complaints: Complaints) -> float:
    try:
        if "_" in text or not text.isascii():  # Python would read 1_0 as ten
            raise ValueError
        return float(text or "nan")
    except ValueError:
        is_comma = re.fullmatch(r"[+-]?\d+,\d+", text)
        right = f"write {text.replace(',', '.')}" if is_comma else "write a number, or leave the field empty for a gap"
        complaints.refuse(spot, f"column '{heading.label}' has the text '{text[:40]}'", right)
        return math.nan


def check_times(raw: Array, unit_text: str, file: str, complaints: Complaints) -> None:
    told_of = {refusal.spot.line for refusal in complaints.refusals if refusal.spot.file == file}
    for row in np.flatnonzero(np.isnan(raw))[:MOST_FAULTS]:
        if row + 2 not in told_of:
            complaints.refuse(Spot(file, int(row) + 2), "has no time", "give every row a time")
    known = np.flatnonzero(np.isfinite(raw))
    for k in np.flatnonzero(np.diff(raw[known]) <= 0)[:MOST_FAULTS]:
        before, now = (f"{raw[row]:.12g} {unit_text}" for row in known[k : k + 2])
        wrong = f"the time {now} stands twice" if before == now else f"the time goes back from {before} to {now}"
        complaints.refuse(Spot(file, int(known[k + 1]) + 2), wrong, "give rows in the order of time, each time once")


def write_csv(path: str | Path, t: Array, columns: Mapping[str, tuple[str, Array]]) -> None:
    """Writes a recording: t [s] exactly, each column (unit, values in SI) with 7 digits in its unit, NaN as `nan`.

    The file is replaced as a whole. Raises Refused where it cannot be written, BadNumber for an unknown unit.
    """
    units = {name: unit(text) for name, (text, _) in columns.items()}
    shown = [((values - units[name].offset) / units[name].scale).tolist() for name, (_, values) in columns.items()]
    head = io.StringIO()
    csv.writer(head, lineterminator="\n").writerow(["time [s]", *(f"{name} [{units[name].text}]" for name in columns)])
    form = "%s" + ",%.7g" * len(columns) + "\n"
    times = (repr(time).removesuffix(".0") for time in t.tolist())
    text = head.getvalue() + "".join([form % row for row in zip(times, *shown, strict=True)])
    replace_file(Path(path), lambda beside: beside.write_text(text, encoding="utf-8", newline="\n"))
