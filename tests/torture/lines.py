"""A plugin of pytest that writes down which lines each test runs, with what it takes of the processor, where it passes.

    LINES_OF=network/engine/solvers LINES_TO=lines.json python -m pytest -p torture.lines tests/test_steps.py

Python is asked to tell of a line once a test (`sys.monitoring`, from 3.12 on), so that a traced test takes hardly
longer than one that is not. Lines that a fixture runs are those of every test that asks for it, with what it takes.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType
from typing import Any

import pytest

LONGEST = float(os.environ.get("LINES_LONGEST", "40"))
"""s of the processor for a test file; what it has not come to by then is not asked."""
ROOMS = tuple(str(Path(room).resolve()) for room in os.environ.get("LINES_OF", "").split(os.pathsep))
Lines = set[tuple[str, int]]


@dataclass
class Part:
    """What a test or a fixture runs by itself."""

    lines: Lines = field(default_factory=set)
    seconds: float = 0.0


_open: list[Part] = []
_fixtures: dict[int, Part] = {}
_tests: dict[str, Part] = {}
_asked: dict[str, list[Part]] = {}
_passed: dict[str, bool] = {}


def _see(code: CodeType, line: int) -> Any:
    if _open and code.co_filename.startswith(ROOMS):
        _open[-1].lines.add((code.co_filename, line))
    return sys.monitoring.DISABLE


def pytest_sessionstart() -> None:
    sys.monitoring.use_tool_id(sys.monitoring.COVERAGE_ID, "lines")
    sys.monitoring.register_callback(sys.monitoring.COVERAGE_ID, sys.monitoring.events.LINE, _see)
    sys.monitoring.set_events(sys.monitoring.COVERAGE_ID, sys.monitoring.events.LINE)


def _watch(part: Part) -> Iterator[None]:
    _open.append(part)
    sys.monitoring.restart_events()
    began = time.process_time()
    yield
    spent = time.process_time() - began
    part.seconds += spent
    _open.pop()
    if _open:  # what a fixture takes is not taken by what asked for it
        _open[-1].seconds -= spent
        sys.monitoring.restart_events()


@pytest.hookimpl(hookwrapper=True)
def pytest_fixture_setup(fixturedef: Any) -> Iterator[None]:
    yield from _watch(_fixtures.setdefault(id(fixturedef), Part()))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: Any) -> Iterator[None]:
    own = _tests.setdefault(item.nodeid, Part())
    yield from _watch(own)
    for part in _asked.pop(item.nodeid, ()):
        own.lines |= part.lines
        own.seconds += part.seconds


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_call(item: Any) -> None:
    asked = (id(each) for each in item._request._fixture_defs.values())
    _asked[item.nodeid] = [_fixtures[each] for each in asked if each in _fixtures]


def pytest_runtest_logreport(report: Any) -> None:
    _passed[report.nodeid] = _passed.get(report.nodeid, True) and report.outcome == "passed"


@pytest.hookimpl(trylast=True)
def pytest_runtest_logfinish(nodeid: str) -> None:
    if time.process_time() > LONGEST:
        pytest.exit("longer than it may take", returncode=0)


def pytest_unconfigure() -> None:
    told = {
        test: {"seconds": round(part.seconds, 4), "lines": _by_module(part.lines)}
        for test, part in _tests.items()
        if _passed.get(test)
    }
    Path(os.environ["LINES_TO"]).write_text(json.dumps(told), encoding="utf-8")


def _by_module(lines: Lines) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    for file, line in sorted(lines):
        found.setdefault(Path(file).relative_to(Path.cwd()).as_posix(), []).append(line)
    return found
