"""Time stamps: dates with a time, and clocks in hh:mm:ss, as seconds."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import UTC, datetime

import numpy as np

from network.catalogue.declaration.declare import Array
from network.recordings.alike import Alike

AUTO, ISO, CLOCK = "auto", "iso", "hh:mm:ss"
DAY = 86400.0
_CLOCK = re.compile(r"(\d+):([0-5]\d)(?::([0-5]\d(?:[.,]\d*)?|\d+\.\d{6}))?")
_CLOCKS = (CLOCK, "hh:mm", "%H:%M:%S", "%H:%M", "%H:%M:%S.%f")
_DATED = re.compile("%[djcxsU]")
_ORIGIN = datetime(2000, 1, 1)


def find_form(texts: Sequence[str], given: str) -> str:
    """iso, hh:mm:ss or what strptime takes; '' for an automatic one where the cells are no stamps."""
    if given in _CLOCKS:
        return CLOCK
    first = next((text for text in texts if text), "")
    if given != AUTO:
        return given
    if _CLOCK.fullmatch(first):
        return CLOCK
    return ISO if is_date(first) else ""


def is_date(text: str) -> bool:
    """An ISO stamp, and no bare number, which ISO would have too (20200615)."""
    try:
        _iso(text)
    except ValueError:
        return False
    return not text.isdigit()


def _iso(text: str) -> datetime:
    return datetime.fromisoformat(text.strip().replace(",", "."))


def read_stamps(texts: Sequence[str], lines: Sequence[int], label: str, form: str, faults: Alike) -> Array:
    """Seconds since midnight of the first day (hh:mm:ss, hours past 24 too), or since 2000-01-01 UTC; NaN where a cell
    is empty or faulty."""
    if form == CLOCK:
        return _over_midnight(np.array([_read(text, line, label, form, _clock, faults)
                                        for text, line in zip(texts, lines, strict=True)], float))  # fmt: skip
    parse = _iso if form == ISO else lambda text: datetime.strptime(text, form)
    zoned: bool | None = None

    def since(text: str) -> float:
        nonlocal zoned
        stamp = parse(text)
        has_zone = stamp.tzinfo is not None
        zoned = has_zone if zoned is None else zoned
        if has_zone != zoned:
            raise ValueError
        return (stamp - _ORIGIN.replace(tzinfo=UTC if has_zone else None)).total_seconds()

    seconds = np.array([_read(text, line, label, form, since, faults)
                        for text, line in zip(texts, lines, strict=True)], float)  # fmt: skip
    return seconds if _DATED.search(form) or form == ISO else _over_midnight(seconds % DAY)


def _read(text: str, line: int, label: str, form: str, parse: Callable[[str], float], faults: Alike) -> float:
    if not text:
        return float("nan")
    try:
        return parse(text)
    except ValueError:
        like = {ISO: "2020-06-15T08:30:00", CLOCK: "08:30:00"}.get(form) or datetime(2020, 6, 15, 8, 30).strftime(form)
        wrong = f"column '{label}' has the text '{text[:40]}', which is no time stamp in the form {form}"
        faults.add(("stamp", label), line, wrong, f"write it like {like}, or give its form with `time:` in a mapping")
        return float("nan")


def _clock(text: str) -> float:
    match = _CLOCK.fullmatch(text)
    if not match:
        raise ValueError
    return 3600.0 * int(match[1]) + 60.0 * int(match[2]) + float((match[3] or "0").replace(",", "."))


def _over_midnight(seconds: Array) -> Array:
    """A clock that goes back from one day to the next runs on: where 24 h more make a step no longer than half a day.

    A clock that counts past 24 h, or that begins anew (a step back of less than half a day), stays as it is.
    """
    known = np.flatnonzero(np.isfinite(seconds))
    if not len(known) or seconds[known].max() >= DAY:
        return seconds
    days = np.cumsum(np.diff(seconds[known], prepend=seconds[known[0]]) < -DAY / 2)
    seconds[known] += DAY * days
    return seconds
