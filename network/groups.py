"""Commands run beside this one, which end with it."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO


class Groups:
    """Each command has a process group of its own, so that its workers end with it."""

    def __init__(self) -> None:
        self._lock, self._running, self._over = threading.Lock(), set[subprocess.Popen[bytes]](), False

    def run(
        self, command: Sequence[str], where: Path, log: IO[str], limit: float, environment: Mapping[str, str]
    ) -> int | None:
        """Its exit status; None where it took longer than the limit [s], or may not begin any more."""
        with self._started(command, where, log, environment) as process:
            try:
                return process.wait(limit) if process else None
            except subprocess.TimeoutExpired:
                return None

    @contextmanager
    def _started(
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


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is not None:
        return
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    process.wait()
