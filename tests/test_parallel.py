"""One map over processes: results in their order, work that reaches a process once, processes that end with theirs."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from functools import partial
from multiprocessing import parent_process
from pathlib import Path

import pytest

from network.platform import processes as beside
from network.platform.parallel import processes, run_all
from network.platform.refusal import Failed, Refused

TESTS = Path(__file__).parent
HELD = """
import pathlib, sys
from functools import partial
from network.platform.parallel import processes, run_all
from test_parallel import hold

with processes(3, "network.platform.parallel"):
    run_all(partial(hold, pathlib.Path(sys.argv[1])), range(3), 3)
"""


def add(more: int, item: int) -> tuple[int, int]:
    time.sleep(0.02)
    return item + more, os.getpid()


class Found:
    """What takes the interpreter a moment to pack."""

    def __reduce__(self) -> tuple[type[Found], tuple[()]]:
        time.sleep(1e-5)
        return Found, ()


def remember(item: tuple[dict[int, Found], int]) -> int:
    """Work that keeps what it found with something that the items share."""
    shared, own = item
    began = time.monotonic()
    while time.monotonic() < began + 0.05:
        shared[len(shared)] = Found()
        time.sleep(1e-4)
    return own


def divide(item: int) -> float:
    return 1 / item


def leave(item: int) -> None:
    if os.getpid() != item:
        os._exit(3)
    time.sleep(1)


def hold(folder: Path, item: int) -> None:
    """Leaves word that it has begun; then the one that began the others waits, and these never let go of their
    interpreters."""
    (folder / f"{os.getpid()}.pid").touch()
    if parent_process() is None:
        time.sleep(1000)
    sum(range(10**13))


def is_gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def test_items_may_share_what_work_changes() -> None:
    shared = {k: Found() for k in range(200)}
    assert run_all(remember, [(shared, k) for k in range(8)], 2) == [*range(8)]


def test_results_come_in_their_order_whoever_worked() -> None:
    heard: list[float] = []
    told = run_all(partial(add, 10), range(12), 2, heard.append)
    assert [value for value, _ in told] == list(range(10, 22))
    assert heard == pytest.approx([(k + 1) / 12 for k in range(12)])


def test_processes_last_as_long_as_what_they_were_begun_for() -> None:
    with processes(3, "network.platform.parallel"):
        pids = {pid for more in range(3) for _, pid in run_all(partial(add, more), range(40), 3)}
    assert os.getpid() in pids and 2 <= len(pids) <= 3
    assert all(is_gone(pid) for pid in pids - {os.getpid()})


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_fails_raises_here(jobs: int) -> None:
    with pytest.raises(ZeroDivisionError):
        run_all(divide, [4, 2, 0, 1, 5], jobs)


def test_a_process_that_ends_by_itself_is_told() -> None:
    with pytest.raises(Failed, match="a process ended before its work was done"):
        run_all(leave, [os.getpid()] * 4, 2)


def test_processes_that_cannot_be_had_are_told_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_pool(*_: object) -> None:
        raise NotImplementedError("no semaphores")

    monkeypatch.setattr(beside, "ProcessPoolExecutor", no_pool)
    with pytest.raises(Refused, match=r"--jobs 2: cannot be had here \(no semaphores\); use fewer, or --jobs 1"):
        run_all(divide, [1, 2], 2)
    with pytest.raises(Refused, match="0 is not a number of processes"):
        run_all(divide, [1, 2], 0)


def test_a_process_that_cannot_begin_is_told_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_process(self: object) -> None:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(beside._Worker, "start", no_process)
    with pytest.raises(Refused, match=r"--jobs 2: cannot be had here .*unavailable.*; use fewer, or --jobs 1"):
        run_all(divide, [1, 2], 2)


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc, and the work does not let go of the interpreter")
def test_processes_end_with_one_that_is_killed(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": f"{TESTS.parent}:{TESTS}"}
    with subprocess.Popen([sys.executable, "-c", HELD, str(tmp_path)], env=environment) as program:
        until = time.monotonic() + 60
        while len([*tmp_path.glob("*.pid")]) < 3 and time.monotonic() < until:
            time.sleep(0.05)
        program.send_signal(signal.SIGKILL)
        program.wait()
    pids = [int(path.stem) for path in tmp_path.glob("*.pid")]
    until = time.monotonic() + 2
    while not all(map(is_gone, pids)) and time.monotonic() < until:
        time.sleep(0.02)
    assert len(pids) == 3 and all(map(is_gone, pids))
