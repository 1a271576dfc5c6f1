"""Cells of a table as numbers: points and commas, words for a gap, and every fault told once for its column."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from network.catalogue.declaration.declare import Array
from network.recordings.alike import Alike

GAPS = frozenset(
    ("", "nan", "na", "n/a", "n.a.", "#n/a", "#nan", "null", "none", "nil", "missing", "-", "--", "---", "?", "1.#qnan",
     "-1.#qnan", "1.#ind", "-1.#ind", "-nan")
)  # fmt: skip
"""Words, in small letters, by which loggers and spreadsheets say that there is no reading."""
_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_NUMBER = "write a number, or leave the field empty for a gap"
_STAMP = "head the column `time`, without a unit, and time stamps are read; or say `time:` in a mapping"


def is_number(text: str) -> bool:
    """A number, with a point or a comma, or a word for a gap that is not empty."""
    try:
        _number(text.replace(",", "."))
    except ValueError:
        return False
    return bool(text)


def _number(text: str) -> float:
    if text.lower() in GAPS:
        return float("nan")
    if "_" in text or not text.isascii():  # Python would read 1_0 as ten
        raise ValueError
    return float(text)


def read_numbers(
    texts: Sequence[str], lines: Sequence[int], label: str, has_commas: bool | None, faults: Alike
) -> Array:
    """One column; has_commas: whether decimals are written with a comma, None where its cells have to tell it: some
    have a comma, and none a point."""
    if has_commas is None:
        has_commas = any("," in text for text in texts) and not any("." in text for text in texts)
    values = np.empty(len(texts))
    for k, (text, line) in enumerate(zip(texts, lines, strict=True)):
        try:
            if has_commas and "." in text and text.lower() not in GAPS:
                raise ValueError
            values[k] = _number(text.replace(",", ".") if has_commas else text)
        except ValueError:
            values[k] = np.nan
            right = _remedy(text, bool(has_commas))
            faults.add(("text", label), line, f"column '{label}' has the text '{text[:40]}'", right)
    for k in np.flatnonzero(np.isinf(values)).tolist():
        right = "give a finite number, or an empty field for a gap"
        faults.add(("infinite", label), lines[k], f"column '{label}' is infinite", right)
    return values


def _remedy(text: str, has_commas: bool) -> str:
    if re.match(r"\d+[-:]\d+[-:]\d+", text):
        return _STAMP
    if _COMMA.fullmatch(text):
        return f'write {text.replace(",", ".")}, or say `decimal: ","` in a mapping'
    return "write decimals with a comma, as the others are" if has_commas and "." in text else _NUMBER
