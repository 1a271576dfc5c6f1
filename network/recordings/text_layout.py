"""How the text of a table is laid out: its encoding, what stands between columns, where its header is."""

from __future__ import annotations

import codecs
import csv
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from network.platform.package_data import hint
from network.platform.refusal import Spot, refuse

LARGEST_FILE = 500_000_000
EXPECTED = "the first row is like `time [s],speed [rpm],T_housing [degC]`"
UTF8 = "save it as CSV in UTF-8"
DELIMITERS = (";", "\t", ",")
"""In this order where two part a line alike: a comma may then stand in decimals."""
ENCODINGS = ("utf-8-sig", "cp1252")
WORKBOOKS = (".xlsx", ".xlsm")
_CHUNK = 1 << 20
MARK = "#"
_LOOKED = 1 << 16
"""Characters from which the delimiter is found."""


@dataclass(frozen=True)
class Layout:
    """delimiter, encoding: '' until they are found; decimal: '' where the cells tell it; comment: what a line begins
    with that holds no data; before: lines ahead of the header; header: whether the columns are named, marked: by a row
    that begins with #; sheet: of a workbook, '' for its only one."""

    delimiter: str = ""
    encoding: str = ""
    decimal: str = ""
    comment: str = ""
    header: bool = True
    sheet: str = ""
    before: int = 0
    marked: bool = False

    @property
    def is_plain(self) -> bool:
        """Rows of numbers with commas between and a header above, as a recording of ours is."""
        ours = self.delimiter == "," and self.encoding == "utf-8-sig" and self.decimal in ("", ".")
        return ours and not self.comment and self.header and not self.before and not self.marked


def find_layout(path: Path, given: Layout) -> Layout:
    """What was not given, from the file. Raises Refused for what is no file or no text."""
    spot = Spot(str(path))
    if not os.path.isfile(path):
        wrong = "is not a file" if os.path.exists(path) else "there is no such file"
        raise refuse(spot, wrong, f"give the path of a recording{hint(path)}")
    if path.stat().st_size > LARGEST_FILE:
        wrong = f"has {path.stat().st_size / 1e6:.0f} MB, more than {LARGEST_FILE / 1e6:.0f} MB"
        raise refuse(spot, wrong, "split it, or take fewer samples")
    if path.suffix.lower() in WORKBOOKS:
        return given
    try:
        encoding = _find_encoding(path)
        with path.open(encoding=encoding, newline="") as handle:
            text = handle.read(_LOOKED)
    except OSError as error:
        raise refuse(spot, f"cannot be read: {error.strerror}", "give a file you may read") from None
    if "\0" in text:
        raise refuse(Spot(str(path), 1), "is not UTF-8 text", UTF8)
    lines = text.splitlines()
    found = replace(given, encoding=encoding, delimiter=_find_delimiter(lines, given))
    return found if given.comment else _find_mark(lines, found)


def _find_mark(lines: Sequence[str], layout: Layout) -> Layout:
    """Lines ahead of the header that begin with # are comments; where numbers follow, the last is the header."""
    lead = next((k for k, line in enumerate(lines) if not line.startswith(MARK)), len(lines))
    if not lead:
        return layout
    first = next(csv.reader(lines[lead : lead + 1], delimiter=layout.delimiter), [])
    if layout.header and any(first) and all(_begins_with_digit(cell) for cell in first if cell.strip()):
        return replace(layout, before=lead - 1, marked=True)
    return replace(layout, comment=MARK)


def _begins_with_digit(cell: str) -> bool:
    return cell.strip().lstrip("+-.,").lower().startswith((*"0123456789", "nan"))


def _find_encoding(path: Path) -> str:
    """UTF-8; UTF-16 by its mark; else the 8 bits of Windows in western Europe, which loggers there write. Raises
    Refused where it is none of them."""
    with path.open("rb") as handle:
        if handle.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
            return "utf-16"
    found = next((name for name in ENCODINGS if _is_all_in(path, name)), None)
    if found is None:
        raise refuse(Spot(str(path), 1), "is text neither of UTF-8 nor of Windows in western Europe (cp1252)", UTF8)
    return found


def _is_all_in(path: Path, encoding: str) -> bool:
    decoder = codecs.getincrementaldecoder(encoding)()
    with path.open("rb") as handle:
        try:
            while chunk := handle.read(_CHUNK):
                decoder.decode(chunk)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            return False
    return True


def _find_delimiter(lines: Sequence[str], layout: Layout) -> str:
    """Of those that part the first line, the one that parts most of the others alike. A text cut off at its end has a
    last line that is not looked at."""
    told = [line for line in lines if line.strip() and not (layout.comment and line.startswith(layout.comment))]
    told = [line for line in told if not line.startswith(MARK)] or told
    told = told[:-1] if len(told) > 2 else told
    best, delimiter = 0.0, ","
    for mark in DELIMITERS:
        widths = [_width(line, mark) for line in told[:50]]
        if widths and widths[0] > 1:
            share = sum(width >= widths[0] for width in widths) / len(widths)
            best, delimiter = max((best, delimiter), (share, mark), key=lambda pair: pair[0])
    return delimiter


def _width(line: str, delimiter: str) -> int:
    try:
        return len(next(csv.reader([line], delimiter=delimiter), []))
    except csv.Error:
        return 0
