"""Commands run beside this one, which end with it."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

LOOK = 0.05
"""s between two looks at whether a command has ended."""
PATIENCE = 4.0
"""Times its limit that a command may take where others keep the processors from it."""


@dataclass(frozen=True)
class Ended:
    """Exit status of a command, None where it took too long or may not begin any more; seconds of processors that it
    and its children took, and seconds that passed."""

    code: int | None
    busy: float
    passed: float


class Groups:
    """Each command has a process group of its own, so that its workers end with it."""

    def __init__(self) -> None:
        self._lock, self._running, self._over = threading.Lock(), set[subprocess.Popen[bytes]](), False

    def run(
        self, command: Sequence[str], where: Path, log: IO[str], limit: float, environment: Mapping[str, str],
        jobs: int = 1,
    ) -> Ended:  # fmt: skip
        """How it ended. limit: s for each of its `jobs` processors, so that what runs beside it costs it nothing."""
        with self._start(command, where, log, environment) as process:
            return _wait(process, limit, jobs) if process else Ended(None, 0.0, 0.0)

    @contextmanager
    def _start(
        self, command: Sequence[str], where: Path, log: IO[str], environment: Mapping[str, str]
    ) -> Iterator[subprocess.Popen[bytes] | None]:
        with self._lock:
            if self._over:
                yield None
                return
            process = subprocess.Popen(
                command, cwd=where, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
                env=environment,
            )  # fmt: skip
            self._running.add(process)
        try:
            yield process
        finally:
            _end(process)
            with self._lock:
                self._running.discard(process)

    def end(self) -> None:
        """Ends all that run; none begins any more."""
        with self._lock:
            self._over = True
            for process in self._running:
                _end(process)


def _wait(process: subprocess.Popen[bytes], limit: float, jobs: int) -> Ended:
    """Waits for it, until processors have worked for it for too long, or it has waited for them for too long."""
    began = time.monotonic()
    while (passed := time.monotonic() - began) < PATIENCE * limit and _busy(process.pid, passed) < limit * jobs:
        if (used := _reap(process)) is not None:
            return Ended(process.returncode, used, time.monotonic() - began)
        time.sleep(LOOK)
    return Ended(None, _busy(process.pid, passed), passed)


def _reap(process: subprocess.Popen[bytes]) -> float | None:
    """Seconds of processors that an ended process and its children took; None while it runs."""
    try:
        pid, status, used = os.wait4(process.pid, os.WNOHANG)
    except ChildProcessError:
        process.wait()
        return 0.0
    if not pid:
        return None
    process.returncode = os.waitstatus_to_exitcode(status)
    return used.ru_utime + used.ru_stime


def _busy(pid: int, passed: float) -> float:
    """Seconds of processors that a process and its ended children took; what has passed where nobody counts."""
    try:
        counts = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    except OSError:
        return passed
    return sum(int(ticks) for ticks in counts[11:15]) / os.sysconf("SC_CLK_TCK")


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is not None:
        return
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    process.wait()
