"""Many independent runs: one after the other, over processes, or over a cluster; results in the order of the items."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import parent_process
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, TypeVar

from network.refusal import Failed, Spot, refuse

Shared = TypeVar("Shared")
Item = TypeVar("Item")
Result = TypeVar("Result")
Told = Callable[[float], None]
PATIENCE = "10 s"
"""How long a cluster may take to answer."""


def run_all(
    work: Callable[[Shared, Item], Result], shared: Shared, items: Sequence[Item], jobs: int = 1,
    cluster: str | None = None, told: Told | None = None,
) -> list[Result]:  # fmt: skip
    """work(shared, item) for every item. `work` is a function of a module, `shared` goes to every process once; told
    hears the share that is done.

    Raises what `work` raises, Refused for a cluster that cannot be had, Failed where a process ends by itself.
    """
    tell: Told = told or (lambda share: None)
    if jobs < 1:
        raise refuse(Spot("--jobs"), f"{jobs} is not a number of processes", "give a whole number from 1")
    if cluster is not None:
        return _on_cluster(work, shared, items, cluster, tell)
    if jobs == 1 or len(items) < 2:
        return list(_one_by_one(work, shared, items, tell))
    with _processes(min(jobs, len(items)), work, shared) as pool:
        futures = [pool.submit(_next, item) for item in items]
        return _gathered(futures, tell)


def _one_by_one(
    work: Callable[[Shared, Item], Result], shared: Shared, items: Sequence[Item], tell: Told
) -> Iterator[Result]:
    for done, item in enumerate(items, 1):
        yield work(shared, item)
        tell(done / len(items))


def _gathered(futures: Sequence[Future[Any]], tell: Told) -> list[Any]:
    for done, future in enumerate(as_completed(futures), 1):
        future.result()  # raises at the first that failed
        tell(done / len(futures))
    return [future.result() for future in futures]


# -- processes ------------------------------------------------------------------------------------------------------
@contextmanager
def _processes(count: int, work: Callable[..., Any], shared: Any) -> Iterator[ProcessPoolExecutor]:
    """Fresh processes; whatever goes wrong, none of them is left running."""
    context = _Watched()
    pool = ProcessPoolExecutor(count, context, _begin, (work, shared))
    try:
        yield pool
    except BrokenProcessPool:
        right = "a script that sweeps with jobs needs `if __name__ == '__main__':`; else try fewer jobs"
        raise Failed(f"a process ended before its work was done; {right}") from None
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in context.started:
            process.terminate()
        raise
    finally:
        pool.shutdown()


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


_WORK: list[Callable[[Any], Any]] = []


def _begin(work: Callable[[Any, Any], Any], shared: Any) -> None:
    """A process at its start: it is deaf to Ctrl-C, and ends when the one that started it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _WORK.append(lambda item: work(shared, item))


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _next(item: Any) -> Any:
    return _WORK[-1](item)


# -- cluster --------------------------------------------------------------------------------------------------------
def _on_cluster(
    work: Callable[[Shared, Item], Result], shared: Shared, items: Sequence[Item], address: str, tell: Told
) -> list[Result]:
    """Over the workers of a dask scheduler, which need lptn installed too."""
    spot = Spot(f"--cluster {address}")
    try:
        from distributed import Client
        from distributed import as_completed as as_finished
    except ImportError:
        right = "pip install 'lptn[cluster]', or use --jobs for processes on this machine"
        raise refuse(spot, "needs dask, which is not installed", right) from None
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise refuse(spot, f"no scheduler answers there ({error})", "start one with `dask scheduler`") from None
    with client:
        everywhere = client.scatter(shared, broadcast=True, hash=False)
        futures = [client.submit(work, everywhere, item, pure=False) for item in items]
        try:
            for done, future in enumerate(as_finished(futures), 1):
                future.result()
                tell(done / len(futures))
            return [future.result() for future in futures]
        finally:
            client.cancel(futures)
