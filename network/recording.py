"""Recordings: measured channels over time from a CSV, as it is or through a mapping; and written as one."""

from __future__ import annotations

import csv
import io
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Any, TextIO, TypeAlias

import numpy as np

from network import yamlfile
from network.declare import Array
from network.fields import word_of
from network.inputs import Schedule, Signal, Start, constant, held, is_slow, linear
from network.refusal import Complaints, Spot, likely, refuse
from network.scenario import check_keys, parse_start, quantity, read_keys, seconds, told
from network.units import BadNumber, Unit, unit
from network.yamlfile import Branch, Tree

LARGEST_FILE = 500_000_000
MOST_FAULTS = 20
_EXPECTED = "the first row is like `time [s],speed [rpm],T_housing [degC]`"
_UNITS = {"speed": "rpm", "feed": "m/min", "ambient": "degC"}
_MAPPING = {"recording": "name", "file": "recording.csv", "columns": '{theirs: "ours [unit]"}'}


@dataclass(frozen=True, eq=False)
class Column:
    """One channel. values: in SI (temperatures in °C), NaN for gaps; unit: what it is shown in."""

    name: str
    unit: str
    values: Array


@dataclass(frozen=True, eq=False)
class Recording:
    """Channels over time.

    file: as given by the user; t: [s], strictly increasing, the run starts at t[0]; constants: inputs that a mapping
    gives; fill, between: by name of an input, how its gaps are filled (linear, hold) and how it runs between samples
    (linear, held; default by its unit); source: the CSV, whose line k + 2 holds t[k].
    """

    name: str
    file: str
    t: Array
    columns: Mapping[str, Column]
    constants: Mapping[str, Signal] = field(default_factory=dict)
    start: Start | None = None
    fill: Mapping[str, str] = field(default_factory=dict)
    between: Mapping[str, str] = field(default_factory=dict)
    source: str = ""

    def __str__(self) -> str:
        hours = (self.t[-1] - self.t[0]) / 3600
        return f"{self.name}: {len(self.t)} samples in {hours:.3g} h of {', '.join([*self.columns, *self.constants])}"

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """From a CSV, or from a mapping (.yaml, .yml). Raises Refused with all faults, of many alike the first ones."""
        path = Path(path)
        return _load_mapping(path) if path.suffix.lower() in (".yaml", ".yml") else _load_csv(path)

    def measured(self, name: str) -> Column:
        """The column. Raises Refused where there is none of that name."""
        return self._column(name, Spot(self.file))

    def signal(self, name: str, spot: Spot | None = None) -> Signal:
        """A column or constant as an input; `spot` is who asks. Raises Refused: not there, or gaps and no way told."""
        if name in self.constants:
            return self.constants[name]
        column = self._column(name, spot or Spot(self.file))
        how = self.between.get(name) or ("linear" if is_slow(unit(column.unit)) else "held")
        return (linear if how == "linear" else held)(name, column.unit, self.t, self._without_gaps(column))

    def schedule(self, input_names: Iterable[str]) -> Schedule:
        """The inputs a machine needs, at the times of the recording. Raises Refused with every one that is missing."""
        complaints, signals, known = Complaints(), dict[str, Signal](), [*self.columns, *self.constants]
        for name in input_names:
            with told(complaints, Spot(self.file), name):
                if name not in known:
                    raise self._lacks(name, known)
                signals[name] = self.signal(name)
        complaints.raise_if_any()
        return Schedule(self.name, self.file, self.t, signals, self.start)

    def _lacks(self, name: str, known: Sequence[str]) -> Exception:
        near = likely(name, known)
        right = f"add a column `{name} [{_UNITS.get(name, 'unit')}]`, or `inputs: {{{name}: …}}` in a mapping"
        right += f" ({near})" if near.startswith("did") else ""
        return refuse(Spot(self.file), f"the machine needs the input `{name}`, which the recording lacks", right)

    def _column(self, name: str, spot: Spot) -> Column:
        if name not in self.columns:
            raise refuse(spot, f"the recording '{self.name}' has no column '{name}'", likely(name, self.columns))
        return self.columns[name]

    def _without_gaps(self, column: Column) -> Array:
        values, how = column.values, self.fill.get(column.name)
        known = np.flatnonzero(np.isfinite(values))
        if len(known) == len(values):
            return values
        if how and len(known):
            if how == "linear":
                return np.interp(self.t, self.t[known], values[known])
            latest = np.searchsorted(known, np.arange(len(values)), side="right") - 1
            return values[known[np.clip(latest, 0, None)]]
        first = int(np.argmax(~np.isfinite(values)))
        spot = Spot(self.source, first + 2) if self.source else Spot(self.file)
        count = f"{len(values) - len(known)} of {len(values)} times, first at {self.t[first]:.10g} s"
        wrong = f"the input '{column.name}' has no value at {count}"
        right = f"fill them in, or read it through a mapping with `fill: {{{column.name}: linear}}` (or hold)"
        raise refuse(spot, wrong, right if len(known) else "give it values, it has none")


