"""Many independent pieces of work: one after the other, over processes, or over a cluster; results in their order.

Processes are fresh ones, begun once for a whole command beside the one that begins them, which takes its part of the
work. However that one ends, they end too.
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
        return _Shared(pool, shelf, items, say).done_with(work)


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


# -- here -----------------------------------------------------------------------------------------------------------
class _Shared:
    """Items that are taken one by one, by other processes and by this one."""

    def __init__(self, pool: _Pool, shelf: Path, items: Sequence[Any], say: Told) -> None:
        self.pool, self.shelf, self.items, self.say = pool, shelf, items, say
        self.left, self.lock, self.told = iter(range(len(items))), threading.Lock(), 0
        self.there: dict[int, Future[Any]] = {}

    def done_with(self, work: Callable[[Any], Any]) -> list[Any]:
        """Raises at the first that failed."""
        here: dict[int, Any] = {}
        try:
            for _ in range(self.pool.others):
                self.send()
            while (i := self.take()) is not None:
                here[i] = work(self.items[i])
                self.tell(len(here) + sum(future.done() for future in self.there.values()))
            for done, future in enumerate(as_completed(self.there.values()), len(here) + 1):
                future.result()
                self.tell(done)
        finally:
            self.stop()
        return [here[i] if i in here else self.there[i].result() for i in range(len(self.items))]

    def take(self) -> int | None:
        with self.lock:
            return next(self.left, None)

    def send(self, before: Future[Any] | None = None) -> None:
        """The next one to a process that is free, and so on from there."""
        if before is not None and (before.cancelled() or before.exception() is not None):
            self.stop()
        with self.lock:
            i = next(self.left, None)
            if i is not None:
                self.there[i] = self.pool.submit(self.shelf, self.items[i])
        if i is not None:
            self.there[i].add_done_callback(self.send)

    def stop(self) -> None:
        with self.lock:
            self.left = iter(())

    def tell(self, done: int) -> None:
        while self.told < done:
            self.told += 1
            self.say(self.told / len(self.items))


class _Pool:
    """Processes beside this one, and a folder in which they find what they work with, so that each reads it once."""

    def __init__(self, jobs: int, folder: Path) -> None:
        self.others, self.folder, self.context, self._names = jobs - 1, folder, _Watched(), count()
        try:
            self.executor = ProcessPoolExecutor(self.others, self.context, _begin)
        except (ValueError, NotImplementedError, OSError) as error:
            raise refuse(Spot(f"--jobs {jobs}"), f"cannot be had here ({error})", "use fewer, or --jobs 1") from None

    def load(self, module: str) -> None:
        for _ in range(self.others):
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
        for process in self.context.started:
            process.terminate()
        self.executor.shutdown(cancel_futures=True)


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
