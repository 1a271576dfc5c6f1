"""Processes beside the one that begins them: deaf to Ctrl-C, which is meant for that one, and gone when it ends."""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from importlib import import_module
from itertools import count
from multiprocessing import parent_process
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from typing import Any

from network.platform.held_folder import passing_folder
from network.platform.refusal import Failed, Refused, Spot, refuse
from network.platform.threads import begin_on_one_thread, on_one_thread

PR_SET_PDEATHSIG = 1
_LAST: dict[str, Callable[[Any], Any]] = {}


class Pool:
    """Processes beside this one, and a folder in which they find what they work with, so that each reads it once."""

    def __init__(self, jobs: int, folder: Path) -> None:
        self.others, self.folder, self.context, self._names = jobs - 1, folder, _Watched(), count()
        try:
            self.executor = ProcessPoolExecutor(self.others, self.context, _begin)
        except (ValueError, NotImplementedError, OSError) as error:
            raise _cannot_be_had(jobs, error) from None

    def load(self, module: str) -> None:
        for _ in range(self.others):
            self._send(import_module, module)

    @contextmanager
    def shelve(self, work: Callable[[Any], Any]) -> Iterator[Path]:
        """Where the processes find it."""
        shelf = self.folder / str(next(self._names))
        shelf.write_bytes(pickle.dumps(work, pickle.HIGHEST_PROTOCOL))
        try:
            yield shelf
        finally:
            shelf.unlink(missing_ok=True)

    def submit(self, shelf: Path, parcel: bytes) -> Future[Any]:
        """Work on a pickled item."""
        return self._send(_work_on, str(shelf), parcel)

    def _send(self, work: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Processes begin when the first work is there for them. Raises Refused where one cannot begin."""
        try:
            return self.executor.submit(work, *arguments)
        except OSError as error:
            raise _cannot_be_had(self.others + 1, error) from None

    def end(self) -> None:
        for process in self.context.started:
            if process.pid is not None:  # else it could not begin
                process.terminate()
        self.executor.shutdown(cancel_futures=True)


def _cannot_be_had(jobs: int, error: Exception) -> Refused:
    return refuse(Spot(f"--jobs {jobs}"), f"cannot be had here ({error})", "use fewer, or --jobs 1")


@contextmanager
def pool_of(jobs: int) -> Iterator[Pool]:
    """Processes, so many with this one; whatever goes wrong, none is left running, and no file."""
    with passing_folder(Path(tempfile.gettempdir()), "jobs") as folder:
        pool = Pool(jobs, folder)
        try:
            yield pool
        except BrokenProcessPool:
            right = "a script that uses jobs needs `if __name__ == '__main__':`; else try fewer jobs"
            raise Failed(f"a process ended before its work was done; {right}") from None
        finally:
            pool.end()


class _Worker(SpawnProcess):
    """A process that is deaf to Ctrl-C from its first instant, which is meant for the one that started it.

    The signal is held back while it starts, which it inherits, and is not lost.
    """

    def start(self) -> None:
        if not hasattr(signal, "pthread_sigmask"):
            super().start()
            return
        before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Watched(SpawnContext):
    """Remembers the processes it starts."""

    def __init__(self) -> None:
        self.started: list[_Worker] = []

    def Process(self, *arguments: Any, **named: Any) -> _Worker:  # type: ignore[override]
        self.started.append(_Worker(*arguments, **named))
        return self.started[-1]


# -- there ----------------------------------------------------------------------------------------------------------
def _begin() -> None:
    """A process at its start: it is deaf to Ctrl-C, and ends when the one that started it ends, however that ends."""
    begin_on_one_thread()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":  # even while work does not let go of the interpreter
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@on_one_thread
def _work_on(shelf: str, parcel: bytes) -> Any:
    if shelf not in _LAST:
        _LAST.clear()
        _LAST[shelf] = pickle.loads(Path(shelf).read_bytes())
    return _LAST[shelf](pickle.loads(parcel))