@dataclass(frozen=True)
class _Heading:
    """A column that is read: its name and unit with us, its label in the file and where it stands there."""

    name: str
    unit: Unit
    label: str
    index: int = -1


_Choose: TypeAlias = Callable[[list[str], Complaints], list[_Heading]]


def _heading(text: str) -> _Heading:
    """`name [unit]`. Raises BadNumber."""
    match = re.fullmatch(r"\s*(.*?)\s*\[\s*([^\[\]]*?)\s*\]\s*", text)
    if not match or not match[2]:
        name = re.sub(r"\s*[\[(].*", "", text).strip() or "name"
        raise BadNumber("has no unit", f"write `{name} [unit]`, as in `{name} [{_UNITS.get(name, 'degC')}]`")
    if not match[1]:
        raise BadNumber("has no name", "write `name [unit]`")
    given = unit(match[2])
    if match[1] == "time" and given.dimension != "[time]":
        raise BadNumber(f"time is in {given.text}", "give it in s, min or h")
    return _Heading(match[1], given, text.strip())


def _refuse_twice(names: Sequence[str], spot: Spot, complaints: Complaints) -> None:
    for name in sorted({name for name in names if names.count(name) > 1}):
        complaints.refuse(spot, f"the column '{name}' is there {names.count(name)} times", "keep or map one of them")


# -- a CSV as it is -------------------------------------------------------------------------------------------------
def _load_csv(path: Path) -> Recording:
    complaints, spot = Complaints(), Spot(str(path), 1)

    def choose(header: list[str], complaints: Complaints) -> list[_Heading]:
        headings = []
        for index, text in enumerate(header):
            with told(complaints, spot, f"column '{text}'" if text else f"column {index + 1}"):
                headings.append(replace(_heading(text), index=index))
        _refuse_twice([heading.name for heading in headings], spot, complaints)
        if not any(text.partition("[")[0].strip() == "time" for text in header):
            near = likely("time", header)
            right = "name one `time [s]`, `time [min]` or `time [h]`" + (f" ({near})" if near.startswith("did") else "")
            complaints.refuse(spot, "has no time column", right)
        return headings

    headings, cells = _table(path, choose, complaints)
    t, columns = _channels(headings, cells, str(path), None, complaints)
    complaints.raise_if_any()
    return Recording(path.stem, str(path), t, columns, source=str(path))


