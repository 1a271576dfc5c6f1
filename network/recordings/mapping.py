"""Foreign recordings: a mapping says which of their columns are which of ours, in what unit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from network.catalogue.declaration.declare import Array, Indices
from network.catalogue.declaration.fields import word_of
from network.platform.quantities.units import BadNumber, unit
from network.platform.refusal import Complaints, likely, refuse
from network.platform.yaml import document
from network.platform.yaml.document import Branch, Tree
from network.recordings.columns import Column, Samples, channels
from network.recordings.csv_table import Choose, Heading, Table, read_heading, refuse_twice, table
from network.recordings.file_keys import KEYS, Clock, file_readers, layout_of
from network.recordings.inputs import Signal, Start, constant
from network.recordings.pieces import Cut, find_cuts, piece_column
from network.recordings.table_rows import Header
from network.recordings.yaml_values import check_keys, collecting, parse_start, read_keys, run_constant, shift

_MAPPING = {"recording": "name", "columns": '{theirs: "ours [unit]"}'}


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
    lines: Indices
    cuts: tuple[Cut, ...]
    zeroed: tuple[str, ...]
    offsets: bool
    starts: bool


def load_mapping(path: Path) -> Mapped:
    """From a mapping file. Raises Refused with all faults."""
    tree, complaints = document.load(path, "a mapping of a recording"), Complaints()
    others = (*KEYS, "inputs", "offsets", "start", "starts", "fill", "between", "from", "until", "zero")
    check_keys(tree, "the mapping", _MAPPING, others, complaints)
    readers: dict[str, Callable[[Tree], Any]] = {
        "recording": lambda child: word_of(child, "a name"),
        **file_readers(path.parent),
        "columns": lambda child: _each(child, "columns", lambda theirs: read_heading(word_of(theirs, "`name [unit]`"))),
        "inputs": lambda child: _each(child, "inputs", run_constant),
        "offsets": lambda child: _one_of(child, "free", "none"),
        "start": parse_start,
        "starts": lambda child: _one_of(child, "free", "read"),
        "fill": lambda child: _each(child, "fill", lambda how: _one_of(how, "linear", "hold")),
        "between": lambda child: _each(child, "between", lambda how: _one_of(how, "linear", "held")),
        "from": shift,
        "until": shift,
        "zero": lambda child: _each(child, "zero", lambda how: _one_of(how, "start")),
    }
    values: dict[str, Any] = {key: {} for key in ("inputs", "fill", "between", "zero")}
    values |= {"start": None, "offsets": "free", "starts": "free"}
    read_keys(tree, readers, values, complaints)
    _check_files(tree, complaints)
    if "columns" in values:
        _check_mapping(tree, values, complaints)
    samples, cuts = _read_files(tree, values, complaints)
    complaints.raise_if_any()
    assert samples is not None
    columns = {name: piece_column(c, slice(None), name in values["zero"]) for name, c in samples.columns.items()}
    source = samples.files[0] if len(samples.files) == 1 else ""
    constants = {name: constant(name, given.text, value, std) for name, (value, given, std) in values["inputs"].items()}
    how = {key: values[key] for key in ("start", "fill", "between")}
    how |= {key: values[key] == "free" for key in ("offsets", "starts")}
    return Mapped(
        values["recording"], str(path), samples.t, columns, constants, source=source, lines=samples.lines, cuts=cuts,
        zeroed=tuple(values["zero"]), **how,
    )  # fmt: skip


def _check_files(tree: Branch, complaints: Complaints) -> None:
    if "file" not in tree.items and "files" not in tree.items:
        complaints.refuse(tree.spot, "the mapping has no `file`", "add `file: recording.csv`")
    elif "file" in tree.items and "files" in tree.items:
        complaints.refuse(tree.key_spot("files"), "files is given beside file", "keep one of them")


def _read_files(
    tree: Branch, values: Mapping[str, Any], complaints: Complaints
) -> tuple[Samples | None, tuple[Cut, ...]]:
    """The samples within `from` and `until`, and where they are parted; None where there was a complaint."""
    key = "files" if "files" in values else "file"
    tables = list[Table]()
    if "columns" not in values or key not in values or ("time" in tree.items and "time" not in values):
        return None, ()
    for file in values[key]:
        with collecting(complaints, tree.key_spot(key), key):
            tables.append(table(file, _chooser(tree, values, file), complaints, layout_of(values)))
    if complaints.refusals:
        return None, ()
    clock: Clock = values.get("time", Clock(interval=values.get("interval")))
    samples = _part(channels(tables, clock.interval), values, tree)
    return samples, find_cuts(samples, complaints)


def _part(samples: Samples, values: Mapping[str, Any], tree: Branch) -> Samples:
    """The samples from `from` on and before `until`. Raises Refused where fewer than two are left."""
    t = samples.t
    kept = ~((t < values.get("from", -np.inf)) | (t >= values.get("until", np.inf)))
    if len(t) > 1 and kept.sum() < 2:
        key = "from" if "from" in values else "until"
        wrong = f"`from` and `until` leave {kept.sum()} of {len(t)} samples"
        right = f"the recording goes from {t[0]:.10g} s to {t[-1]:.10g} s, keep at least two samples"
        raise refuse(tree.key_spot(key), wrong, right)
    columns = {name: c.keep(kept) for name, c in samples.columns.items()}
    return replace(samples, t=t[kept], columns=columns, lines=samples.lines[kept], file_of=samples.file_of[kept])


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
    told = [key for key in ("interval", "time") if key in tree.items]
    if "time" in names and told:
        complaints.refuse(tree.key_spot(told[0]), f"{told[0]} is given beside a time column", "keep one of them")
    if len(told) > 1:
        complaints.refuse(tree.key_spot("interval"), "interval is given beside time", "keep one of them")
    if "time" not in names and not told:
        right = 'map one to "time [s]", or give `time: {column: …, unit: …}` or `interval: 10 s`'
        complaints.refuse(spot, "no column is mapped to time", right)
    for name in [name for name in values["inputs"] if name in names]:
        complaints.refuse(tree.key_spot("inputs"), f"the input '{name}' is a column as well", "keep one of them")
    for key in ("fill", "between", "zero"):
        for name in [name for name in values[key] if name not in names]:
            complaints.refuse(tree.key_spot(key), f"{key} names '{name}', which is no column", likely(name, names))


def _chooser(tree: Branch, values: Mapping[str, Any], path: Path) -> Choose:
    branch, columns = tree.items["columns"], dict(values["columns"])
    clock: Clock = values.get("time", Clock())

    def choose(header: Header, complaints: Complaints) -> list[Heading]:
        wanted = [(theirs, heading, branch.key_spot(theirs) if isinstance(branch, Branch) else branch.spot)
                  for theirs, heading in columns.items()]  # fmt: skip
        if clock.column:
            heading = Heading("time", clock.unit or unit("s"), clock.column, stamp=clock.form)
            wanted.append((clock.column, heading, tree.key_spot("time")))
        known, found = list(header.labels), []
        for theirs, heading, spot in wanted:
            if theirs not in known:
                complaints.refuse(spot, f"the file {path.name} has no column '{theirs}'", likely(theirs, known))
                continue
            refuse_twice([text for text in known if text == theirs], spot, complaints)
            found.append(replace(heading, label=theirs, index=known.index(theirs)))
        return found

    return choose
