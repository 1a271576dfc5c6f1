"""`lptn` in a copy of this process, which has loaded everything already: a command begins to compute at once, so that
stops meet what it computes and writes. What an interpreter does before that is left to processes of their own."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import tempfile
import traceback
from collections.abc import Sequence
from pathlib import Path

from network.cli import main

HEARD = (signal.SIGINT, signal.SIGTERM)


def warm_up(arguments: Sequence[str], where: Path) -> None:
    """Does it here once, so that it is loaded. Raises RuntimeError where it does not end well."""
    with Path(os.devnull).open("w") as nowhere, contextlib.chdir(where), contextlib.redirect_stdout(nowhere):
        try:
            main(arguments)
        except SystemExit as end:
            if end.code:
                raise RuntimeError(f"{arguments} ended with {end.code}") from None


class Forked:
    """What `subprocess.Popen` tells of a process, as far as it is asked for."""

    def __init__(self, arguments: Sequence[str], where: Path) -> None:
        self.returncode: int | None = None
        self.told = tempfile.TemporaryFile()  # noqa: SIM115 (closed when it has been read)
        signal.pthread_sigmask(signal.SIG_BLOCK, HEARD)  # a stop that comes before a copy has begun must wait for it
        self.pid = os.fork()
        if not self.pid:
            self._run(arguments, where)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, HEARD)

    def _run(self, arguments: Sequence[str], where: Path) -> None:
        code = 70
        try:
            os.setsid()
            nowhere = os.open(os.devnull, os.O_RDWR)
            for file, number in ((nowhere, 0), (nowhere, 1), (self.told.fileno(), 2)):
                os.dup2(file, number)
            os.chdir(where)
            for number in HEARD:
                signal.signal(number, signal.SIG_DFL)  # ends it without a word until it is heard, and afterwards
            signal.pthread_sigmask(signal.SIG_UNBLOCK, HEARD)
            main(arguments)
            code = 0
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
        except BaseException:
            traceback.print_exc()
        finally:
            with contextlib.suppress(BaseException):
                sys.stderr.flush()
            os._exit(code)

    def poll(self) -> int | None:
        return self._wait(os.WNOHANG)

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def communicate(self) -> tuple[None, bytes]:
        self._wait(0)
        self.told.seek(0)
        with self.told:
            return None, self.told.read()

    def _wait(self, how: int) -> int | None:
        if self.returncode is None:
            process, status = os.waitpid(self.pid, how)
            self.returncode = os.waitstatus_to_exitcode(status) if process else None
        return self.returncode
