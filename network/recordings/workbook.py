"""The rows of an Excel workbook as text."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

from network.platform.refusal import Spot, likely, refuse


def workbook_rows(path: Path, sheet: str) -> Iterator[tuple[int, list[str]]]:
    """(row, cells) of one sheet, rows counted from 1. Raises Refused where the extra `excel` is not there, for what is
    no workbook, and where several sheets have no choice told."""
    spot = Spot(str(path))
    try:
        from openpyxl import load_workbook
    except ImportError:
        right = "pip install 'lptn[excel]', or save it as CSV"
        raise refuse(spot, "is an Excel workbook, which this installation does not read", right) from None
    try:
        book = load_workbook(path, read_only=True, data_only=True)
    except (BadZipFile, KeyError, ValueError, OSError):
        raise refuse(spot, "is no Excel workbook", "save it again as .xlsx, or as CSV") from None
    try:
        names = list(book.sheetnames)
        if sheet and sheet not in names:
            raise refuse(spot, f"has no sheet '{sheet}'", likely(sheet, names))
        if not sheet and len(names) > 1:
            right = f"say which in a mapping, as in `sheet: {names[0]}`"
            raise refuse(spot, f"has {len(names)} sheets ({', '.join(names)})", right)
        for number, row in enumerate(book[sheet or names[0]].iter_rows(values_only=True), 1):
            yield number, [_text(value) for value in row]
    finally:
        book.close()


def _text(value: Any) -> str:
    """A cell as a CSV would have it; numbers to the last digit."""
    if value is None:
        return ""
    if isinstance(value, datetime | date | time):
        return value.isoformat()
    if isinstance(value, timedelta):
        return f"0:00:{value.total_seconds():.6f}"
    return repr(value) if isinstance(value, float) else str(value).strip()
