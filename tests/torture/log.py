"""What was tried, a line each, so that what was done stays done when it is stopped and begun again."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

Told = dict[str, Any]


def go_on(path: Path | None, count: int, attempt: Callable[[int], Told]) -> list[Told]:
    """What each attempt tells, by its number; those in the file are not made again, and each new one is added to it."""
    told = [json.loads(line) for line in path.read_text().splitlines()] if path and path.is_file() else []
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
    for number in range(len(told), count):
        told.append(attempt(number))
        if path is not None:
            with path.open("a", encoding="utf-8") as log:
                print(json.dumps(told[-1]), file=log)
        if number % 100 == 99:
            print(f"{number + 1}/{count}", file=sys.stderr, flush=True)
    return told[:count]


def read_numbered(path: Path) -> dict[int, Told]:
    """What was told last of each, by its number; a line without one is of the number that it stands at, and one that
    was broken off is of none."""
    found = dict[int, Told]()
    for at, line in enumerate(path.read_text("utf-8").splitlines() if path.is_file() else ()):
        with suppress(json.JSONDecodeError):
            told = json.loads(line)
            found[told.get("number", at)] = told
    return found