# -- a mapping ------------------------------------------------------------------------------------------------------
def _load_mapping(path: Path) -> Recording:
    tree, complaints = yamlfile.load(path, "a mapping of a recording"), Complaints()
    check_keys(tree, "the mapping", _MAPPING, ("interval", "inputs", "start", "fill", "between"), complaints)
    readers: dict[str, Callable[[Tree], Any]] = {
        "recording": lambda child: word_of(child, "a name"),
        "file": lambda child: _existing(path.parent / word_of(child, "the path of a CSV")),
        "columns": lambda child: _each(child, "columns", lambda theirs: _heading(word_of(theirs, "`name [unit]`"))),
        "interval": seconds,
        "inputs": lambda child: _each(child, "inputs", quantity),
        "start": parse_start,
        "fill": lambda child: _each(child, "fill", lambda how: _one_of(how, "linear", "hold")),
        "between": lambda child: _each(child, "between", lambda how: _one_of(how, "linear", "held")),
    }
    values: dict[str, Any] = {"interval": None, "start": None, "inputs": {}, "fill": {}, "between": {}}
    read_keys(tree, readers, values, complaints)
    if "columns" in values:
        _check_mapping(tree, values, complaints)
    t, columns = np.empty(0), dict[str, Column]()
    if {"file", "columns"} <= values.keys():
        with told(complaints, tree.key_spot("file"), "file"):
            headings, cells = _table(values["file"], _chooser(tree, values["columns"]), complaints)
            t, columns = _channels(headings, cells, str(values["file"]), values["interval"], complaints)
    complaints.raise_if_any()
    constants = {name: constant(name, given.text, value) for name, (value, given) in values["inputs"].items()}
    how = {key: values[key] for key in ("start", "fill", "between")}
    return Recording(values["recording"], str(path), t, columns, constants, source=str(values["file"]), **how)


def _existing(path: Path) -> Path:
    if not path.exists():
        raise BadNumber(f"there is no file '{path}'", "give its path relative to the mapping")
    return path


def _one_of(tree: Tree, *words: str) -> str:
    text = word_of(tree, " or ".join(words))
    if text not in words:
        raise BadNumber(f"is '{text}'", "write " + " or ".join(words))
    return text


def _each(tree: Tree, where: str, read: Callable[[Tree], Any]) -> dict[str, Any]:
    """The values of a mapping by key. Raises BadNumber, or Refused with every fault."""
    if not isinstance(tree, Branch) or (where == "columns" and not tree.items):
        raise BadNumber("is not a mapping of names", f"write `{where}: {{name: …}}`")
    complaints, values = Complaints(), {}
    for key, child in tree.items.items():
        with told(complaints, tree.key_spot(key), f"{where}.{key}"):
            values[key] = read(child)
    complaints.raise_if_any()
    return values


def _check_mapping(tree: Branch, values: Mapping[str, Any], complaints: Complaints) -> None:
    """What must agree between the keys of a mapping."""
    names, spot = [heading.name for heading in values["columns"].values()], tree.key_spot("columns")
    _refuse_twice(names, spot, complaints)
    if "time" in names and "interval" in tree.items:
        complaints.refuse(tree.key_spot("interval"), "interval is given beside a time column", "keep one of them")
    if "time" not in names and "interval" not in tree.items:
        complaints.refuse(spot, "no column is mapped to time", 'map one to "time [s]", or give `interval: 10 s`')
    for name in [name for name in values["inputs"] if name in names]:
        complaints.refuse(tree.key_spot("inputs"), f"the input '{name}' is a column as well", "keep one of them")
    for key in ("fill", "between"):
        for name in [name for name in values[key] if name not in names]:
            complaints.refuse(tree.key_spot(key), f"{key} names '{name}', which is no column", likely(name, names))


def _chooser(tree: Branch, columns: Mapping[str, _Heading]) -> _Choose:
    branch, file = tree.items["columns"], tree.items["file"]

    def choose(header: list[str], complaints: Complaints) -> list[_Heading]:
        for theirs in columns:
            spot = branch.key_spot(theirs) if isinstance(branch, Branch) else branch.spot
            if theirs not in header:
                wrong = f"the file {yamlfile.plain(file)} has no column '{theirs}'"
                complaints.refuse(spot, wrong, likely(theirs, header))
            _refuse_twice([text for text in header if text == theirs], spot, complaints)
        found = {theirs: heading for theirs, heading in columns.items() if theirs in header}
        return [replace(heading, label=theirs, index=header.index(theirs)) for theirs, heading in found.items()]

    return choose


