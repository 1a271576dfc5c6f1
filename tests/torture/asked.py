"""Tests in a copy of this process, which has loaded what the project stands on, but nothing of the project."""

from __future__ import annotations

import importlib
import os
import resource
import signal
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

LOADED = ("pytest", "_pytest.assertion", "numpy", "scipy.linalg", "scipy.optimize", "scipy.integrate", "scipy.signal",
          "scipy.interpolate", "scipy.sparse.linalg", "scipy.special", "scipy.stats", "networkx", "yaml", "click",
          "rich.console", "rich.table", "pint", "jinja2", "threadpoolctl", "hypothesis")  # fmt: skip
WHOLE = ("-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-m", "not speed")
FIRST = ("-x", *WHOLE)
"""Whether all are run, or those up to the first that fails."""
PATIENCE = 20.0
"""s of a clock for each of the processor, which others work on too."""


def load() -> None:
    for name in LOADED:
        importlib.import_module(name)


def ask(
    words: Iterable[str], limit: float, settings: Mapping[str, str] | None = None, like: Sequence[str] = FIRST
) -> int:
    """The status that pytest ends with, in the working folder; that of a signal where it takes longer than the limit
    [s of a processor], as what hangs does."""
    load()
    copy = os.fork()
    if not copy:
        _answer([*like, *words], limit, settings or {})
    until = time.monotonic() + PATIENCE * limit
    try:
        while not (ended := os.waitpid(copy, os.WNOHANG))[0]:
            if time.monotonic() > until:
                os.killpg(copy, signal.SIGKILL)
                ended = os.waitpid(copy, 0)
                break
            time.sleep(0.02)
    finally:
        _end(copy)
    return os.waitstatus_to_exitcode(ended[1])


def _end(group: int) -> None:
    try:
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        return


def _answer(words: list[str], limit: float, settings: Mapping[str, str]) -> None:
    status = 70
    try:
        os.setsid()
        used = time.process_time()
        resource.setrlimit(resource.RLIMIT_CPU, (int(used + limit) + 1,) * 2)
        os.environ.update(settings)
        nowhere = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1, 2):
            os.dup2(nowhere, number)
        sys.path[:0] = [str(Path.cwd()), str(Path.cwd() / "tests")]
        import pytest

        status = int(pytest.main(words))
    finally:
        os._exit(status)
