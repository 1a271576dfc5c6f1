"""Many independent pieces of work: one after the other, over processes, or over a cluster; results in their order.

Processes are fresh ones, begun once for a whole command. However the one that began them ends, they end too.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext
from importlib import import_module
from itertools import count
from multiprocessing import parent_process
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from typing import Any, TypeVar

from network.cluster import on_cluster
from network.refusal import Failed, Spot, refuse
from network.stopping import on_stop
from network.threads import begin_on_one_thread, on_one_thread

Item = TypeVar("Item")
Result = TypeVar("Result")
Told = Callable[[float], None]
PR_SET_PDEATHSIG = 1
_OPEN: list[_Pool] = []
_LAST: dict[str, Callable[[Any], Any]] = {}


def run_all(
    work: Callable[[Item], Result], items: Sequence[Item], jobs: int = 1, tell: Told | None = None,
    cluster: str | None = None,
) -> list[Result]:  # fmt: skip
    """work(item) for every item. `work` can be pickled: a function of a module, or a partial of one, whose arguments
    go to every process once; tell is told the share that is done.

    Raises what `work` raises, Refused for processes or a cluster that cannot be had, Failed where a process ends by
    itself.
    """
    say: Told = tell or (lambda share: None)
    if jobs < 1:
        raise refuse(Spot("--jobs"), f"{jobs} is not a number of processes", "give a whole number from 1")
    if cluster is not None:
        return on_cluster(work, items, cluster, say)
    if jobs == 1 or len(items) < 2:
        return list(_one_by_one(work, items, say))
    with nullcontext(_OPEN[-1]) if _OPEN else _pool(min(jobs, len(items))) as pool, pool.shelved(work) as shelf:
        return _gathered([pool.submit(shelf, item) for item in items], say)


@contextmanager
def processes(jobs: int, ready: str) -> Iterator[None]:
    """While it lasts, what is to go over several processes goes over these; each loads a module, `ready`, at once.

    Raises Refused for processes that cannot be had.
    """
    if jobs < 2:
        yield
        return
    with _pool(jobs) as pool:
        pool.load(ready)
        _OPEN.append(pool)
        try:
            yield
        finally:
            _OPEN.remove(pool)


def _one_by_one(work: Callable[[Item], Result], items: Sequence[Item], say: Told) -> Iterator[Result]:
    for done, item in enumerate(items, 1):
        yield work(item)
        say(done / len(items))


def _gathered(futures: Sequence[Future[Any]], say: Told) -> list[Any]:
    try:
        for done, future in enumerate(as_completed(futures), 1):
            future.result()  # raises at the first that failed
            say(done / len(futures))
        return [future.result() for future in futures]
    finally:
        for future in futures:
            future.cancel()


# -- here -----------------------------------------------------------------------------------------------------------
class _Pool:
    """Processes, and a folder in which they find what they work with, so that each reads it once."""

    def __init__(self, jobs: int, folder: Path) -> None:
        self.jobs, self.folder, self.context, self._names = jobs, folder, _Watched(), count()
        try:
            self.executor = ProcessPoolExecutor(jobs, self.context, _begin)
        except (ValueError, NotImplementedError, OSError) as error:
            raise refuse(Spot(f"--jobs {jobs}"), f"cannot be had here ({error})", "use fewer, or --jobs 1") from None

    def load(self, module: str) -> None:
        for _ in range(self.jobs):
            self.executor.submit(import_module, module)

    @contextmanager
    def shelved(self, work: Callable[[Any], Any]) -> Iterator[Path]:
        """Where the processes find it."""
        shelf = self.folder / str(next(self._names))
        shelf.write_bytes(pickle.dumps(work, pickle.HIGHEST_PROTOCOL))
        try:
            yield shelf
        finally:
            shelf.unlink()

    def submit(self, shelf: Path, item: Any) -> Future[Any]:
        return self.executor.submit(_worked, str(shelf), item)

    def end(self) -> None:
        self.executor.shutdown(wait=False, cancel_futures=True)
        for process in self.context.started:
            process.terminate()
        self.executor.shutdown()


@contextmanager
def _pool(jobs: int) -> Iterator[_Pool]:
    """Whatever goes wrong, no process is left running, and no file."""
    folder = tempfile.TemporaryDirectory(prefix="lptn-")
    with folder, on_stop(folder.cleanup):
        pool = _Pool(jobs, Path(folder.name))
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
def _worked(shelf: str, item: Any) -> Any:
    if shelf not in _LAST:
        _LAST.clear()
        _LAST[shelf] = pickle.loads(Path(shelf).read_bytes())
    return _LAST[shelf](item)
