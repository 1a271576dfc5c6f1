"""Many independent pieces of work: one after the other, over processes, or over a cluster; results in their order.

Processes are fresh ones, begun once for a whole command beside the one that begins them, which takes its part of the
work. However that one ends, they end too.
"""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, as_completed
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar

from network.platform.cluster import on_cluster
from network.platform.processes import Pool, pool_of
from network.platform.refusal import Spot, refuse

Item = TypeVar("Item")
Result = TypeVar("Result")
Told = Callable[[float], None]
_OPEN: ContextVar[Pool | None] = ContextVar("processes", default=None)
_CHECK: ContextVar[Told] = ContextVar("check", default=lambda share: None)


def run_all(
    work: Callable[[Item], Result], items: Sequence[Item], jobs: int = 1, tell: Told | None = None,
    cluster: str | None = None,
) -> list[Result]:  # fmt: skip
    """work(item) for every item. `work` can be pickled: a function of a module, or a partial of one, whose arguments
    go to every process once; tell is told the share that is done.

    Raises what `work` raises, Refused for processes or a cluster that cannot be had, Failed where a process ends by
    itself.
    """
    check, also = _CHECK.get(), tell or (lambda share: None)

    def say(share: float) -> None:
        check(share)
        also(share)

    if jobs < 1:
        raise refuse(Spot("--jobs"), f"{jobs} is not a number of processes", "give a whole number from 1")
    if cluster is not None:
        return on_cluster(work, items, cluster, say)
    if jobs == 1 or len(items) < 2:
        return list(_one_by_one(work, items, say))
    begun = _OPEN.get()
    with nullcontext(begun) if begun else pool_of(min(jobs, len(items))) as pool, pool.shelve(work) as shelf:
        return _Shared(pool, shelf, items, say).run(work)


def go_on() -> None:
    """Asks whether work that is parted into no pieces goes on; raises where it does not."""
    _CHECK.get()(0.0)


@contextmanager
def check_each(check: Told) -> Iterator[None]:
    """While it lasts, `check` is told of every piece of work that is done, and ends the others by raising."""
    token = _CHECK.set(check)
    try:
        yield
    finally:
        _CHECK.reset(token)


@contextmanager
def processes(jobs: int, ready: str) -> Iterator[None]:
    """While it lasts, what is to go over several processes goes over these; each loads a module, `ready`, at once.

    Raises Refused for processes that cannot be had.
    """
    if jobs < 2:
        yield
        return
    with pool_of(jobs) as pool:
        pool.load(ready)
        token = _OPEN.set(pool)
        try:
            yield
        finally:
            _OPEN.reset(token)


def _one_by_one(work: Callable[[Item], Result], items: Sequence[Item], say: Told) -> Iterator[Result]:
    for done, item in enumerate(items, 1):
        yield work(item)
        say(done / len(items))


class _Shared:
    """Items that are taken one by one, by other processes and by this one.

    They are packed before any work begins: what they share would change while another thread packs it.
    """

    def __init__(self, pool: Pool, shelf: Path, items: Sequence[Any], say: Told) -> None:
        self.pool, self.shelf, self.items, self.say = pool, shelf, items, say
        self.parcels = [pickle.dumps(item, pickle.HIGHEST_PROTOCOL) for item in items]
        self.left, self.lock, self.told = iter(range(len(items))), threading.Lock(), 0
        self.there: dict[int, Future[Any]] = {}

    def run(self, work: Callable[[Any], Any]) -> list[Any]:
        """Raises at the first that failed."""
        here: dict[int, Any] = {}
        try:
            for _ in range(self.pool.others):
                self.send()
            while (i := self.take()) is not None:
                here[i] = work(self.items[i])
                self.tell(len(here) + sum(future.done() for future in self.list_sent()))
            for done, future in enumerate(as_completed(self.list_sent()), len(here) + 1):
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
                self.there[i] = self.pool.submit(self.shelf, self.parcels[i])
        if i is not None:
            self.there[i].add_done_callback(self.send)

    def list_sent(self) -> list[Future[Any]]:
        with self.lock:
            return list(self.there.values())

    def stop(self) -> None:
        with self.lock:
            self.left = iter(())

    def tell(self, done: int) -> None:
        while self.told < done:
            self.told += 1
            self.say(self.told / len(self.items))