# -- rows -----------------------------------------------------------------------------------------------------------
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
        raise refuse(spot, wrong, "give the path of a recording")
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


def _table(path: Path, choose: _Choose, complaints: Complaints) -> tuple[list[_Heading], Array]:
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


def _read_clean(path: Path, width: int, headings: Sequence[_Heading]) -> Array:
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


def _walk(path: Path, width: int, headings: Sequence[_Heading], complaints: Complaints) -> Array:
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
    row: Sequence[str], width: int, headings: Sequence[_Heading], spot: Spot, complaints: Complaints
) -> list[float]:
    if len(row) == width:
        return [_cell(row[heading.index].strip(), heading, spot, complaints) for heading in headings]
    right = "separate columns by one comma, and write decimals with a point"
    right = right if len(row) > width else "keep the comma of an empty field"
    complaints.refuse(spot, f"has {len(row)} fields, the header has {width}", right)
    return [math.nan] * len(headings)


def _cell(text: str, heading: _Heading, spot: Spot, complaints: Complaints) -> float:
    try:
        if "_" in text or not text.isascii():  # Python would read 1_0 as ten
            raise ValueError
        return float(text or "nan")
    except ValueError:
        is_comma = re.fullmatch(r"[+-]?\d+,\d+", text)
        right = f"write {text.replace(',', '.')}" if is_comma else "write a number, or leave the field empty for a gap"
        complaints.refuse(spot, f"column '{heading.label}' has the text '{text[:40]}'", right)
        return math.nan


def _channels(
    headings: Sequence[_Heading], cells: Array, file: str, interval: float | None, complaints: Complaints
) -> tuple[Array, dict[str, Column]]:
    """Times [s] and the other columns in SI."""
    t = np.arange(len(cells), dtype=np.float64) * (interval or 1.0)
    columns = {}
    for k, heading in enumerate(headings):
        values = cells[:, k] * heading.unit.scale + heading.unit.offset
        if heading.name == "time":
            _check_times(cells[:, k], heading.unit.text, file, complaints)
            t = values
        else:
            columns[heading.name] = Column(heading.name, heading.unit.text, values)
    return t, columns


def _check_times(raw: Array, unit_text: str, file: str, complaints: Complaints) -> None:
    told_of = {refusal.spot.line for refusal in complaints.refusals if refusal.spot.file == file}
    for row in np.flatnonzero(np.isnan(raw))[:MOST_FAULTS]:
        if row + 2 not in told_of:
            complaints.refuse(Spot(file, int(row) + 2), "has no time", "give every row a time")
    known = np.flatnonzero(np.isfinite(raw))
    for k in np.flatnonzero(np.diff(raw[known]) <= 0)[:MOST_FAULTS]:
        before, now = (f"{raw[row]:.12g} {unit_text}" for row in known[k : k + 2])
        wrong = f"the time {now} stands twice" if before == now else f"the time goes back from {before} to {now}"
        complaints.refuse(Spot(file, int(known[k + 1]) + 2), wrong, "give rows in the order of time, each time once")


# -- writing --------------------------------------------------------------------------------------------------------
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
    _replace_file(Path(path), head.getvalue() + "".join([form % row for row in zip(times, *shown, strict=True)]))


def _replace_file(path: Path, text: str) -> None:
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        beside.write_text(text, encoding="utf-8", newline="\n")
        os.replace(beside, path)
    except OSError as error:
        wrong = f"cannot be written: {error.strerror}"
        raise refuse(Spot(str(path)), wrong, "give a folder that exists and that you may write to") from None
    finally:
        beside.unlink(missing_ok=True)
