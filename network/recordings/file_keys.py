"""The keys of a mapping that say how its file is written: time, files, sheet, comment, header, decimal."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from network.catalogue.declaration.fields import word_of
from network.platform.quantities.units import BadNumber, Unit, unit
from network.platform.refusal import Complaints
from network.platform.yaml.document import Branch, Items, Tree
from network.recordings.stamps import AUTO, ISO
from network.recordings.text_layout import Layout
from network.recordings.yaml_values import check_keys, collecting, seconds

KEYS = ("file", "files", "sheet", "comment", "header", "decimal", "interval", "time")
_TIME = "write `{column: time_min, unit: min}`, `{column: when, format: iso}` or `{interval: 120 s}`"


@dataclass(frozen=True)
class Clock:
    """Where the times of rows are: in a column, as a number in a unit or as a stamp in a form; or an interval [s]."""

    column: str = ""
    unit: Unit | None = None
    form: str = ""
    interval: float | None = None


def file_readers(folder: Path) -> dict[str, Callable[[Tree], Any]]:
    """Readers of these keys; each raises BadNumber or Refused."""
    return {
        "file": lambda child: (existing(folder / word_of(child, "the path of a CSV")),),
        "files": lambda child: _files(child, folder),
        "sheet": lambda child: word_of(child, "the name of a sheet"),
        "comment": lambda child: _mark(child),
        "header": lambda child: _word(child, "none") != "none",
        "decimal": lambda child: _word(child, ",", "."),
        "interval": seconds,
        "time": parse_clock,
    }


def layout_of(values: Mapping[str, Any]) -> Layout:
    """The layout as far as a mapping tells it."""
    return Layout(**{key: values[key] for key in ("sheet", "comment", "header", "decimal") if key in values})


def parse_clock(tree: Tree) -> Clock:
    """`time:` of a mapping. Raises BadNumber or Refused."""
    if not isinstance(tree, Branch) or ("interval" in tree.items) == ("column" in tree.items):
        raise BadNumber("does not say where times are", _TIME)
    complaints, values = Complaints(), dict[str, Any]()
    needed = {"interval": "120 s"} if "interval" in tree.items else {"column": "when"}
    check_keys(tree, "time", needed, () if "interval" in needed else ("unit", "format"), complaints)
    readers: dict[str, Callable[[Tree], Any]] = {
        "interval": seconds,
        "column": lambda child: word_of(child, "the name of a column"),
        "unit": _time_unit,
        "format": _form,
    }
    for key in [key for key in readers if key in tree.items]:
        with collecting(complaints, tree.key_spot(key), f"time.{key}"):
            values["form" if key == "format" else key] = readers[key](tree.items[key])
    if "unit" in values and "form" in values:
        complaints.refuse(tree.key_spot("unit"), "time has a unit beside a format", "a stamp has no unit, keep one")
    complaints.raise_if_any()
    return Clock(**({"form": AUTO} if "column" in values and "unit" not in values else {}) | values)


def _time_unit(tree: Tree) -> Unit:
    given = unit(word_of(tree, "s, min or h"))
    if given.dimension != "[time]":
        raise BadNumber(f"is {given.text}", "give s, min or h")
    return given


def _form(tree: Tree) -> str:
    text = word_of(tree, "iso, hh:mm:ss, or a form like `%d.%m.%Y %H:%M:%S`")
    if text not in (ISO, "hh:mm", "hh:mm:ss") and "%" not in text:
        raise BadNumber(f"is '{text}'", "write iso, hh:mm:ss, or a form like `%d.%m.%Y %H:%M:%S`")
    return text


def _files(tree: Tree, folder: Path) -> tuple[Path, ...]:
    if not isinstance(tree, Items) or not tree.entries:
        raise BadNumber("is not a list of files", "write `files: [a.csv, b.csv]`, in the order of time")
    return tuple(existing(folder / word_of(entry, "the path of a CSV")) for entry in tree.entries)


def _mark(tree: Tree) -> str:
    text = word_of(tree, 'what comment lines begin with, like "#"')
    if not text:
        raise BadNumber("is empty", 'write what comment lines begin with, like "#"')
    return text


def _word(tree: Tree, *words: str) -> str:
    text = word_of(tree, " or ".join(words))
    right = " or ".join(f'"{word}"' if word in ",." else word for word in words)
    if text not in words:
        raise BadNumber(f"is '{text}'", f"write {right}, or leave the key away")
    return text


def existing(path: Path) -> Path:
    """Raises BadNumber."""
    if not os.path.exists(path):  # of a name that is too long, pathlib raises
        raise BadNumber(f"there is no file '{path}'", "give its path relative to the mapping")
    return path
