"""Plain numbers with commas between, read by blocks of bytes: what a recording of many megabytes is made of."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from network.catalogue.declaration.declare import Array

_BLOCK = 1 << 24
"""Bytes at a time: as few as keep the memory small beside what is read."""
_COMMA, _NEWLINE = b",\n"
_LETTERS = b"-+.,0123456789eEnaN\n"
_SPACES = b" \t\r"
_APART = re.compile(rb"[^,\n \t][ \t]+[^,\r\n \t]|\r(?!\n)")
"""What no plain number has inside: spaces, and ends of lines that are none here."""
_GAPS = ((b",,", b",nan,"), (b",,", b",nan,"), (b"\n,", b"\nnan,"), (b",\n", b",nan\n"))
"""In this order: of three commas in a row the first pass fills every other gap."""


def read_plain_numbers(path: Path, width: int, use: Sequence[int]) -> Array | None:
    """The columns `use` of the rows below the first line, an empty field being NaN; None where any line holds anything
    but `width` plain numbers, or none does. Raises OSError."""
    blocks = []
    with path.open("rb") as handle:
        handle.readline()
        rest = b""
        while block := handle.read(_BLOCK):
            whole = block.rfind(b"\n") + 1
            text, rest = rest + block[:whole], block[whole:] if whole else rest + block
            if whole:
                blocks.append(_numbers_of(text, width, use))
        if rest:
            blocks.append(_numbers_of(rest + b"\n", width, use))
    known = [block for block in blocks if block is not None]
    return np.concatenate(known) if known and len(known) == len(blocks) else None


def _numbers_of(text: bytes, width: int, use: Sequence[int]) -> Array | None:
    if odd := text.translate(None, _LETTERS):
        if odd.translate(None, _SPACES) or _APART.search(text):
            return None
        text = text.translate(None, _SPACES)
    text = _fill_gaps(text)
    letters = np.frombuffer(text, np.uint8)
    ends = np.flatnonzero(letters == _NEWLINE)
    before = np.searchsorted(np.flatnonzero(letters == _COMMA), ends)
    if (np.diff(before, prepend=0) != width - 1).any() or (np.diff(ends, prepend=-1) == 1).any():
        return None
    with warnings.catch_warnings(), suppress(ValueError, DeprecationWarning):
        warnings.simplefilter("error", DeprecationWarning)  # what is no number, in versions before 2.3
        values = np.fromstring(text[:-1].replace(b"\n", b","), sep=",")
        return values.reshape(-1, width)[:, list(use)]
    return None


def _fill_gaps(text: bytes) -> bytes:
    for gap, filled in _GAPS:
        if gap in text:
            text = text.replace(gap, filled)
    return b"nan" + text if text.startswith(b",") else text
