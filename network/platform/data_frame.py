"""Columns as a pandas data frame, for those who have pandas."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib import import_module
from typing import Any


def data_frame(columns: Iterable[tuple[str, str, Any]], index: tuple[str, str, Any] | None = None) -> Any:
    """A data frame of (name, unit, values in that unit), headed `name [unit]`. Raises ImportError without pandas."""
    pandas = _find_pandas()
    frame = pandas.DataFrame({_head(name, unit): values for name, unit, values in columns})
    if index is not None:
        name, unit, values = index
        frame.index = pandas.Index(values, name=_head(name, unit))
    return frame


def table_frame(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> Any:
    """A data frame of rows. Raises ImportError without pandas."""
    return _find_pandas().DataFrame(list(map(list, rows)), columns=list(header))


def _head(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _find_pandas() -> Any:
    try:
        return import_module("pandas")
    except ImportError:
        right = "install it with `pip install 'lptn[pandas]'`; columns() gives the same as plain arrays"
        raise ImportError(f"a data frame needs pandas, which is not installed: {right}") from None
