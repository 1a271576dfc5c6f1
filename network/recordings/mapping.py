"""Foreign recordings: a mapping says which of their columns are which of ours, in what unit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array
from network.catalogue.declaration.fields import word_of
from network.platform.quantities.units import BadNumber
from network.platform.refusal import Complaints, likely, refuse
from network.platform.yaml import document
from network.platform.yaml.document import Branch, Tree
from network.recordings.columns import Column, channels
from network.recordings.csv_table import Choose, Heading, read_heading, refuse_twice, table
from network.recordings.inputs import Signal, Start, constant
from network.recordings.yaml_values import (
    check_keys,
    collecting,
    parse_start,
    read_keys,
    run_constant,
    seconds,
    shift,
)

_MAPPING = {"recording": "name", "file": "recording.csv", "columns": '{theirs: "ours [unit]"}'}


@dataclass(frozen=True, eq=False)
class Mapped:
    """What a recording is made of, as a mapping has it."""

    name: str
    file: str
    t: Array
    columns: Mapping[str, Column]
    constants: Mapping[str, Signal]
    start: Start | None
    fill: Mapping[str, str]
    between: Mapping[str, str]
    source: str
    offsets: bool = True


def load_mapping(path: Path) -> Mapped:
    """From a mapping file. Raises Refused with all faults."""
    tree, complaints = document.load(path, "a mapping of a recording"), Complaints()
    others = ("interval", "inputs", "offsets", "start", "fill", "between", "from", "until", "zero")
    check_keys(tree, "the mapping", _MAPPING, others, complaints)
    readers: dict[str, Callable[[Tree], Any]] = {
        "recording": lambda child: word_of(child, "a name"),
        "file": lambda child: _existing(path.parent / word_of(child, "the path of a CSV")),
        "columns": lambda child: _each(child, "columns", lambda theirs: read_heading(word_of(theirs, "`name [unit]`"))),
        "interval": seconds,
        "inputs": lambda child: _each(child, "inputs", run_constant),
        "offsets": lambda child: _one_of(child, "free", "none"),
        "start": parse_start,
        "fill": lambda child: _each(child, "fill", lambda how: _one_of(how, "linear", "hold")),
        "between": lambda child: _each(child, "between", lambda how: _one_of(how, "linear", "held")),
        "from": shift,
        "until": shift,
        "zero": lambda child: _each(child, "zero", lambda how: _one_of(how, "start")),
    }
    values: dict[str, Any] = {"interval": None, "start": None, "offsets": "free"}
    values |= {key: {} for key in ("inputs", "fill", "between", "zero")}
    read_keys(tree, readers, values, complaints)
    if "columns" in values:
        _check_mapping(tree, values, complaints)
    t, columns = np.empty(0), dict[str, Column]()
    if {"file", "columns"} <= values.keys():
        with collecting(complaints, tree.key_spot("file"), "file"):
            headings, cells = table(values["file"], _chooser(tree, values["columns"]), complaints)
            t, columns = channels(headings, cells, str(values["file"]), values["interval"], complaints)
    complaints.raise_if_any()
    part = _part(t, values, tree)
    columns = {name: _cut(column, part, name in values["zero"]) for name, column in columns.items()}
    source = str(values["file"]) if part.start == 0 else ""
    constants = {name: constant(name, given.text, value, std) for name, (value, given, std) in values["inputs"].items()}
    how = {key: values[key] for key in ("start", "fill", "between")} | {"offsets": values["offsets"] == "free"}
    return Mapped(values["recording"], str(path), t[part], columns, constants, source=source, **how)


def _part(t: Array, values: Mapping[str, Any], tree: Branch) -> slice:
    """The samples from `from` on and before `until`. Raises Refused where fewer than two are left."""
    first = int(np.searchsorted(t, values.get("from", -np.inf)))
    last = int(np.searchsorted(t, values.get("until", np.inf)))
    if len(t) > 1 and last - first < 2:
        key = "from" if "from" in values else "until"
        wrong = f"`from` and `until` leave {max(last - first, 0)} of {len(t)} samples"
        right = f"the recording goes from {t[0]:.10g} s to {t[-1]:.10g} s, keep at least two samples"
        raise refuse(tree.key_spot(key), wrong, right)
    return slice(first, last)


def _cut(column: Column, part: slice, zeroed: bool) -> Column:
    """A part of it; zeroed: less its first value there."""
    values = column.values[part]
    known = values[np.isfinite(values)]
    return replace(column, values=values - known[0] if zeroed and len(known) else values)


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
        with collecting(complaints, tree.key_spot(key), f"{where}.{key}"):
            values[key] = read(child)
    complaints.raise_if_any()
    return values


def _check_mapping(tree: Branch, values: Mapping[str, Any], complaints: Complaints) -> None:
    """What must agree between the keys of a mapping."""
    names, spot = [heading.name for heading in values["columns"].values()], tree.key_spot("columns")
    refuse_twice(names, spot, complaints)
    if "time" in names and "interval" in tree.items:
        complaints.refuse(tree.key_spot("interval"), "interval is given beside a time column", "keep one of them")
    if "time" not in names and "interval" not in tree.items:
        complaints.refuse(spot, "no column is mapped to time", 'map one to "time [s]", or give `interval: 10 s`')
    for name in [name for name in values["inputs"] if name in names]:
        complaints.refuse(tree.key_spot("inputs"), f"the input '{name}' is a column as well", "keep one of them")
    for key in ("fill", "between", "zero"):
        for name in [name for name in values[key] if name not in names]:
            complaints.refuse(tree.key_spot(key), f"{key} names '{name}', which is no column", likely(name, names))


def _chooser(tree: Branch, columns: Mapping[str, Heading]) -> Choose:
    branch, file = tree.items["columns"], tree.items["file"]

    def choose(header: list[str], complaints: Complaints) -> list[Heading]:
        for theirs in columns:
            spot = branch.key_spot(theirs) if isinstance(branch, Branch) else branch.spot
            if theirs not in header:
                wrong = f"the file {document.plain(file)} has no column '{theirs}'"
                complaints.refuse(spot, wrong, likely(theirs, header))
            refuse_twice([text for text in header if text == theirs], spot, complaints)
        found = {theirs: heading for theirs, heading in columns.items() if theirs in header}
        return [replace(heading, label=theirs, index=header.index(theirs)) for theirs, heading in found.items()]

    return choose
